// The tool led by the pointer: in the plane of the screen, with the control key turned instead.

import { Vector } from "../../scene/matrix.js";
import { quaternionOf, turned } from "../core/rotations.js";
import { isLed, ledTo } from "../loops/follow.js";
import { branchesAt, nearestRow, poseFrom, reasonAt, tipPose } from "../loops/reach.js";
import { searched } from "../loops/search.js";
import { handleAt, ledBy } from "./handles.js";

const GRIP = 22; // pixels around the tip
const SNAP = 0.005; // m: steps of things that are placed
const UNMOVED = 1e-6; // m | 1: what is not led farther has not been placed
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
    return this.places ? app.player.scenery.gripAt(clientX - box.left, clientY - box.top, stage, 0.6 * GRIP) : -1;
  }

  /** Whether the pointer is at the tool. */
  near({ clientX, clientY }) {
    if (!isLed(this.stage.app.store.arm)) return false;
    const box = this.stage.canvas.getBoundingClientRect(), { x, y } = this.place();
    return Math.hypot(clientX - box.left - x, clientY - box.top - y) < GRIP;
  }

  /** What is held by arrows and rings: a thing of the job that was touched, else the tool. @returns {{T: number[], thing: number, turns: boolean} | null} */
  held() {
    const { app } = this.stage, { selected } = app.store.shown, thing = this.places ? app.player.scenery.things[selected] : undefined;
    if (thing) return { T: app.player.scenery.gripOf(selected), thing: selected, turns: thing.turns };
    const { driven } = app.store.arm.settings;
    return isLed(app.store.arm) ? { T: this.place().T, thing: -1, turns: !(driven && driven.length < 6) } : null;
  }

  /** Whether things of the job can be placed now. */
  get places() {
    const { app } = this.stage;
    return Boolean(app.placed && app.player.scenery && !app.player.replay);
  }

  /** The handle under the pointer; null where there is none. */
  handleAt(event) {
    const { stage } = this, box = stage.canvas.getBoundingClientRect(), held = this.held();
    if (!held || (held.thing < 0 && (!stage.awake || this.near(event)))) return null;
    if (held.thing >= 0 && ![-1, held.thing].includes(this.gripAt(event))) return null; // the dot of another is under the pointer
    return handleAt(held, event.clientX - box.left, event.clientY - box.top, stage);
  }

  begin(event) {
    const { store } = this.stage.app, handle = this.handleAt(event), held = this.held();
    if (handle) {
      this.start(event.clientX, event.clientY, held);
      this.going.handle = { ...handle, along: [0, 4, 8].map((r) => this.going.T[r + handle.axis]) };
      return;
    }
    const thing = this.near(event) ? -1 : this.gripAt(event);
    if (thing !== store.shown.selected) store.show({ selected: thing });
    if (thing >= 0 || this.near(event)) this.start(event.clientX, event.clientY, thing >= 0 ? this.held() : null);
  }

  /** A gesture begins. @param {{T: number[], thing: number} | null} held  what is led; the tool if null */
  start(x, y, held = null) {
    const { app, camera, width, height } = this.stage, { T, thing } = held ?? { T: this.place().T, thing: -1 }, position = [T[3], T[7], T[11]];
    this.going = { x, y, T, thing, position, quaternion: quaternionOf(T), depth: camera.project(position, width, height).depth };
    if (thing >= 0) return;
    app.store.release();
    if (app.store.shown.replay) app.store.shown.replay.playing = false;
    this.going.row = this.rowAt(T);
  }

  /** The branch that the arm is on. */
  rowAt(T) {
    const { store } = this.stage.app;
    return store.arm.kernels.branches ? nearestRow(store.state, branchesAt(store.state, T, store.arm), store.arm.settings) : -1;
  }

  move(event) {
    const { camera, height } = this.stage, { x, y, depth, position, quaternion, handle, thing } = this.going;
    const dx = event.clientX - x, dy = event.clientY - y, shifted = (...ways) => ways.reduce((at, [way, far]) => Vector.plus(at, way, far), position);
    if (handle) {
      const way = ledBy(handle, dx, dy, event.shiftKey), { along } = handle;
      if (handle.kind === "shift") this.lead(shifted([along, way]), quaternion);
      else this.lead(position, turned(quaternion, along, way));
    } else if (event.ctrlKey && thing < 0) this.lead(position, turned(turned(quaternion, camera.up, dx * 0.01), camera.right, dy * 0.01));
    else {
      const step = camera.reach(depth, height);
      this.lead(shifted([camera.right, dx * step], [camera.up, -dy * step]), quaternion);
    }
  }

  /** One step by a key. */
  nudge([dx, dy], deep) {
    const { camera, app } = this.stage, step = NUDGE * app.data.scene.size, held = this.held();
    if (!held) return;
    this.start(0, 0, held);
    const { position, quaternion } = this.going, way = deep ? camera.away : camera.up;
    this.lead(Vector.plus(Vector.plus(position, camera.right, dx * step), way, -dy * step), quaternion);
    this.end();
  }

  /** The tool at a pose if the arm can, else the wish and the reason why not. */
  lead(position, quaternion) {
    if (this.going.thing >= 0) {
      this.leadThing(position, quaternion);
      return;
    }
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

  /** A thing of the job, shifted in whole steps from where it was. */
  leadThing(position, quaternion) {
    const { going, stage: { app } } = this, { T } = going;
    const whole = position.map((x, k) => T[4 * k + 3] + Math.round((x - T[4 * k + 3]) / SNAP) * SNAP);
    const wanted = poseFrom(going.handle?.kind === "shift" ? position : whole, quaternion), placed = app.player.scenery.place(going.thing, wanted);
    going.placed = wanted.some((x, k) => Math.abs(x - T[k]) > UNMOVED) ? placed : null;
    app.draw();
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
    const { thing, placed } = this.going;
    this.going = null;
    if (thing >= 0) {
      if (placed) this.stage.app.placed(placed.thing, placed.T);
      return;
    }
    this.stage.app.store.release(); // the reason stays until the next action
    this.stage.app.store.show({ wish: null });
  }
}
