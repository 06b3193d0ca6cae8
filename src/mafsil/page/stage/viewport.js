// A picture of a scene on a canvas: how it is drawn here, and the camera led by the pointer and by keys.

import { Camera } from "../../scene/camera.js";
import { FlatRenderer } from "../../scene/flat.js";
import { Renderer, drawsBySoftware } from "../../scene/renderer.js";
import { Shapes } from "../../scene/shapes.js";
import { Figure } from "./figure.js";

const REST = 120; // ms after the last picture of something that moves

export class Viewport {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {object} scene  bodies, surfaces, centre, size, floor
   */
  constructor(canvas, scene) {
    Object.assign(this, { canvas, scene, finest: false }); // finest: whether pictures are never made with less effort
    this.makeRenderer();
    this.figure = new Figure(this.renderer, scene);
    this.camera = new Camera(scene);
    this.resized({ width: this.canvas.clientWidth, height: this.canvas.clientHeight });
    this.listen();
    this.readColours();
  }

  /** Seen from the front side, whole. */
  home() {
    this.camera.look(-0.95, 0.36);
    this.frame();
  }

  /** Everything that is to be seen fills the picture, until somebody leads the camera. */
  frame() {
    this.framed = true;
    this.camera.frame(this.outermost(), this.width / Math.max(1, this.height));
  }

  /** Points around what is to be seen. @returns {number[][]} */
  outermost() {
    return [];
  }

  /** WebGL where there is a graphics processor, with little effort where there is none, else plain outlines. */
  makeRenderer() {
    try {
      if (new URLSearchParams(location.hash.slice(1)).has("flat")) throw new Error("asked for");
      const light = drawsBySoftware(this.canvas);
      if (light) this.freshCanvas();
      if (light) Shapes.sides = 24;
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
    const probe = document.body.appendChild(document.createElement("i"));
    const colour = (name) => {
      probe.style.color = `var(${name})`;
      return getComputedStyle(probe).color.match(/[\d.]+/g).slice(0, 3).map((part) => Number(part) / 255).concat(1);
    };
    this.colours = Object.fromEntries([
      "accent", "bad", "floor", "grid", "s0", "s1", "s2", "s3", "s4", "s5", "s6", "s7"
    ].map((name) => [name, colour(`--${name}`)]));
    probe.remove();
  }

  /** Draw these: at once, and finely when nothing has moved for a while. @param {object[]} items */
  render(items) {
    clearTimeout(this.resting);
    this.draw(items, this.finest);
    if (this.renderer.light && !this.finest) this.resting = setTimeout(() => this.draw(items, true), REST);
  }

  draw(items, still) {
    this.renderer.refine?.(still);
    const { camera, figure, colours, scene } = this, pitch = Math.pow(10, Math.floor(Math.log10(scene.size * 0.35)));
    this.renderer.render(
      items,
      {
        camera, eye: camera.eye, target: camera.target, centre: scene.centre, size: scene.size, ground: figure.ground, pitch,
        floor: colours.floor, lines: colours.grid
      }
    );
  }

  /** Another picture is wanted. */
  changed() {}

  /** The pointer is pressed: something may be led by it from now on. */
  grab() {}

  /** Nothing is led any more. */
  release() {}

  /** The pointer is over the picture. */
  hover() {}

  /** The pointer was pressed twice: what is there comes near. */
  focus() {}

  /** Whether the pointer leads something, instead of the camera. @returns {boolean} */
  lead() {
    return false;
  }

  listen() {
    const { canvas, camera } = this, held = new Map();
    const moved = (change) => { change(); this.framed = false; this.changed(); };
    let gap = 0;
    canvas.addEventListener("pointerdown", (event) => {
      held.set(event.pointerId, event);
      canvas.parentElement.classList.add("known"); // how it is led needs no hint any more
      canvas.setPointerCapture(event.pointerId);
      gap = 0;
      if (held.size === 1 && event.button === 0) this.grab(event);
      else this.release();
    });
    const release = (event) => { held.delete(event.pointerId); this.release(); };
    canvas.addEventListener("pointerup", release);
    canvas.addEventListener("pointercancel", release);
    canvas.addEventListener("pointermove", (event) => {
      const before = held.get(event.pointerId);
      if (!before) { this.hover(event); return; }
      const dx = event.clientX - before.clientX, dy = event.clientY - before.clientY;
      held.set(event.pointerId, event);
      if (this.lead(event)) return;
      if (held.size === 2) {
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
    canvas.addEventListener("dblclick", (event) => this.focus(event));
    new ResizeObserver(([entry]) => { this.resized(entry.contentRect); if (this.framed) this.frame(); this.changed(); }).observe(canvas);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { this.readColours(); this.changed(); });
  }

  /** Arrows turn the view; what is no key of the picture is left alone. */
  key(event) {
    const turns = { ArrowLeft: [-14, 0], ArrowRight: [14, 0], ArrowUp: [0, 14], ArrowDown: [0, -14] };
    if (turns[event.key]) this.camera.turn(...turns[event.key]);
    else if (event.key === "+" || event.key === "=") this.camera.zoom(0.88);
    else if (event.key === "-") this.camera.zoom(1.14);
    else if (event.key === "Home") this.home();
    else return;
    this.framed = event.key === "Home";
    event.preventDefault();
    this.changed();
  }
}
