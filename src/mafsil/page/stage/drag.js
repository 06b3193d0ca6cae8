// The tool led by the pointer: in the plane of the screen, with the control key turned instead.

import { Vector } from "../../scene/matrix.js";
import { quaternionOf, turned } from "../core/rotations.js";
import { isLed, ledTo } from "../loops/follow.js";
import { branchesAt, nearestRow, poseFrom, reasonAt, tipPose } from "../loops/reach.js";
import { searched } from "../loops/search.js";
import { handleAt, ledBy } from "./handles.js";

const GRIP = 22; // pixels around the tip
const SNAP = 0.005; // m: places of targets
const HALVINGS = 14; // of the way to a place that is not reached
const NEARLY_THERE = 1e-4; // m | rad: a tool as near as this is where it is wished
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

  /** What is under the pointer of the things that can be placed; -1 where nothing is. */
  gripAt({ clientX, clientY }) {
    const { stage } = this, { app } = stage, box = stage.canvas.getBoundingClientRect();
    return app.placed && app.player.scenery && !app.player.replay ? app.player.scenery.gripAt(clientX - box.left, clientY - box.top, stage, 0.6 * GRIP) : -1;
  }

  /** Whether the pointer is at the tool. */
  near({ clientX, clientY }) {
    if (!isLed(this.stage.app.store.arm)) return false;
    const box = this.stage.canvas.getBoundingClientRect(), { x, y } = this.place();
    return Math.hypot(clientX - box.left - x, clientY - box.top - y) < GRIP;
  }

  /** The handle of the tool under the pointer; null where there is none, or where the tool is not led. */
  handleAt({ clientX, clientY }) {
    const { stage } = this, box = stage.canvas.getBoundingClientRect();
    return stage.awake && !this.near({ clientX, clientY }) ? handleAt(this.place().T, clientX - box.left, clientY - box.top, stage) : null;
  }

  begin(event) {
    const handle = this.handleAt(event);
    if (handle) {
      this.start(event.clientX, event.clientY);
      this.going.handle = { ...handle, along: [0, 4, 8].map((r) => this.going.T[r + handle.axis]) };
      return;
    }
    const target = this.near(event) ? -1 : this.gripAt(event);
    if (target >= 0) {
      const position = this.stage.app.player.scenery.grips()[target], { camera, width, height } = this.stage;
      this.going = { target, x: event.clientX, y: event.clientY, position, placed: position, depth: camera.project(position, width, height).depth };
    }
    if (target >= 0 || !this.near(event)) return;
    this.start(event.clientX, event.clientY);
  }

  start(x, y) {
    const { app } = this.stage, { T, depth } = this.place();
    app.store.release();
    if (app.store.shown.replay) app.store.shown.replay.playing = false;
    this.going = { x, y, T, depth, position: [T[3], T[7], T[11]], quaternion: quaternionOf(T), row: this.rowAt(T) };
  }

  /** The branch that the arm is on. */
  rowAt(T) {
    const { store } = this.stage.app;
    return store.arm.kernels.branches ? nearestRow(store.state, branchesAt(store.state, T, store.arm), store.arm.settings) : -1;
  }

  move(event) {
    const { camera, height } = this.stage, { x, y, depth, position, quaternion } = this.going;
    const dx = event.clientX - x, dy = event.clientY - y;
    if (this.going.target >= 0) {
      const step = camera.reach(depth, height), raw = Vector.plus(Vector.plus(position, camera.right, dx * step), camera.up, -dy * step);
      this.going.placed = raw.map((value) => micrometres(Math.round(value / SNAP) * SNAP));
      this.stage.app.player.scenery.place(this.going.target, this.going.placed);
      this.stage.app.draw();
      return;
    }
    const { handle } = this.going;
    if (handle) {
      const way = ledBy(handle, dx, dy, event.shiftKey), { along } = handle;
      if (handle.kind === "shift") this.lead(Vector.plus(position, along, way), quaternion);
      else this.lead(position, turned(quaternion, along, way));
      return;
    }
    if (event.ctrlKey) {
      this.lead(position, turned(turned(quaternion, camera.up, dx * 0.01), camera.right, dy * 0.01));
      return;
    }
    const step = camera.reach(depth, height);
    this.lead(Vector.plus(Vector.plus(position, camera.right, dx * step), camera.up, -dy * step), quaternion);
  }

  /** One step by a key. */
  nudge([dx, dy], deep) {
    if (!isLed(this.stage.app.store.arm)) return;
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
    const T = poseFrom(given.position, given.quaternion);
    if (arm.settings.driven) {
      this.leadLoops(T);
      return;
    }
    const exact = store.shown.method !== "search" && arm.settings.rotates && arm.kernels.branches;
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
      const count = branches.filter((branch) => branch.within).length, nearest = row >= 0 && this.nearest(given, row);
      if (nearest) store.do("reach", { ...given, position: nearest, branch: row }, { gesture: true });
      store.show({ wish: T, refusal: reasonAt(T, branches, arm) ?? { key: "why_other_branches", values: { count } } });
    }
  }

  /** The same of a robot with loops: as near as its driven joints bring the tool. @param {number[]} T */
  leadLoops(T) {
    const { store } = this.stage.app, { q, miss } = ledTo(store.state, T, store.arm), held = miss > NEARLY_THERE;
    store.do("set_joints", { values: q }, { gesture: true });
    const here = tipPose(store.state, store.arm), away = Math.hypot(...[3, 7, 11].map((k) => T[k] - here[k]));
    store.show({ wish: held ? T : null, refusal: held ? { key: "why_held", values: { miss: Number(away.toPrecision(3)) } } : null });
  }

  /**
   * The farthest place that a branch reaches on the way to a wish from where the gesture began, or from where it has led:
   * the nearer one to the wish. So the tool goes along the boundary while the pointer is beyond it.
   *
   * @param {{position: number[], quaternion: number[]}} wish @param {number} row
   */
  nearest({ position, quaternion }, row) {
    const { store } = this.stage.app, { arm, base } = store, T = tipPose(store.state, arm);
    const reached = (place) => branchesAt(base, poseFrom(place, quaternion), arm)[row].within;
    const found = [this.going.position, [T[3], T[7], T[11]]].map((from) => from.map(micrometres)).filter(reached).map((from) => {
      let low = 0, high = 1, best = from;
      for (let k = 0; k < HALVINGS; k++) {
        const middle = (low + high) / 2, place = from.map((x, i) => micrometres(x + middle * (position[i] - x)));
        if (reached(place)) [low, best] = [middle, place];
        else high = middle;
      }
      return best;
    });
    const away = (place) => Math.hypot(...Vector.minus(place, position));
    return found.sort((a, b) => away(a) - away(b))[0] ?? null;
  }

  end() {
    if (!this.going) return;
    const { target, placed, position } = this.going;
    this.going = null;
    if (target >= 0) {
      if (placed !== position) this.stage.app.placed(target, placed);
      return;
    }
    this.stage.app.store.release(); // the reason stays until the next action
    this.stage.app.store.show({ wish: null });
  }
}
