// Triangle meshes of the primitives: {vertices: [x y z nx ny nz ...], indices}.
import { Vector } from "./matrix.js";

const FINE = 40; // sides of what is round, unless `Shapes.sides` says fewer

export const Shapes = {
  of(kind, size) {
    if (kind === "box") return Shapes.box(size);
    if (kind === "sphere") return Shapes.lathe(Shapes.arc(size[0], 0, -90, 90, 20));
    if (kind === "cylinder") return Shapes.cylinder(size[0], size[1]);
    if (kind === "capsule") return Shapes.capsule(size[0], size[1]);
    return Shapes.cone(size[0], size[1]);
  },
  // Triangles of a file: corners that meet at less than 40 degrees share a normal, others keep an edge.
  surface({ low, step, points, faces, wide }) {
    const bytes = text => Uint8Array.from(atob(text), c => c.charCodeAt(0)).buffer;
    const grid = new Uint16Array(bytes(points)), corner = wide ? new Uint32Array(bytes(faces)) : new Uint16Array(bytes(faces));
    const at = grid.length / 3, count = corner.length / 3, p = new Float32Array(grid.length), flat = new Float32Array(3 * count),
      size = new Float32Array(count);
    for (let i = 0; i < p.length; i++) p[i] = low[i % 3] + step[i % 3] * grid[i];
    const first = new Uint32Array(at + 1), around = new Uint32Array(corner.length);
    for (const v of corner) first[v + 1]++;
    for (let v = 0; v < at; v++) first[v + 1] += first[v];
    const next = first.slice();
    for (let f = 0; f < count; f++) {
      const [a, b, c] = [0, 1, 2].map(k => 3 * corner[3 * f + k]);
      const n = Vector.cross([0, 1, 2].map(k => p[b + k] - p[a + k]), [0, 1, 2].map(k => p[c + k] - p[a + k])), l = Vector.length(n);
      for (let k = 0; k < 3; k++) { flat[3 * f + k] = l ? n[k] / l : 0; around[next[corner[3 * f + k]]++] = f; }
      size[f] = l;
    }
    const vertices = new Float32Array(18 * count), indices = new Uint32Array(3 * count);
    for (let i = 0; i < 3 * count; i++) {
      const v = corner[i], f = Math.floor(i / 3), n = [0, 0, 0];
      for (let j = first[v]; j < first[v + 1]; j++) {
        const g = around[j];
        const along = flat[3 * f] * flat[3 * g] + flat[3 * f + 1] * flat[3 * g + 1] + flat[3 * f + 2] * flat[3 * g + 2];
        if (along > 0.76) for (let k = 0; k < 3; k++) n[k] += size[g] * flat[3 * g + k];
      }
      const l = Vector.length(n) || 1;
      for (let k = 0; k < 3; k++) { vertices[6 * i + k] = p[3 * v + k]; vertices[6 * i + 3 + k] = n[k] / l; }
      indices[i] = i;
    }
    return { vertices, indices };
  },
  // Points (r, z, nr, nz) of a circle of radius r about (0, z), from one latitude to another [deg].
  arc(r, z, from, to, most, inset = 0) {
    const points = [], steps = Math.max(1, Math.round(most * Shapes.sides / FINE));
    for (let i = 0; i <= steps; i++) {
      const a = (from + (to - from) * i / steps) * Math.PI / 180;
      points.push([inset + r * Math.cos(a), z + r * Math.sin(a), Math.cos(a), Math.sin(a)]);
    }
    return points;
  },
  cylinder(r, length) {
    const h = length / 2, b = Math.min(r * 0.16, h * 0.3);
    return Shapes.lathe([[0, -h, 0, -1], ...Shapes.arc(b, b - h, -90, 0, 4, r - b), ...Shapes.arc(b, h - b, 0, 90, 4, r - b), [0, h, 0, 1]]);
  },
  capsule(r, length) {
    return Shapes.lathe([...Shapes.arc(r, -length / 2, -90, 0, 10), ...Shapes.arc(r, length / 2, 0, 90, 10)]);
  },
  cone(r, height) {
    const s = Math.hypot(r, height);
    return Shapes.lathe([[0, 0, 0, -1], [r, 0, 0, -1], [r, 0, height / s, r / s], [0, height, height / s, r / s]], 20);
  },
  // Surface of revolution about z.
  sides: FINE,
  lathe(profile, sides = Shapes.sides) {
    const vertices = [], indices = [], rows = profile.length;
    for (let k = 0; k <= sides; k++) {
      const a = 2 * Math.PI * k / sides, c = Math.cos(a), s = Math.sin(a);
      for (const [r, z, nr, nz] of profile) vertices.push(r * c, r * s, z, nr * c, nr * s, nz);
      if (k < sides) for (let i = 0; i + 1 < rows; i++) {
        const a0 = k * rows + i, b0 = a0 + rows;
        indices.push(a0, b0, a0 + 1, a0 + 1, b0, b0 + 1);
      }
    }
    return { vertices, indices };
  },
  // Box with rounded edges: points of the inner box pushed out along their normals.
  box(size) {
    const half = size.map(s => s / 2), b = Math.min(...half) * 0.14, vertices = [], indices = [];
    const steps = h => [-h, -h + b * 0.3, -h + b, h - b, h - b * 0.3, h];
    for (let axis = 0; axis < 3; axis++) for (const sign of [-1, 1]) {
      const u = (axis + 1) % 3, v = (axis + 2) % 3, us = steps(half[u]), vs = steps(half[v]), base = vertices.length / 6;
      for (const pu of us) for (const pv of vs) {
        const p = [0, 0, 0];
        p[axis] = sign * half[axis]; p[u] = pu; p[v] = pv;
        const inner = p.map((x, i) => Math.max(b - half[i], Math.min(half[i] - b, x)));
        const n = Vector.unit(Vector.minus(p, inner));
        vertices.push(...inner.map((x, i) => x + b * n[i]), ...n);
      }
      for (let i = 0; i < 5; i++) for (let j = 0; j < 5; j++) {
        const a = base + i * 6 + j;
        if (sign > 0) indices.push(a, a + 6, a + 1, a + 1, a + 6, a + 7);
        else indices.push(a, a + 1, a + 6, a + 1, a + 7, a + 6);
      }
    }
    return { vertices, indices };
  },
  // One axis of many frames, [position, direction] each, as thin three-sided sticks in a single mesh.
  sticks(axes, length, r) {
    const vertices = [], indices = [];
    for (const [p, along] of axes) {
      const stick = Shapes.tube([p, Vector.plus(p, along, length)], r, 3), base = vertices.length / 6;
      for (const x of stick.vertices) vertices.push(x);
      for (const i of stick.indices) indices.push(base + i);
    }
    return { vertices, indices };
  },
  // Round tube along points [[x, y, z], ...]; 6 * sides indices for each step, in order.
  tube(points, r, sides = 8) {
    const vertices = [], indices = [];
    let normal = null;
    points.forEach((p, i) => {
      const ahead = Vector.minus(points[Math.min(i + 1, points.length - 1)], points[Math.max(i - 1, 0)]);
      const along = Vector.length(ahead) > 1e-9 ? Vector.unit(ahead) : [0, 0, 1];
      let side = normal && Vector.minus(normal, along.map(x => x * Vector.dot(normal, along)));
      if (!side || Vector.length(side) < 1e-6) side = Vector.cross(along, Math.abs(along[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0]);
      normal = Vector.unit(side);
      const other = Vector.cross(along, normal);
      for (let k = 0; k < sides; k++) {
        const a = 2 * Math.PI * k / sides, n = [0, 1, 2].map(j => normal[j] * Math.cos(a) + other[j] * Math.sin(a));
        vertices.push(...Vector.plus(p, n, r), ...n);
        const here = i * sides + k, next = i * sides + (k + 1) % sides;
        if (i + 1 < points.length) indices.push(here, next, here + sides, next, next + sides, here + sides);
      }
    });
    return { vertices, indices };
  },
};
