// The robot as things to draw: its solids in a configuration, other branches as ghosts, frames, an ellipsoid.

import { Matrix, Vector } from "../../scene/matrix.js";
import { Shapes } from "../../scene/shapes.js";

const AXES = [[0.83, 0.24, 0.22], [0.25, 0.62, 0.32], [0.22, 0.44, 0.84]];
const TURNS = [[0.7071, 0, 0.7071, 0], [0.7071, -0.7071, 0, 0], [1, 0, 0, 0]];

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
    this.shaft = renderer.mesh(Shapes.cylinder(this.size * 0.0042, this.size * 0.085));
    this.head = renderer.mesh(Shapes.cone(this.size * 0.0105, this.size * 0.03));
    this.stick = renderer.mesh(Shapes.cylinder(this.size * 0.01, 1));
    this.ball = renderer.mesh(Shapes.of("sphere", [1]));
    const wide = this.size * 9, corners = [[-1, -1], [1, -1], [1, 1], [-1, 1]];
    const vertices = corners.flatMap(([x, y]) => [x * wide, y * wide, 0, 0, 0, 1]);
    this.ground = { mesh: renderer.mesh({ vertices, indices: [0, 1, 2, 0, 2, 3] }), model: Matrix.pose(0, 0, scene.floor, 1, 0, 0, 0) };
  }

  /** The solids of bodies, each with its mesh and the place of its body in the list; equal solids share a mesh. */
  solids({ bodies, surfaces }) {
    const { renderer } = this, meshes = new Map(), shared = surfaces.map((surface) => renderer.mesh(Shapes.surface(surface)));
    const mesh = (kind, size) => {
      const key = kind + size.join();
      if (!meshes.has(key)) meshes.set(key, renderer.mesh(Shapes.of(kind, size)));
      return meshes.get(key);
    };
    return bodies.flatMap((body, link) => body.shapes.map((shape) => ({
      link,
      mesh: shape.kind === "surface" ? shared[shape.surface] : mesh(shape.kind, shape.size),
      local: Matrix.pose(...shape.pose),
      colour: shape.colour,
    })));
  }

  /** Solids with their bodies at these poses (column after column). @param {Float32Array[]} poses */
  placed(solids, poses) {
    return solids.map(({ link, mesh, local, colour }) => ({ mesh, colour, shadow: true, model: Matrix.multiply(poses[link], local) }));
  }

  /** The robot with its links at these poses (16 numbers each, row after row). */
  robot(poses) {
    return this.placed(this.parts, Array.from({ length: poses.length / 16 }, (_, k) => columns(poses.subarray(16 * k, 16 * k + 16))));
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
  rod(from, to, colour) {
    const along = Vector.minus(to, from), long = Math.hypot(...along);
    const across = Vector.unit(Vector.cross(along, Math.abs(along[2]) < 0.9 * long ? [0, 0, 1] : [1, 0, 0])), third = Vector.unit(Vector.cross(along, across));
    const middle = from.map((x, k) => (x + to[k]) / 2);
    return { mesh: this.stick, colour, model: Float32Array.of(...across, 0, ...third, 0, ...along, 0, ...middle, 1) };
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
