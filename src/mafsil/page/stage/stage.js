// The picture: draws what the state says whenever it has changed, turns with the pointer and with keys.

import { tipEllipsoids } from "../core/linear.js";
import { Vector } from "../../scene/matrix.js";
import { hereOf, lifted } from "../core/state.js";
import { isLed, tipJacobian } from "../loops/follow.js";
import { branchesAt, tipPose } from "../loops/reach.js";
import { dhChain, dhFrames } from "../core/dh.js";
import { branchName } from "../views/branches.js";
import { element, written } from "../views/elements.js";
import { Compass } from "./compass.js";
import { ToolDrag } from "./drag.js";
import { around } from "./figure.js";
import { drawHandles, drawLimits, drawLoads, isAwake } from "./handles.js";
import { Viewport } from "./viewport.js";

const FORCES = 0.25; // share of the scene that the largest force is drawn with
const NEWTONS = 40; // a push that is drawn half as long as any may be
const DOT = 27; // pixels between two numbers of ghosts
const WORLD = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];

export class Stage extends Viewport {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {HTMLElement} labels  where the names of ghosts stand
   * @param {object} app  store, data, words
   */
  constructor(canvas, labels, app) {
    super(canvas, app.data.scene);
    Object.assign(this, { labels, app });
    this.drag = new ToolDrag(this);
    this.compass = new Compass(document.getElementById("compass"), this, app.data.robot.gravity);
    this.home();
    labels.addEventListener("click", (event) => {
      const row = event.target.dataset?.row;
      if (row !== undefined) app.store.do("choose", { branch: Number(row) });
    });
  }

  /** The arm where it is, or all along its motion, and what else says that it is to be seen. */
  outermost() {
    const { store, joined } = this.app, along = joined.flatMap((one) => one.along?.() ?? []);
    const places = along.length ? along : [store.state.q], { link_poses } = store.arm.kernels;
    return [...places.flatMap((q) => around(this.figure.robot(link_poses(q)[0]))), ...joined.flatMap((one) => one.outermost?.() ?? [])];
  }

  /** The link under the pointer fills the picture, or everything where there is none. */
  focus({ offsetX, offsetY }) {
    const { camera, width, height, figure } = this, { state, arm } = this.app.store;
    const items = figure.robot(arm.kernels.link_poses(state.q)[0]);
    const places = [...new Set(figure.parts.map(({ link }) => link))].map((link) => items.filter((_, k) => figure.parts[k]?.link === link));
    const seen = places.map(around).map((points) => ({ points, places: camera.projected(points, width, height) }));
    const within = (places, way, at) => Math.min(...places.map((one) => one[way])) < at && at < Math.max(...places.map((one) => one[way]));
    const under = seen.filter(({ places }) => within(places, "x", offsetX) && within(places, "y", offsetY))
      .sort((a, b) => Math.min(...a.places.map((one) => one.depth)) - Math.min(...b.places.map((one) => one.depth)));
    if (!under.length) this.frame();
    else {
      this.framed = false;
      camera.frame(under[0].points, width / height);
    }
    this.changed();
  }

  /** Everything to draw. */
  items() {
    const { store } = this.app, { shown, arm } = store, { figure } = this, { state } = store;
    const poses = arm.kernels.link_poses(state.q)[0].slice(), tip = arm.kernels.forward_kinematics(state.q)[0].slice();
    const scale = (key) => (shown.lit === key ? 1.5 : 1), list = figure.robot(poses, shown);
    if (!shown.hidden.has("tip")) list.push(...figure.triad(tip, { scale: scale("tip") }));
    if (!shown.hidden.has("base")) list.push(...figure.triad(WORLD, { scale: 1.15 * scale("base") }));
    list.push(figure.dot([tip[3], tip[7], tip[11]], figure.size * 0.024, [...this.colours.accent.slice(0, 3), 0.7]));
    const held = this.drag.held();
    if (held && (held.thing >= 0 || this.awake || this.drag.going?.handle)) list.push(...drawHandles(held, this, this.drag.going?.handle ?? this.handle));
    if (shown.touched >= 0) list.push(...drawLimits(shown.touched, poses, this));
    if (shown.loads) list.push(...drawLoads(poses, this));
    if (state.loop) list.push(...figure.ghost(arm.kernels.link_poses(state.goal)[0], this.colours.accent));
    if (state.loop) list.push(...this.push(tip, state.push.slice(3)));
    if (shown.frames) for (let k = 0; k < poses.length; k += 16) list.push(...figure.triad(poses.subarray(k, k + 16), { scale: 0.7 }));
    if (shown.frame >= 0) list.push(...figure.triad(dhFrames(shown.table ?? this.app.data.dh, state.q)[shown.frame], { scale: 1.5 }));
    if (shown.table) list.push(...figure.skeleton(dhChain(shown.table, state.q), this.colours.s2));
    if (shown.preview) list.push(...figure.ghost(arm.kernels.link_poses(shown.preview)[0], this.colours.s0));
    if (shown.replay?.ghost) list.push(...figure.ghost(arm.kernels.link_poses(shown.replay.ghost)[0], this.colours.accent));
    if (shown.wish) list.push(...figure.triad(shown.wish, { opacity: 0.5 }), ...this.away(tip, shown.wish));
    if (shown.ellipsoid || shown.forces) list.push(...this.ellipsoids(tip));
    return list.concat(this.app.joined.flatMap((one) => one.items?.(this) ?? []), this.ghosts());
  }

  /** The force that pushes the tip, as an arrow that ends there. @param {number[]} force  in the tip's frame [N] */
  push(tip, force) {
    const size = Math.hypot(...force), { figure } = this;
    if (!size) return [];
    const along = [0, 1, 2].map((r) => force.reduce((sum, f, k) => sum + tip[4 * r + k] * f, 0) / size), to = [tip[3], tip[7], tip[11]];
    const from = Vector.plus(to, along, -figure.size * (0.1 + 0.4 * size / (size + NEWTONS)));
    return figure.pointer(from, to, this.colours.bad);
  }

  /** A thin line from the tool to where it is wished. */
  away(tip, wish) {
    const [from, to] = [tip, wish].map((T) => [T[3], T[7], T[11]]);
    return Math.hypot(...Vector.minus(to, from)) > 1e-4 ? [this.figure.rod(from, to, this.colours.bad, 0.0025 * this.figure.size)] : [];
  }

  /** The other branches of the pose that is wished for, or of the tip's own, each with its name. */
  ghosts() {
    const { store, words, data } = this.app, { state, shown, arm } = store;
    this.named = [];
    if (!(shown.ghosts || shown.peek >= 0) || shown.replay || !arm.kernels.branches || state.loop) return [];
    const T = shown.wish ?? tipPose(state, arm), here = hereOf(state);
    return branchesAt(store.base, T, arm).filter((branch) => branch.within && (shown.ghosts || branch.row === shown.peek)).flatMap((branch) => {
      const q = lifted(arm.settings, here, branch.q);
      if (!shown.wish && Math.hypot(...q.map((value, k) => value - here[k])) < 1e-6) return [];
      const poses = arm.kernels.link_poses(q)[0], colour = this.colours[`s${branch.row % 8}`], middle = Math.floor(poses.length / 32) * 16;
      this.named.push({
        row: branch.row, place: [poses[middle + 3], poses[middle + 7], poses[middle + 11]], colour,
        text: branchName(data.branches[words.chosen], branch)
      });
      return this.figure.ghost(poses, colour);
    });
  }

  /**
   * Ellipsoids about the tip: velocities at a fifth of their length for joint rates of norm one; forces as long as fits,
   * for only their ratios are seen.
   */
  ellipsoids(tip) {
    const { state, shown, arm } = this.app.store, { figure, colours } = this, { J, n } = tipJacobian(state.q, arm);
    const { directions, velocities, forces } = tipEllipsoids(J, n, tip);
    const thin = figure.size * 0.002, most = Math.max(...forces.map((force) => force ?? 0)) || 1;
    const drawn = (lengths, colour) => figure.ellipsoid(
      [tip[3], tip[7], tip[11]], directions.map((way, k) => way.map((x) => x * Math.max(lengths[k], thin))), [...colour.slice(0, 3), 0.35]
    );
    const list = [];
    if (shown.ellipsoid) list.push(drawn(velocities.map((velocity) => 0.2 * velocity), colours.s0));
    if (shown.forces) list.push(drawn(forces.map((force) => FORCES * figure.size * ((force ?? 0) / most)), colours.s1));
    return list;
  }

  /** The picture as it is seen, as a file. @returns {Promise<Blob>} */
  photograph() {
    this.draw(this.items(), true);
    const { canvas } = this, made = element("canvas", { width: canvas.width, height: canvas.height }), context = made.getContext("2d");
    const [top, low] = ["--stage-top", "--stage-low"].map((name) => getComputedStyle(document.documentElement).getPropertyValue(name));
    context.fillStyle = context.createLinearGradient(0, 0, 0, made.height);
    for (const [k, colour] of [top, low].entries()) context.fillStyle.addColorStop(k, colour);
    context.fillRect(0, 0, made.width, made.height);
    context.drawImage(canvas, 0, 0);
    return new Promise((done) => made.toBlob(done, "image/png"));
  }

  paint() {
    this.render(this.items());
    this.paintLabels();
    this.compass.paint();
  }

  /** Numbers of the ghosts over the picture, each beside all others, the tool and what else stands there; a click goes there. */
  paintLabels() {
    const { width, height } = this, grip = this.drag.place(), taken = this.named.length ? [[grip.x, grip.y, DOT / 2, DOT / 2], ...this.furniture()] : [];
    while (this.labels.children.length > this.named.length) this.labels.lastChild.remove();
    this.named.forEach(({ row, place, colour, text }, k) => {
      const label = this.labels.children[k] ?? this.labels.appendChild(document.createElement("button"));
      const { x, y } = this.camera.project(place, width, height), [left, top] = freePlace(x, y, width, height, taken);
      taken.push([left, top, DOT / 2, DOT / 2]);
      label.type = "button";
      written(label, String(row));
      label.setAttribute("aria-label", text);
      label.title = text;
      label.dataset.row = row;
      label.style.left = `${left}px`;
      label.style.top = `${top}px`;
      label.style.borderColor = `rgb(${colour.slice(0, 3).map((part) => Math.round(255 * part)).join(" ")})`;
    });
  }

  /** What else stands over the picture: middle and half the edges of each [pixels]. @returns {number[][]} */
  furniture() {
    const { canvas, labels } = this, from = canvas.getBoundingClientRect();
    return [...canvas.parentElement.children].filter((one) => one !== canvas && one !== labels && one.offsetWidth).map((one) => {
      const { left, top, width, height } = one.getBoundingClientRect();
      return [left - from.left + width / 2, top - from.top + height / 2, width / 2, height / 2];
    });
  }

  changed() {
    this.app?.draw();
  }

  grab(event) {
    this.drag.begin(event);
  }

  release() {
    this.drag.end();
  }

  hover(event) {
    const { x, y } = this.drag.place(), led = isLed(this.app.store.arm), before = [this.awake, this.handle?.kind, this.handle?.axis].join();
    this.awake = led && isAwake({ x, y }, event.offsetX, event.offsetY);
    this.handle = this.drag.handleAt(event);
    if ([this.awake, this.handle?.kind, this.handle?.axis].join() !== before) this.changed();
    this.canvas.classList.toggle("grip", Boolean(this.handle) || this.drag.near(event) || this.drag.gripAt(event) >= 0);
  }

  lead(event) {
    if (this.drag.going) this.drag.move(event);
    return Boolean(this.drag.going);
  }

  /** With the control key arrows move the tool: sideways and up, with the shift key to and fro. */
  key(event) {
    const ways = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }, way = ways[event.key];
    if (!way || !event.ctrlKey) return super.key(event);
    this.drag.nudge(way, event.shiftKey);
    event.preventDefault();
    this.app.draw();
  }
}

/** The nearest place to one in the picture where a dot covers none of the others. */
function freePlace(x, y, width, height, taken) {
  const inside = (at, size) => Math.min(Math.max(at, DOT / 2), size - DOT / 2);
  for (let ring = 0; ; ring++) for (let k = 0; k < Math.max(1, 8 * ring); k++) {
    const turn = (2 * Math.PI * k) / Math.max(1, 8 * ring), left = inside(x + ring * DOT * Math.cos(turn), width),
      top = inside(y + ring * DOT * Math.sin(turn), height);
    if (ring > 20 || taken.every(([a, b, u, v]) => Math.abs(a - left) >= u + DOT / 2 || Math.abs(b - top) >= v + DOT / 2)) return [left, top];
  }
}
