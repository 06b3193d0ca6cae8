// The picture: draws what the state says whenever it has changed, turns with the pointer and with keys.

import { Camera } from "../../scene/camera.js";
import { FlatRenderer } from "../../scene/flat.js";
import { Renderer, drawsBySoftware } from "../../scene/renderer.js";
import { Shapes } from "../../scene/shapes.js";
import { tipEllipsoids } from "../core/ellipsoids.js";
import { hereOf, lifted } from "../core/state.js";
import { branchesAt, tipPose } from "../loops/reach.js";
import { dhChain, dhFrames } from "../core/dh.js";
import { ToolDrag } from "./drag.js";
import { Figure } from "./figure.js";

const FORCES = 0.25; // share of the scene that the largest force is drawn with
const NARROW = 520; // pixels: names of ghosts would hide them
const WORLD = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];

export class Stage {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {HTMLElement} labels  where the names of ghosts stand
   * @param {object} app  store, data, words
   */
  constructor(canvas, labels, app) {
    Object.assign(this, { canvas, labels, app });
    this.makeRenderer();
    this.figure = new Figure(this.renderer, app.data.scene);
    this.camera = new Camera(app.data.scene);
    this.drag = new ToolDrag(this);
    this.resized({ width: this.canvas.clientWidth, height: this.canvas.clientHeight });
    this.camera.home(this.width < 600);
    this.listen();
    this.readColours();
  }

  /** WebGL where there is a graphics processor, with little effort where there is none, else plain outlines. */
  makeRenderer() {
    try {
      if (location.hash === "#flat") throw new Error("asked for");
      const light = drawsBySoftware(this.canvas);
      if (light) this.freshCanvas();
      if (light) Shapes.sides = 16;
      this.renderer = new Renderer(this.canvas, { light });
      this.kind = light ? "light" : "full";
    } catch {
      this.freshCanvas();
      this.renderer = new FlatRenderer(this.canvas);
      this.kind = "flat";
    }
  }

  /** A canvas that nothing has been drawn on, in the place of the old one. */
  freshCanvas() {
    const fresh = this.canvas.cloneNode();
    this.canvas.replaceWith(fresh);
    this.canvas = fresh;
  }

  /** The picture has another size [CSS pixels]. */
  resized({ width, height }) {
    Object.assign(this, { width, height });
    this.renderer.shown = { width, height };
  }

  /** Colours of the page, as numbers. */
  readColours() {
    const style = getComputedStyle(document.documentElement);
    const colour = (name) => [1, 3, 5].map((i) => parseInt(style.getPropertyValue(name).trim().slice(i, i + 2), 16) / 255).concat(1);
    this.colours = Object.fromEntries(["accent", "floor", "grid", "s0", "s1", "s2", "s3", "s4", "s5", "s6", "s7"].map((name) => [name, colour(`--${name}`)]));
  }

  /** Everything to draw. */
  items() {
    const { store } = this.app, { shown, arm } = store, { figure } = this, state = shown.replay?.q ? { ...store.state, q: shown.replay.q, loop: false } : store.state;
    const poses = arm.kernels.link_poses(state.q)[0].slice(), tip = arm.kernels.forward_kinematics(state.q)[0].slice();
    const list = [...figure.robot(poses), ...figure.triad(tip), ...figure.triad(WORLD, { scale: 1.15 })];
    list.push(figure.dot([tip[3], tip[7], tip[11]], figure.size * 0.024, [...this.colours.accent.slice(0, 3), 0.7]));
    if (state.loop) list.push(...figure.ghost(arm.kernels.link_poses(state.goal)[0], this.colours.accent));
    if (shown.frames) for (let k = 0; k < poses.length; k += 16) list.push(...figure.triad(poses.subarray(k, k + 16), { scale: 0.7 }));
    if (shown.frame >= 0) list.push(...figure.triad(dhFrames(shown.table ?? this.app.data.dh, state.q)[shown.frame], { scale: 1.5 }));
    if (shown.table) list.push(...figure.skeleton(dhChain(shown.table, state.q), this.colours.s2));
    if (shown.replay?.ghost) list.push(...figure.ghost(arm.kernels.link_poses(shown.replay.ghost)[0], this.colours.accent));
    if (shown.wish) list.push(...figure.triad(shown.wish, { opacity: 0.5 }));
    if (shown.ellipsoid || shown.forces) list.push(...this.ellipsoids(tip));
    return list.concat(this.ghosts());
  }

  /** The other branches of the pose that is wished for, or of the tip's own, each with its name. */
  ghosts() {
    const { store, words, data } = this.app, { state, shown, arm } = store;
    this.named = [];
    if (!shown.ghosts || shown.replay || !arm.kernels.branches || state.loop) return [];
    const T = shown.wish ?? tipPose(state, arm), here = hereOf(state);
    return branchesAt(store.base, T, arm).filter((branch) => branch.within).flatMap((branch) => {
      const q = lifted(arm.settings, here, branch.q);
      if (!shown.wish && Math.hypot(...q.map((value, k) => value - here[k])) < 1e-6) return [];
      const poses = arm.kernels.link_poses(q)[0], colour = this.colours[`s${branch.row % 8}`], middle = Math.floor(poses.length / 32) * 16;
      this.named.push({ row: branch.row, place: [poses[middle + 3], poses[middle + 7], poses[middle + 11]], colour, text: data.branches[words.chosen][branch.code] });
      return this.figure.ghost(poses, colour);
    });
  }

  /**
   * Ellipsoids about the tip: velocities at a fifth of their length for joint rates of norm one; forces as long as fits,
   * for only their ratios are seen.
   */
  ellipsoids(tip) {
    const { state, shown, arm } = this.app.store, { figure, colours } = this, n = arm.settings.n;
    const { directions, velocities, forces } = tipEllipsoids(arm.kernels.jacobian_body(state.q)[0], n, tip);
    const thin = figure.size * 0.002, most = Math.max(...forces.map((force) => force ?? 0)) || 1;
    const drawn = (lengths, colour) => figure.ellipsoid([tip[3], tip[7], tip[11]], directions.map((way, k) => way.map((x) => x * Math.max(lengths[k], thin))), [...colour.slice(0, 3), 0.35]);
    const list = [];
    if (shown.ellipsoid) list.push(drawn(velocities.map((velocity) => 0.2 * velocity), colours.s0));
    if (shown.forces) list.push(drawn(forces.map((force) => FORCES * figure.size * ((force ?? 0) / most)), colours.s1));
    return list;
  }

  paint() {
    const { camera, figure, colours } = this, { scene } = this.app.data, items = this.items();
    const pitch = Math.pow(10, Math.floor(Math.log10(scene.size * 0.35)));
    this.renderer.render(items, { camera, eye: camera.eye, target: camera.target, centre: scene.centre, size: scene.size, ground: figure.ground, pitch, floor: colours.floor, lines: colours.grid });
    this.paintLabels();
  }

  /** Names of the ghosts over the picture; a click goes there. */
  paintLabels() {
    const { width, height } = this, grip = this.drag.place(), taken = [[grip.x, grip.y - 12], [grip.x, grip.y + 12]];
    while (this.labels.children.length > this.named.length) this.labels.lastChild.remove();
    this.named.forEach(({ row, place, colour, text }, k) => {
      const label = this.labels.children[k] ?? this.labels.appendChild(document.createElement("button"));
      const shown = width < NARROW ? String(row + 1) : text, half = width < NARROW ? 14 : Math.min(150, width / 2 - 4);
      let { x, y } = this.camera.project(place, width, height);
      x = Math.min(Math.max(x, half), width - half);
      while (taken.some(([a, b]) => Math.abs(a - x) < half && Math.abs(b - y) < 24)) y += 25;
      label.hidden = y > height - 14;
      taken.push([x, y]);
      label.type = "button";
      label.dir = "auto";
      if (label.textContent !== shown) label.textContent = shown;
      label.setAttribute("aria-label", text);
      label.title = text;
      label.dataset.row = row;
      label.style.left = `${x}px`;
      label.style.top = `${y}px`;
      label.style.borderColor = `rgb(${colour.slice(0, 3).map((part) => Math.round(255 * part)).join(" ")})`;
    });
  }

  listen() {
    const { canvas, camera, app } = this, held = new Map();
    const moved = (change) => { change(); app.draw(); };
    let gap = 0;
    canvas.addEventListener("pointerdown", (event) => {
      held.set(event.pointerId, event);
      canvas.setPointerCapture(event.pointerId);
      gap = 0;
      if (held.size === 1 && event.button === 0) this.drag.begin(event);
      else this.drag.end();
    });
    const release = (event) => { held.delete(event.pointerId); this.drag.end(); };
    canvas.addEventListener("pointerup", release);
    canvas.addEventListener("pointercancel", release);
    canvas.addEventListener("pointermove", (event) => {
      const before = held.get(event.pointerId);
      if (!before) { canvas.classList.toggle("grip", this.drag.near(event)); return; }
      const dx = event.clientX - before.clientX, dy = event.clientY - before.clientY;
      held.set(event.pointerId, event);
      if (this.drag.going) this.drag.move(event);
      else if (held.size === 2) {
        const [a, b] = [...held.values()], now = Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY);
        moved(() => { if (gap) camera.zoom(gap / now); gap = now; camera.slide(dx / 2, dy / 2); });
      } else if (event.buttons & 2 || event.shiftKey) moved(() => camera.slide(dx, dy));
      else moved(() => camera.turn(dx, dy));
    });
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      moved(() => camera.zoom(Math.exp(Math.max(-60, Math.min(60, event.deltaY)) * 0.003)));
    }, { passive: false });
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("keydown", (event) => this.key(event));
    this.labels.addEventListener("click", (event) => {
      const row = event.target.dataset?.row;
      if (row !== undefined) app.store.do("choose", { branch: Number(row) });
    });
    new ResizeObserver(([entry]) => { this.resized(entry.contentRect); app.draw(); }).observe(canvas);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => moved(() => this.readColours()));
  }

  /** Arrows turn, with the control key they move the tool: sideways and up, with the shift key to and fro. */
  key(event) {
    const ways = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }, way = ways[event.key];
    if (way && event.ctrlKey) this.drag.nudge(way, event.shiftKey);
    else if (way) this.camera.turn(14 * way[0], -14 * way[1]);
    else if (event.key === "+" || event.key === "=") this.camera.zoom(0.88);
    else if (event.key === "-") this.camera.zoom(1.14);
    else if (event.key === "Home") this.camera.home();
    else return;
    event.preventDefault();
    this.app.draw();
  }
}
