// The robot as things to draw: its solids in a configuration, other branches as ghosts, frames, an ellipsoid.

import { Matrix, Vector } from "../../scene/matrix.js";
import { Shapes } from "../../scene/shapes.js";

const AXES = [[0.83, 0.24, 0.22], [0.25, 0.62, 0.32], [0.22, 0.44, 0.84]];
const TURNS = [[0.7071, 0, 0.7071, 0], [0.7071, -0.7071, 0, 0], [1, 0, 0, 0]];

/** Nothing is hidden and nothing is lit. */
export const NO_MARKS = { hidden: new Set(), lit: null };
const LIT = [1, 0.62, 0.2];
const lightened = (colour) => colour.map((part, k) => (k < 3 ? 0.35 * part + 0.65 * LIT[k] : part));
const METAL = [0.55, 0.58, 0.62, 1], THICK_ROD = 0.01; // share of the scene

/** Ways in which the outermost corners of a mesh are kept. */
const OUTWARD = [-1, 0, 1].flatMap((x) => [-1, 0, 1].flatMap((y) => [-1, 0, 1].map((z) => [x, y, z]))).filter((way) => way.filter(Boolean).length % 2);

/** A mesh of the renderer that knows its outermost corners, each once. */
function made(renderer, shape) {
  const { vertices } = shape, outermost = new Set();
  for (const [x, y, z] of OUTWARD) {
    let far = -Infinity, at = 0;
    for (let k = 0; k < vertices.length; k += 6) {
      const along = x * vertices[k] + y * vertices[k + 1] + z * vertices[k + 2];
      if (along > far) [far, at] = [along, k];
    }
    outermost.add(at);
  }
  return { ...renderer.mesh(shape), outermost: [...outermost].map((k) => Array.from(vertices.slice(k, k + 3))) };
}

/** Points around things that are drawn, in the world. @param {{mesh: object, model: ArrayLike<number>}[]} items @returns {number[][]} */
export function around(items) {
  return items
    .flatMap(({ mesh, model: m }) => (mesh.outermost ?? []).map(([x, y, z]) => [0, 1, 2].map((r) => m[r] * x + m[4 + r] * y + m[8 + r] * z + m[12 + r])));
}

/** Column after column, from 16 numbers row after row. */
export const columns = (T) => Float32Array.from({ length: 16 }, (_, k) => T[4 * (k % 4) + (k >> 2)]);

export class Figure {
  /**
   * @param {{mesh: (shape: object) => object}} renderer
   * @param {object} scene  bodies, surfaces, centre, size, floor
   */
  constructor(renderer, scene) {
    this.size = scene.size;
    this.renderer = renderer;
    this.parts = this.solids(scene);
    this.telescopes = scene.bodies.flatMap(({ rod }, link) => (rod ? [{ ...rod, link }] : []));
    this.shaft = renderer.mesh(Shapes.cylinder(this.size * 0.0042, this.size * 0.085));
    this.head = renderer.mesh(Shapes.cone(this.size * 0.0105, this.size * 0.03));
    this.tipOfPointer = renderer.mesh(Shapes.cone(this.size * 0.022, this.size * 0.06));
    this.stick = renderer.mesh(Shapes.cylinder(1, 1));
    this.ball = renderer.mesh(Shapes.of("sphere", [1]));
    const wide = this.size * 9, corners = [[-1, -1], [1, -1], [1, 1], [-1, 1]];
    const vertices = corners.flatMap(([x, y]) => [x * wide, y * wide, 0, 0, 0, 1]);
    this.ground = { mesh: renderer.mesh({ vertices, indices: [0, 1, 2, 0, 2, 3] }), model: Matrix.pose(0, 0, scene.floor, 1, 0, 0, 0) };
  }

  /** The solids of bodies, each with its mesh and the place of its body in the list; equal solids share a mesh. */
  solids({ bodies, surfaces }) {
    const { renderer } = this, meshes = (this.meshes ??= new Map()), shared = surfaces.map((surface) => made(renderer, Shapes.surface(surface)));
    const mesh = (kind, size) => {
      const key = kind + size.join();
      if (!meshes.has(key)) meshes.set(key, made(renderer, Shapes.of(kind, size)));
      return meshes.get(key);
    };
    return bodies.flatMap((body, link) => body.shapes.map((shape) => ({
      link,
      mesh: shape.kind === "surface" ? shared[shape.surface] : mesh(shape.kind, shape.size),
      local: Matrix.pose(...shape.pose),
      colour: shape.colour,
    })));
  }

  /**
   * Solids with their bodies at these poses (column after column), but those that are hidden.
   *
   * @param {object[]} solids @param {Float32Array[]} poses
   * @param {{hidden: Set<string>, lit: string | null}} marks @param {string} kind  before the number of a body in its key
   */
  placed(solids, poses, { hidden, lit } = NO_MARKS, kind = "link") {
    return solids.filter(({ link }) => !hidden.has(`${kind} ${link}`)).map(({ link, mesh, local, colour }) => ({
      mesh, colour: lit === `${kind} ${link}` ? lightened(colour) : colour, shadow: true, model: Matrix.multiply(poses[link], local)
    }));
  }

  /** The robot with its links at these poses (16 numbers each, row after row). */
  robot(poses, marks = NO_MARKS) {
    const placed = Array.from({ length: poses.length / 16 }, (_, k) => columns(poses.subarray(16 * k, 16 * k + 16)));
    const at = (m, [x, y, z]) => [0, 1, 2].map((r) => m[r] * x + m[4 + r] * y + m[8 + r] * z + m[12 + r]);
    const rods = this.telescopes.flatMap(({ parent, link, place, end, radius }) => {
      const from = at(placed[parent], place), to = at(placed[link], end);
      return Math.hypot(...Vector.minus(to, from)) > 1e-6 ? [{ ...this.rod(from, to, METAL, radius), shadow: true }] : [];
    });
    return [...this.placed(this.parts, placed, marks), ...rods];
  }

  /** The same as a ghost. */
  ghost(poses, colour) {
    return this.robot(poses).map((item) => ({ ...item, colour: [...colour.slice(0, 3), 0.3], shadow: false, ghost: true, gloss: 0 }));
  }

  /** Three arrows. @param {ArrayLike<number>} T  row after row */
  triad(T, how = {}) {
    return this.arrows(columns(T), how);
  }

  /** The same of a pose column after column. */
  arrows(T, { scale = 1, opacity = 1 } = {}) {
    const grown = Matrix.pose(0, 0, 0, 1, 0, 0, 0);
    for (const k of [0, 5, 10]) grown[k] = scale;
    const frame = Matrix.multiply(T, grown), shift = (z) => Matrix.pose(0, 0, this.size * z, 1, 0, 0, 0);
    return TURNS.flatMap((turn, axis) => {
      const colour = [...AXES[axis], opacity], along = Matrix.multiply(frame, Matrix.pose(0, 0, 0, ...turn));
      return [
        { mesh: this.shaft, model: Matrix.multiply(along, shift(0.0425)), colour },
        { mesh: this.head, model: Matrix.multiply(along, shift(0.085)), colour },
      ];
    });
  }

  /** A rod from one place to another. */
  rod(from, to, colour, radius = THICK_ROD * this.size) {
    const along = Vector.minus(to, from), long = Math.hypot(...along);
    const across = Vector.unit(Vector.cross(along, Math.abs(along[2]) < 0.9 * long ? [0, 0, 1] : [1, 0, 0])), third = Vector.unit(Vector.cross(along, across));
    const middle = from.map((x, k) => (x + to[k]) / 2);
    const thick = (way) => way.map((x) => x * radius);
    return { mesh: this.stick, colour, model: Float32Array.of(...thick(across), 0, ...thick(third), 0, ...along, 0, ...middle, 1) };
  }

  /** An arrow from one place to another. */
  pointer(from, to, colour) {
    const along = Vector.minus(to, from), long = Math.hypot(...along), neck = Vector.plus(to, along, -0.06 * this.size / long);
    const shaft = this.rod(from, neck, colour, 0.007 * this.size), turn = Array.from(shaft.model), thick = 0.007 * this.size;
    const model = Float32Array.of(
      ...turn.slice(0, 3).map((x) => x / thick), 0, ...turn.slice(4, 7).map((x) => x / thick), 0, ...along.map((x) => x / long), 0, ...neck,
      1
    );
    return [shaft, { mesh: this.tipOfPointer, colour, model }];
  }

  /** Rods between the origins of frames, which are drawn at them. @param {number[][]} chain  poses, row after row */
  skeleton(chain, colour) {
    const places = chain.map((T) => [T[3], T[7], T[11]]), thick = this.size * 0.016;
    const rods = places.slice(1).flatMap((to, k) => (Math.hypot(...Vector.minus(to, places[k])) > thick ? [this.rod(places[k], to, colour)] : []));
    return [...rods, ...places.map((place) => this.dot(place, thick, colour)), ...chain.slice(1).flatMap((T) => this.triad(T, { scale: 0.7 }))];
  }

  /** A ball about a place. */
  dot(place, radius, colour) {
    return { mesh: this.ball, colour, gloss: 0.4, model: Float32Array.of(radius, 0, 0, 0, 0, radius, 0, 0, 0, 0, radius, 0, ...place, 1) };
  }

  /** An ellipsoid about a place. @param {number[][]} axes  three half axes as vectors */
  ellipsoid(place, axes, colour) {
    return { mesh: this.ball, colour, gloss: 0, model: Float32Array.of(...axes[0], 0, ...axes[1], 0, ...axes[2], 0, ...place, 1) };
  }
}
