// What stands around the arm of a run: things that are carried, obstacles, the path of the tip, targets.

import { Matrix, Vector } from "../../scene/matrix.js";
import { Shapes } from "../../scene/shapes.js";
import { bytes } from "../core/kernels.js";
import { quaternionOf } from "../core/rotations.js";
import { NO_MARKS, around, columns } from "./figure.js";

const FEW_TARGETS = 12; // more are drawn as thin sticks, three meshes in all, however many there are
const RODS = 80; // of the path where outlines are drawn, which cannot be hollow
const AXES_SEEN = [[0.83, 0.24, 0.22, 0.62], [0.25, 0.62, 0.32, 0.62], [0.22, 0.44, 0.84, 0.62]];
const HERE = Matrix.pose(0, 0, 0, 1, 0, 0, 0);
const TUBE = 6 * 8; // indices of a step of the path

/** Numbers of single precision. @param {string} text  base64 */
export const floats = (text) => new Float32Array(bytes(text).buffer);

export class Scenery {
  /**
   * @param {import("page/stage/figure.js").Figure} figure
   * @param {object} tape  tips, reference, carried, fixed, scenery, targets; see `mafsil.report.page`
   * @param {boolean} flat  whether outlines are drawn
   */
  constructor(figure, tape, flat = false) {
    const { size, renderer } = figure;
    Object.assign(
      this,
      { figure, tape, flat, shown: true, tips: floats(tape.tips ?? ""), reference: floats(tape.reference ?? ""), forces: floats(tape.forces ?? "") }
    );
    this.solids = figure.solids(tape.scenery);
    this.carried = tape.carried.map(({ poses, first, end }) => ({ poses: floats(poses), first, end }));
    this.fixed = tape.fixed.map((pose) => Matrix.pose(...pose));
    this.points = Array.from({ length: tape.frames ?? 0 }, (_, k) => Array.from(this.tips.subarray(7 * k, 7 * k + 3)));
    if (this.points.length) this.path = renderer.mesh(Shapes.tube(this.points, size * 0.0032));
    const places = tape.targets.map(({ pose }) => Matrix.pose(...pose));
    this.few = places.length <= FEW_TARGETS ? places : [];
    this.many = places.length <= FEW_TARGETS || flat ? [] : AXES_SEEN.map((colour, axis) => ({
      colour,
      mesh: renderer.mesh(Shapes.sticks(
        places.map((T) => [Array.from(T.slice(12, 15)), Array.from(T.slice(4 * axis, 4 * axis + 3))]), size * 0.035, size * 0.0016
      )),
    }));
  }

  /** Pose of a row at a fractional frame: positions on a line, quaternions on a line and made unit again. */
  pose(rows, frame) {
    const last = rows.length / 7 - 1, i = Math.min(Math.floor(frame), last), j = Math.min(i + 1, last), f = frame - i;
    const a = rows.subarray(7 * i, 7 * i + 7), b = rows.subarray(7 * j, 7 * j + 7);
    const sign = a[3] * b[3] + a[4] * b[4] + a[5] * b[5] + a[6] * b[6] < 0 ? -1 : 1;
    const out = Array.from(a, (value, k) => value * (1 - f) + (k > 2 ? sign : 1) * b[k] * f);
    const norm = Math.hypot(...out.slice(3));
    return Matrix.pose(...out.map((value, k) => (k > 2 ? value / norm : value)));
  }

  /**
   * @param {number} frame  of the run, fractional
   * @param {ArrayLike<number>} tip  where the tip is, row after row: what it carries goes with it
   * @param {number[]} colour  of the path
   * @param {{hidden: Set<string>, lit: string | null}} marks
   */
  items(frame, tip, colour, marks = NO_MARKS) {
    const list = this.figure.placed(this.solids, this.poses(frame, tip), marks, "thing");
    this.few.forEach((place, k) => {
      if (!marks.hidden.has(`target ${k}`)) list.push(...this.figure.arrows(place, { scale: marks.lit === `target ${k}` ? 1.2 : 0.75, opacity: 0.62 }));
    });
    list.push(...this.trail(colour));
    if (!this.shown || !this.points.length) return list;
    const aim = this.pose(this.reference, frame);
    list.push(this.figure.dot(Array.from(aim.slice(12, 15)), this.figure.size * 0.0085, colour));
    for (const axis of this.many) list.push({ ...axis, model: HERE });
    return list.concat(this.flat ? this.rods(colour) : this.tube(frame, colour));
  }

  /** The path of a tip that is only planned. @param {number[][]} points */
  trace(points) {
    this.planned = { points, mesh: this.flat ? null : this.figure.renderer.mesh(Shapes.tube(points, this.figure.size * 0.0032)) };
  }

  /** The same to be drawn. */
  trail(colour) {
    if (!this.planned || !this.shown) return [];
    return this.flat ? this.rods(colour, this.planned.points) : [{ mesh: this.planned.mesh, model: HERE, colour: [...colour.slice(0, 3), 0.55], gloss: 0 }];
  }

  /** What touches the tip exerts on it, in its frame [N]. @param {number} frame  fractional */
  force(frame) {
    const k = Math.max(0, Math.min(Math.round(frame), this.forces.length / 3 - 1));
    return Array.from(this.forces.subarray(3 * k, 3 * k + 3));
  }

  /** Where everything around is. */
  poses(frame, tip) {
    if (!this.points.length) return [...this.carried.map(({ poses }) => this.pose(poses, 0)), ...this.fixed];
    const before = this.pose(this.tips, frame), now = columns(tip);
    const parts = this.carried.map(({ poses, first, end }) => {
      const pose = this.pose(poses, frame);
      return first <= frame && frame < end - 1 ? along(now, before, pose) : pose;
    });
    return [...parts, ...this.fixed];
  }

  /** What can be placed: targets, what stands around, parts. @returns {{kind: string, index: number, turns: boolean, leads?: number}[]} */
  get things() {
    return this.tape.things ?? [];
  }

  /** Pose of one of them, column after column. @param {number} k */
  poseOf(k) {
    const { kind, index } = this.things[k];
    if (kind === "target") return Matrix.pose(...this.tape.targets[index].pose);
    return kind === "around" ? this.fixed[index] : this.pose(this.carried[index].poses, 0);
  }

  /** The frame at which one of them is held, row after row: its own, in the middle of what is drawn of it. */
  gripOf(k) {
    const { kind, index } = this.things[k], T = this.poseOf(k), shapes = kind === "around" && this.tape.scenery.bodies[this.carried.length + index].shapes,
      middle = shapes?.length ? Matrix.multiply(T, Matrix.pose(...shapes[0].pose.slice(0, 3), 1, 0, 0, 0)) : T;
    return rows(middle);
  }

  /** A dot at each of them but targets, which have arrows. */
  gripDots(colour) {
    const seen = (thing, k) => (thing.kind === "target" ? [] : [columns(this.gripOf(k)).slice(12, 15)]);
    return this.things.flatMap(seen).map((at) => ({ ...this.figure.dot(Array.from(at), this.figure.size * 0.014, colour), over: true }));
  }

  /** The one of them at a place of the picture, if one is as near as this [pixels]; -1 where none is. */
  gripAt(x, y, { camera, width, height }, near) {
    const at = this.things.map((_, k) => [3, 7, 11].map((r) => this.gripOf(k)[r]));
    const away = camera.projected(at, width, height).map((one) => Math.hypot(one.x - x, one.y - y)), k = away.indexOf(Math.min(...away));
    return k >= 0 && away[k] < near ? k : -1;
  }

  /**
   * One of them with its grip at another pose; a part leads the target where it is taken, a target its parts.
   *
   * @param {number} k @param {number[]} T  of the grip, row after row
   * @returns {{thing: number, T: Float32Array}}  what is to be written: a target, or what stands around, with its pose
   */
  place(k, T) {
    const { kind, index, leads } = this.things[k], before = columns(this.gripOf(k)), change = (pose) => along(columns(T), before, pose);
    if (kind === "around") {
      this.fixed[index] = change(this.fixed[index]);
      return { thing: k, T: this.fixed[index] };
    }
    const thing = leads ?? k, target = this.things[thing].index, pose = change(Matrix.pose(...this.tape.targets[target].pose));
    for (const part of this.things.filter((one) => one.leads === thing).map((one) => this.carried[one.index])) {
      part.poses = Float32Array.from(sevenOf(change(this.pose(part.poses, 0))));
    }
    this.tape.targets[target].pose = sevenOf(pose);
    if (this.few[target]) this.few[target] = pose;
    return { thing, T: pose };
  }

  /** Where a thing begins. @param {number} k */
  placeOf(k) {
    return k < this.carried.length ? Array.from(this.carried[k].poses.subarray(0, 3)) : Array.from(this.fixed[k - this.carried.length].slice(12, 15));
  }

  /** Points of the path, of targets and of what is about as large as the scene. */
  outermost() {
    const { size } = this.figure, things = this.figure.placed(this.solids, [...this.carried.map(({ poses }) => this.pose(poses, 0)), ...this.fixed]);
    const near = things.map((one) => around([one]))
      .filter((points) => points.length && points.every((point) => points.every((other) => Math.hypot(...Vector.minus(point, other)) < 1.2 * size)));
    return [...near.flat(), ...this.points, ...this.tape.targets.map(({ pose }) => pose.slice(0, 3))];
  }

  /** The path of the tip: what lies behind in full colour, the rest faint. */
  tube(frame, colour) {
    const past = Math.min(Math.floor(frame), this.tape.frames - 1) * TUBE, rest = this.path.count - past, list = [];
    if (past > 0) list.push({ mesh: this.path, model: HERE, colour, count: past, gloss: 0 });
    if (rest > 0) list.push({ mesh: this.path, model: HERE, colour: [...colour.slice(0, 3), 0.32], first: past, count: rest, gloss: 0 });
    return list;
  }

  /** A path as some straight rods. */
  rods(colour, points = this.points) {
    const step = Math.max(1, Math.ceil(points.length / RODS)), few = points.filter((_, k) => k % step === 0 || k === points.length - 1);
    return few.slice(1).flatMap((to, k) => (Math.hypot(...Vector.minus(to, few[k])) > 1e-6 ? [this.figure.rod(few[k], to, colour)] : []));
  }
}

/** 16 numbers column after column, row after row; the same turns them back. */
const rows = (T) => Array.from({ length: 16 }, (_, k) => T[4 * (k % 4) + (k >> 2)]);

/** Position and quaternion of a pose column after column. */
const sevenOf = (T) => [...T.slice(12, 15), ...quaternionOf(rows(T))];

/** What was carried at one pose of the tip, with the tip at another: T_now T_before^-1 T_part, column after column. */
function along(now, before, part) {
  const back = new Float32Array(16), p = before.slice(12, 15);
  for (let i = 0; i < 3; i++) {
    for (let j = 0; j < 3; j++) back[4 * j + i] = before[4 * i + j];
    back[12 + i] = -(before[4 * i] * p[0] + before[4 * i + 1] * p[1] + before[4 * i + 2] * p[2]);
  }
  back[15] = 1;
  return Matrix.multiply(Matrix.multiply(now, back), part);
}
