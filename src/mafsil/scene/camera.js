// A camera that turns around a place: where it stands, what a point is on the screen, how far a pixel reaches.

import { Matrix, Vector } from "./matrix.js";

const ANGLE = 0.62; // of view [rad]
const FILLED = 0.74; // share of the picture that is filled by what it shows
const ABOVE = 0.03; // of the scene's size: the eye stays so far above the floor
const UPRIGHT = 1.57; // largest elevation [rad]: straight above there is no right and left

export class Camera {
  /** @param {{centre: number[], size: number, floor?: number}} scene */
  constructor({ centre, size, floor = -Infinity }) {
    Object.assign(this, { size, floor, target: [...centre], azimuth: -0.95, elevation: 0.36, distance: 3.05 * size });
  }

  turn(dx, dy) {
    this.look(this.azimuth - dx * 0.008, this.elevation + dy * 0.008);
  }

  /** From another side. */
  look(azimuth, elevation) {
    this.azimuth = azimuth;
    this.elevation = Math.max(-UPRIGHT, Math.min(UPRIGHT, elevation));
    this.rise();
  }

  slide(dx, dy) {
    const step = this.distance * 0.0011;
    this.target = Vector.plus(Vector.plus(this.target, this.right, -dx * step), [0, 0, 1], dy * step);
    this.rise();
  }

  zoom(factor) {
    this.distance = Math.max(this.size * 0.1, Math.min(this.size * 12, this.distance * factor));
    this.rise();
  }

  /** The eye above the floor, whatever it turns about. */
  rise() {
    this.target[2] = Math.max(this.floor, this.target[2]);
    const least = (this.floor + ABOVE * this.size - this.target[2]) / this.distance;
    if (least > -1) this.elevation = Math.max(this.elevation, Math.asin(Math.min(Math.sin(UPRIGHT), least)));
  }

  /**
   * Nearer or farther and aside until these points fill the picture, seen from the same side.
   *
   * @param {number[][]} points @param {number} aspect  width of the picture by its height
   */
  frame(points, aspect) {
    if (!points.length) return;
    for (let k = 0; k < 12; k++) {
      const seen = this.projected(points, 2 * aspect, 2);
      const [x, y] = ["x", "y"].map((way) => [Math.min(...seen.map((one) => one[way])), Math.max(...seen.map((one) => one[way]))]);
      const depth = seen.reduce((sum, one) => sum + one.depth, 0) / seen.length, pixel = this.reach(depth, 2);
      this.target = Vector.plus(Vector.plus(this.target, this.right, ((x[0] + x[1]) / 2 - aspect) * pixel), this.up, (1 - (y[0] + y[1]) / 2) * pixel);
      const share = Math.max((x[1] - x[0]) / (2 * aspect), (y[1] - y[0]) / 2) / FILLED;
      this.distance = Math.max(this.size * 0.1, this.distance + depth * (Math.max(0.5, Math.min(2, share)) - 1));
      this.rise();
    }
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
    return this.projected([point], width, height)[0];
  }

  /** The same of many points. */
  projected(points, width, height) {
    const m = this.matrix(width / height);
    return points.map(([x, y, z]) => {
      const at = (r) => m[r] * x + m[4 + r] * y + m[8 + r] * z + m[12 + r], depth = at(3);
      return { x: (at(0) / depth + 1) * width / 2, y: (1 - at(1) / depth) * height / 2, depth };
    });
  }

  /** How far the world moves with a pixel, at a depth. */
  reach(depth, height) {
    return 2 * depth * Math.tan(ANGLE / 2) / height;
  }
}
