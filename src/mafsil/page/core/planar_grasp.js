// Fingers on a polygon: their contacts, whether they resist every wrench, and the wrench that they cannot.

import { Vector } from "../../scene/matrix.js";

const NONE = 1e-9; // share of the sizes of two vectors below which their product is none

/** @typedef {{point: number[], normal: number[]}} Finger  point [m] and unit normal into the body */

/**
 * The place on a polygon's boundary at a length along it.
 *
 * @param {number[][]} corners  counter-clockwise [m]
 * @param {number} length  from the first corner [m]; any, the boundary is closed
 * @returns {Finger}
 */
export function fingerAt(corners, length) {
  const sides = corners.map((from, k) => ({ from, to: corners[(k + 1) % corners.length] })).map(({ from, to }) => ({
    from, way: [to[0] - from[0], to[1] - from[1]]
  }));
  const lengths = sides.map(({ way }) => Math.hypot(...way)), whole = lengths.reduce((a, b) => a + b);
  let left = ((length % whole) + whole) % whole, k = 0;
  while (k < sides.length - 1 && left > lengths[k]) left -= lengths[k++];
  const { from, way } = sides[k], [x, y] = way.map((part) => part / lengths[k]);
  return { point: [from[0] + x * left, from[1] + y * left].map((value) => Math.round(value * 1e6) / 1e6), normal: [-y, x] };
}

/** Length along the boundary of the place nearest to a point. @param {number[][]} corners @param {number[]} point */
export function lengthNear(corners, [px, py]) {
  let begin = 0, best = { distance: Infinity, length: 0 };
  corners.forEach(([x, y], k) => {
    const [u, v] = corners[(k + 1) % corners.length], long = Math.hypot(u - x, v - y);
    const along = Math.min(Math.max(((px - x) * (u - x) + (py - y) * (v - y)) / long, 0), long);
    const distance = Math.hypot(px - x - ((u - x) * along) / long, py - y - ((v - y) * along) / long);
    if (distance < best.distance) best = { distance, length: begin + along };
    begin += long;
  });
  return best.length;
}

/** Wrenches (m, f_x, f_y) along the edges of the friction cones, for a normal push of 1. @param {Finger[]} fingers */
export function coneWrenches(fingers, mu) {
  return fingers.flatMap(({ point: [x, y], normal: [a, b] }) => {
    const forces = mu > 0 ? [[a - mu * b, b + mu * a], [a + mu * b, b - mu * a]] : [[a, b]];
    return forces.map(([u, v]) => [x * v - y * u, u, v]);
  });
}

/**
 * Whether wrenches in the plane span all of them with positive weights.
 *
 * If they do not, some y != 0 has y . w >= 0 for all of them, and an extreme y is normal to two of them: so trying the
 * products of all pairs decides. Where only rounding would decide the answer is no.
 *
 * @param {number[][]} wrenches  (m, f_x, f_y)
 * @returns {{closed: boolean, unresisted: number[] | null, margin: number}}
 *   unresisted: an external wrench of length 1 that they cannot balance, in the middle of all extreme ones;
 *   margin: radius of the largest ball about the origin inside their hull, 0 if not closed
 *
 * Reference: Lynch and Park, Modern Robotics, sec. 12.1.3 and 12.1.7; Ferrari and Canny, Planning optimal grasps, 1992.
 */
export function planarClosure(wrenches) {
  const size = (w) => Math.hypot(...w), largest = Math.max(0, ...wrenches.map(size));
  const refuses = (y) => wrenches.every((w) => Vector.dot(y, w) >= -NONE * largest);
  const rays = [];
  wrenches.forEach((v, i) => {
    for (const w of wrenches.slice(i + 1)) {
      const normal = Vector.cross(v, w), long = size(normal);
      if (long > NONE * largest * largest) rays.push(normal.map((x) => x / long), normal.map((x) => -x / long));
    }
  });
  if (!rays.length) rays.push(...acrossAll(wrenches));
  const refused = rays.filter(refuses);
  if (!refused.length) return { closed: true, unresisted: null, margin: hullRadius(wrenches) };
  const middle = refused.reduce((a, b) => Vector.plus(a, b)), unresisted = size(middle) > 1e-6 ? Vector.unit(middle) : refused[0];
  return { closed: false, unresisted, margin: 0 };
}

/** Where all wrenches lie on one line, or there are none: directions across. */
function acrossAll(wrenches) {
  const [w] = wrenches;
  if (!w) return [[0, 0, -1]];
  const least = w.map(Math.abs).indexOf(Math.min(...w.map(Math.abs)));
  return [Vector.unit(Vector.cross(w, [0, 1, 2].map((k) => Number(k === least))))];
}

/** Distance of the nearest facet of the hull from the origin inside it: a plane of three with all on one side. */
function hullRadius(wrenches) {
  let nearest = Infinity;
  wrenches.forEach((a, i) => wrenches.slice(i + 1).forEach((b, j) => {
    for (const c of wrenches.slice(i + j + 2)) {
      const normal = Vector.cross(Vector.minus(b, a), Vector.minus(c, a)), long = Math.hypot(...normal);
      if (long < NONE) continue;
      const offset = Vector.dot(normal, a) / long, side = Math.sign(offset) || 1;
      if (Math.abs(offset) < nearest && wrenches.every((w) => side * (Vector.dot(normal, w) / long - offset) <= NONE)) nearest = Math.abs(offset);
    }
  }));
  return nearest;
}

/** The grasp as Python. @param {Finger[]} fingers @param {number} mu */
export function graspPython(fingers, mu) {
  const lines = fingers.map(({ point, normal }) => `    mf.Contact((${point.join(", ")}), (${normal.join(", ")}), ${mu}),`);
  return ["import mafsil as mf", "", "grasp = mf.Grasp([", ...lines, "])", "print(grasp.closure().explain())", ""].join("\n");
}
