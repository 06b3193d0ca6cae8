// The tool led by the pointer: in the plane of the screen, with the control key turned instead.

import { Vector } from "../../scene/matrix.js";
import { quaternionOf, turned } from "../core/rotations.js";
import { branchesAt, nearestRow, poseFrom, reasonAt, tipPose } from "../loops/reach.js";
import { searched } from "../loops/search.js";

const GRIP = 26; // pixels around the tip
const NUDGE = 0.01; // share of the scene's size that a key moves
const micrometres = (x) => Math.round(x * 1e6) / 1e6;
const fine = (x) => Math.round(x * 1e9) / 1e9;

export class ToolDrag {
  /** @param {object} stage */
  constructor(stage) {
    this.stage = stage;
    this.going = null;
  }

  /** The tip in the picture. */
  place() {
    const { camera, app, width, height } = this.stage, T = tipPose(app.store.state, app.store.arm);
    return { T, ...camera.project([T[3], T[7], T[11]], width, height) };
  }

  /** Whether the pointer is at the tool. */
  near({ clientX, clientY }) {
    if (this.stage.app.store.arm.settings.driven) return false; // the tool of a robot with loops is not led
    const box = this.stage.canvas.getBoundingClientRect(), { x, y } = this.place();
    return Math.hypot(clientX - box.left - x, clientY - box.top - y) < GRIP;
  }

  begin(event) {
    if (!this.near(event)) return;
    this.start(event.clientX, event.clientY);
  }

  start(x, y) {
    const { app } = this.stage, { T, depth } = this.place();
    app.store.release();
    if (app.store.shown.replay) app.store.shown.replay.playing = false;
    this.going = { x, y, depth, position: [T[3], T[7], T[11]], quaternion: quaternionOf(T), row: this.rowAt(T) };
  }

  /** The branch that the arm is on. */
  rowAt(T) {
    const { store } = this.stage.app;
    return store.arm.kernels.branches ? nearestRow(store.state, branchesAt(store.state, T, store.arm), store.arm.settings) : -1;
  }

  move(event) {
    const { camera, height } = this.stage, { x, y, depth, position, quaternion } = this.going;
    const dx = event.clientX - x, dy = event.clientY - y;
    if (event.ctrlKey) {
      this.lead(position, turned(turned(quaternion, camera.up, dx * 0.01), camera.right, dy * 0.01));
      return;
    }
    const step = camera.reach(depth, height);
    this.lead(Vector.plus(Vector.plus(position, camera.right, dx * step), camera.up, -dy * step), quaternion);
  }

  /** One step by a key. */
  nudge([dx, dy], deep) {
    if (this.stage.app.store.arm.settings.driven) return;
    const { camera, app } = this.stage, step = NUDGE * app.data.scene.size;
    this.start(0, 0);
    const { position, quaternion } = this.going, way = deep ? camera.away : camera.up;
    this.lead(Vector.plus(Vector.plus(position, camera.right, dx * step), way, -dy * step), quaternion);
    this.end();
  }

  /** The tool at a pose if the arm can, else the wish and the reason why not. */
  lead(position, quaternion) {
    const { store } = this.stage.app, { arm } = store;
    const given = { position: position.map(micrometres), quaternion: quaternion.map(fine) };
    const T = poseFrom(given.position, given.quaternion), exact = store.shown.method !== "search" && arm.settings.rotates && arm.kernels.branches;
    if (!exact) {
      const { reason } = searched(store.base, T, arm);
      if (!reason) store.do("search", given, { gesture: true });
      store.show({ wish: reason ? T : null, refusal: reason });
      return;
    }
    const branches = branchesAt(store.base, T, arm), { row } = this.going;
    if (row >= 0 && branches[row].within) {
      store.do("reach", { ...given, branch: row }, { gesture: true });
      store.show({ wish: null, refusal: null });
    } else {
      const count = branches.filter((branch) => branch.within).length;
      store.show({ wish: T, refusal: reasonAt(T, branches, arm) ?? { key: "why_other_branches", values: { count } } });
    }
  }

  end() {
    if (!this.going) return;
    this.going = null;
    this.stage.app.store.release(); // the reason stays until the next action
    this.stage.app.store.show({ wish: null });
  }
}
