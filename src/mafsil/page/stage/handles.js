// What the tool is held by: arrows that shift it and rings that turn it; and what is seen at the joints: the limits of
// the one that is touched, the efforts that hold the arm still.

import { Vector } from "../../scene/matrix.js";
import { hereOf } from "../core/state.js";
import { heldEfforts } from "../views/gravity.js";

const LONG = 84, WIDE = 62, NEAR = 8; // pixels: arrows, radius of rings, distance at which one is taken
const AWAKE = 150; // pixels around the tip within which handles are seen
const STEPS = 40, PIECE = 0.18; // places of a ring; angle of a piece of an arc [rad]
const SNAPS = { shift: 0.005, turn: Math.PI / 36 }; // m, rad
const NEARLY = 0.05; // share of a range that counts as its end
const HANDLES = [[0.83, 0.24, 0.22], [0.25, 0.62, 0.32], [0.22, 0.44, 0.84]];

const columnOf = (T, k) => [T[k], T[4 + k], T[8 + k]];
const overAll = (items) => items.map((item) => ({ ...item, over: true }));
const originOf = (T) => [T[3], T[7], T[11]];
/** A point of a circle about a place, in the plane of two unit vectors. */
const onCircle = (centre, u, v, radius, angle) => Vector.plus(Vector.plus(centre, u, radius * Math.cos(angle)), v, radius * Math.sin(angle));
const sideways = (axis) => Vector.unit(Vector.cross(axis, Math.abs(axis[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0]));

/** The handles of what is held: each with the points of its line. @param {{T: ArrayLike<number>, turns: boolean}} held @param {object} stage */
function handlesOf({ T, turns: turning }, { camera, width, height }) {
  const at = originOf(T), pixel = camera.reach(camera.project(at, width, height).depth, height);
  const shifts = [0, 1, 2].map((axis) => ({ kind: "shift", axis, points: [0.35, 1].map((share) => Vector.plus(at, columnOf(T, axis), share * LONG * pixel)) }));
  const turns = (turning ? [0, 1, 2] : []).map((axis) => ({
    kind: "turn", axis,
    points: Array.from(
      { length: STEPS + 1 },
      (_, k) => onCircle(at, columnOf(T, (axis + 1) % 3), columnOf(T, (axis + 2) % 3), WIDE * pixel, 2 * Math.PI * k / STEPS)
    )
  }));
  return [...shifts, ...turns];
}

/** How far a place of the picture is from a line of it, and which piece is nearest [pixels]. */
function awayFrom(x, y, points) {
  let best = { away: Infinity, piece: 0 };
  for (let k = 0; k + 1 < points.length; k++) {
    const [a, b] = [points[k], points[k + 1]], long = Math.hypot(b.x - a.x, b.y - a.y);
    const share = long ? Math.max(0, Math.min(1, ((x - a.x) * (b.x - a.x) + (y - a.y) * (b.y - a.y)) / (long * long))) : 0;
    const away = Math.hypot(a.x + share * (b.x - a.x) - x, a.y + share * (b.y - a.y) - y);
    if (away < best.away) best = { away, piece: k };
  }
  return best;
}

/**
 * The handle under the pointer: its axis, and how far the picture moves with a metre or a radian there [pixels].
 *
 * @param {{T: ArrayLike<number>, turns: boolean}} held @param {number} x @param {number} y @param {object} stage
 * @returns {{kind: "shift" | "turn", axis: number, flow: number[]} | null}
 */
export function handleAt(held, x, y, stage) {
  const { camera, width, height } = stage;
  const found = handlesOf(held, stage).map((one) => ({
    ...one, ...awayFrom(x, y, camera.projected(one.points, width, height))
  })).filter(({ away }) => away < NEAR).sort((a, b) => a.away - b.away)[0];
  if (!found) return null;
  const { kind, axis, points, piece } = found, [a, b] = camera.projected(points.slice(piece, piece + 2), width, height);
  const length = kind === "shift" ? Math.hypot(...Vector.minus(points[1], points[0])) : 2 * Math.PI / STEPS;
  return { kind, axis, flow: [(b.x - a.x) / length, (b.y - a.y) / length] };
}

/** How far a handle was led by so many pixels [m | rad]; in whole steps where it snaps. */
export function ledBy({ kind, flow: [u, v] }, dx, dy, snaps) {
  const way = (dx * u + dy * v) / Math.max(1e-9, u * u + v * v);
  return snaps ? Math.round(way / SNAPS[kind]) * SNAPS[kind] : way;
}

/** Whether handles are seen: the pointer is near, or leads. */
export const isAwake = (tip, x, y) => Math.hypot(x - tip.x, y - tip.y) < AWAKE;

/** Arrows and rings of what is held, the one that is pointed at stronger. @param {object | null} lit */
export function drawHandles(held, stage, lit) {
  const { figure } = stage, thick = figure.size * 0.0035;
  return overAll(handlesOf(held, stage).flatMap(({ kind, axis, points }) => {
    const strong = lit && lit.kind === kind && lit.axis === axis, colour = [...HANDLES[axis], strong ? 1 : 0.55];
    if (kind === "shift") return figure.pointer(originOf(held.T), points[1], [...HANDLES[axis], 1]);
    return points.slice(1).map((to, k) => figure.rod(points[k], to, colour, strong ? 1.8 * thick : thick));
  }));
}

/** Rods along an arc. */
function arcRods(figure, { centre, u, v, radius }, from, to, colour, thick = 0.004) {
  const count = Math.max(1, Math.ceil(Math.abs(to - from) / PIECE)), points = Array.from(
    { length: count + 1 }, (_, k) => onCircle(centre, u, v, radius, from + (to - from) * k / count)
  );
  return points.slice(1).map((end, k) => figure.rod(points[k], end, colour, thick * figure.size));
}

/** Where a joint is: its middle, its axis and a direction that goes with its link. */
function frameOf(joint, poses) {
  const T = poses.subarray(16 * joint.link, 16 * joint.link + 16),
    turned = (way) => [0, 1, 2].map((r) => T[4 * r] * way[0] + T[4 * r + 1] * way[1] + T[4 * r + 2] * way[2]);
  const axis = turned(joint.axis), u = turned(sideways(joint.axis));
  return { centre: originOf(T), axis, u, v: Vector.cross(axis, u) };
}

/**
 * The range of a joint, red at its ends, and where in it the joint is.
 *
 * @param {number} k @param {Float32Array} poses  of the links @param {object} stage
 */
export function drawLimits(k, poses, { figure, colours, app: { store, data } }) {
  const joint = data.robot.joints[k], { lower, upper } = store.arm.settings, here = hereOf(store.state)[k], frame = frameOf(joint, poses),
    radius = 0.17 * figure.size;
  const bounded = lower[k] !== null && upper[k] !== null, free = joint.prismatic ? 0.3 * figure.size : Math.PI;
  const [low, high] = bounded ? [lower[k] - here, upper[k] - here] : [-free, free], end = bounded ? NEARLY * (high - low) : 0,
    plain = [...colours.s0.slice(0, 3), 0.9];
  const parts = [
    [low, low + end, colours.bad], [low + end, high - end, plain], [high - end, high, colours.bad]
  ].filter(([from, to]) => to > from), hot = bounded && (low > -end || high < end);
  if (joint.prismatic) {
    const at = (way) => Vector.plus(Vector.plus(frame.centre, frame.u, radius), frame.axis, way);
    return overAll([
      ...parts.map(([from, to, colour]) => figure.rod(at(from), at(to), colour, 0.006 * figure.size)),
      figure.dot(at(0), 0.016 * figure.size, hot ? colours.bad : colours.accent)
    ]);
  }
  const ring = { ...frame, radius }, needle = figure.rod(
    frame.centre, onCircle(frame.centre, frame.u, frame.v, 1.12 * radius, 0), hot ? colours.bad : colours.accent, 0.005 * figure.size
  );
  const sweep = parts.map(([from, to, colour]) => [Math.max(from, -2 * Math.PI), Math.min(to, 2 * Math.PI), colour]);
  return overAll([...sweep.flatMap(([from, to, colour]) => arcRods(figure, ring, from, to, colour, 0.006)), needle]);
}

/** Efforts that hold the arm still: a moment as an arc about its joint, a force along it, as large as its share of the motor. */
export function drawLoads(poses, { figure, colours, app: { store, data } }) {
  const { motors, efforts } = heldEfforts(store, data), { effort } = store.arm.settings, most = Math.max(
    1, ...Array.from(efforts, Math.abs).filter(Number.isFinite)
  );
  return overAll(motors.flatMap((k, at) => {
    const joint = data.robot.joints[k], share = efforts[at] / (effort[k] ?? most), frame = frameOf(joint, poses), size = 0.13 * figure.size;
    if (!Number.isFinite(share) || Math.abs(share) < 0.01) return [];
    const colour = Math.abs(share) > 1 ? colours.bad : colours.s4, way = Math.sign(share) * Math.min(1, Math.abs(share));
    if (joint.prismatic) return figure.pointer(frame.centre, Vector.plus(frame.centre, frame.axis, 2 * way * size), colour);
    const ring = { ...frame, radius: size }, sweep = 0.5 * Math.sign(way) + 4.5 * way, tip = onCircle(frame.centre, frame.u, frame.v, size, sweep);
    const tangent = Vector.plus(Vector.plus([0, 0, 0], frame.u, -Math.sin(sweep) * Math.sign(way)), frame.v, Math.cos(sweep) * Math.sign(way));
    return [
      ...arcRods(figure, ring, 0, sweep, colour, 0.006),
      ...figure.pointer(Vector.plus(tip, tangent, -0.01 * size), Vector.plus(tip, tangent, 0.065 * figure.size), colour)
    ];
  }));
}
