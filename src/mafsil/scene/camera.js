// A camera that turns around a place: where it stands, what a point is on the screen, how far a pixel reaches.

import { Matrix, Vector } from "./matrix.js";

const ANGLE = 0.62; // of view [rad]

export class Camera {
  /** @param {{centre: number[], size: number}} scene */
  constructor({ centre, size }) {
    this.centre = centre;
    this.size = size;
    this.home();
  }

  /** Where it begins. @param {boolean} narrow  the picture is higher than wide */
  home(narrow = false) {
    this.target = [...this.centre];
    this.azimuth = -0.95;
    this.elevation = 0.36;
    this.distance = this.size * (narrow ? 3.9 : 3.05);
  }

  turn(dx, dy) {
    this.azimuth -= dx * 0.008;
    this.elevation = Math.max(-0.25, Math.min(1.54, this.elevation + dy * 0.008));
  }

  slide(dx, dy) {
    const step = this.distance * 0.0011;
    this.target = Vector.plus(Vector.plus(this.target, this.right, -dx * step), [0, 0, 1], dy * step);
  }

  zoom(factor) {
    this.distance = Math.max(this.size * 0.35, Math.min(this.size * 12, this.distance * factor));
  }

  get away() {
    const c = Math.cos(this.elevation);
    return [c * Math.cos(this.azimuth), c * Math.sin(this.azimuth), Math.sin(this.elevation)];
  }

  get eye() {
    return Vector.plus(this.target, this.away, this.distance);
  }

  get right() {
    return [-Math.sin(this.azimuth), Math.cos(this.azimuth), 0];
  }

  get up() {
    return Vector.cross(this.away, this.right);
  }

  /** From the world to the screen, as for WebGL. */
  matrix(aspect) {
    const lens = Matrix.perspective(ANGLE, aspect, this.size * 0.02, this.size * 40);
    return Matrix.multiply(lens, Matrix.lookAt(this.eye, this.target, [0, 0, 1]));
  }

  /** Place of a point in a picture of this size [pixels], and how far it is. @returns {{x: number, y: number, depth: number}} */
  project(point, width, height) {
    const m = this.matrix(width / height), at = (r) => m[r] * point[0] + m[4 + r] * point[1] + m[8 + r] * point[2] + m[12 + r];
    const depth = at(3);
    return { x: (at(0) / depth + 1) * width / 2, y: (1 - at(1) / depth) * height / 2, depth };
  }

  /** How far the world moves with a pixel, at a depth. */
  reach(depth, height) {
    return 2 * depth * Math.tan(ANGLE / 2) / height;
  }
}
