// One still robot, to be looked at from all sides.

import { Matrix } from "../../scene/matrix.js";
import { Viewport } from "../../page/stage/viewport.js";
import { floats } from "./scenery.js";

class Still extends Viewport {
  constructor(canvas, scene) {
    super(canvas, scene);
    const poses = floats(scene.poses), at = (k) => Matrix.pose(...poses.subarray(7 * k, 7 * k + 7));
    this.items = [...this.figure.placed(this.figure.parts, scene.bodies.map((_, k) => at(k))), ...this.figure.arrows(Matrix.pose(...scene.tip)), ...this.figure.arrows(Matrix.pose(0, 0, 0, 1, 0, 0, 0), { scale: 1.15 })];
    this.changed();
  }

  changed() {
    if (!this.items || this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => { this.waiting = false; this.render(this.items); });
  }
}

globalThis.still = new Still(document.getElementById("scene"), JSON.parse(document.getElementById("data").textContent).scene);
