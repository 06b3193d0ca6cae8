// What a page does: views mounted on one store, and drawn at most once a frame.

import { bytes, loadKernels } from "./core/kernels.js";
import { Store } from "./core/store.js";
import { VIEWS } from "./core/views.js";
import { Words } from "./core/words.js";
import { Stage } from "./stage/stage.js";
import { element, sentence } from "./views/elements.js";

const SMOOTHING = 0.1;


/** The module of kernels, which travels compressed. */
async function unpacked(text) {
  const stream = new Blob([bytes(text)]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

export class App {
  /**
   * @param {object} data  what Python wrote into the page
   * @param {Object<string, import("./core/kernels.js").Kernel>} kernels
   * @param {(store: Store) => object | null} linked  makes the link to a server
   */
  constructor(data, kernels, linked) {
    this.data = data;
    this.words = new Words(data.languages, data.language);
    this.store = new Store({ settings: data.settings, kernels });
    for (const { actions } of VIEWS) this.store.learn(actions ?? {});
    this.link = linked(this.store);
    this.playing = false; // whether time passes in the closed loop
    this.last = 0;
    this.waiting = false;
    /** Milliseconds: of the script until the first picture, and of one frame. */
    this.timing = { start: 0, frame: 0, frames: 0 };
    this.updates = [];
    /** What is no card: {tick, update, spoken, items}, each as it is wanted; see `join`. */
    this.joined = [];
    this.stage = new Stage(document.getElementById("scene"), document.getElementById("labels"), this);
    this.store.listen(() => this.draw());
    document.getElementById("language").addEventListener("click", () => this.speak());
    document.getElementById("frames").addEventListener("change", (event) => this.store.show({ frames: event.target.checked }));
    document.getElementById("home").addEventListener("click", () => { this.stage.camera.home(); this.draw(); });
    this.mount();
  }

  /** All views, in the language that is chosen. */
  mount() {
    const { words, data, store } = this, root = document.documentElement, panel = document.getElementById("views");
    root.lang = words.chosen;
    root.dir = words.direction;
    document.title = data.titles?.[words.chosen] ?? `${data.robot.name} · mafsil`;
    for (const place of document.querySelectorAll("[data-say]")) place.replaceChildren(sentence(words, place.dataset.say === "hint" && store.arm.settings.driven ? "hint_loops" : place.dataset.say));
    for (const place of document.querySelectorAll("[data-label]")) place.setAttribute("aria-label", words.text(place.dataset.label));
    const open = this.updates.length ? new Set(this.updates.filter(({ card }) => card.open).map(({ view }) => view.name)) : null;
    this.updates = [];
    panel.replaceChildren();
    for (const view of VIEWS.filter((one) => one.wanted?.(store.arm, data) ?? true)) {
      const card = element("details", { id: `view-${view.name}`, open: open ? open.has(view.name) : view.open ?? false, ontoggle: () => this.draw() }, element("summary", {}, view.title?.[words.chosen] ?? sentence(words, `view_${view.name}`)));
      const place = element("div", {});
      card.append(place);
      panel.append(card);
      this.updates.push({ view, card, update: view.mount(place, this) });
    }
    this.draw();
  }

  /**
   * Something beside the cards: its time passes and it is brought up to date with every picture, where another language
   * was chosen it is called, and it adds to what is drawn.
   *
   * @param {{tick?: (app: App, now: number) => boolean, update?: () => void, spoken?: () => void,
   *          items?: (stage: Stage) => object[]}} one
   */
  join(one) {
    this.joined.push(one);
    this.draw();
  }

  /** The next language. */
  speak() {
    const known = Object.keys(this.data.languages);
    this.words.chosen = known[(known.indexOf(this.words.chosen) + 1) % known.length];
    this.mount();
    for (const one of this.joined) one.spoken?.();
  }

  /** Draw with the next frame of the screen. */
  draw() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame((now) => this.frame(now));
  }

  frame(now) {
    const begin = performance.now();
    const running = [...this.updates.map(({ view }) => view), ...this.joined].filter((one) => one.tick?.(this, now)).length > 0;
    this.waiting = false;
    for (const { card, update } of this.updates) if (card.open) update();
    for (const { update } of this.joined) update?.();
    this.paintStatus();
    this.stage.paint();
    const taken = performance.now() - begin;
    this.timing.frame = this.timing.frames++ ? this.timing.frame + SMOOTHING * (taken - this.timing.frame) : taken;
    if (running) this.draw();
  }

  /** How the last action ended, or why the tool cannot be led where the pointer is. */
  paintStatus() {
    const { store, words, data } = this, place = document.getElementById("status");
    const reason = store.shown.wish ? store.shown.refusal : store.state.reason;
    const named = reason && { ...reason.values, joint: data.settings.locked.map((k) => data.robot.joints[k].name).join(", ") };
    const key = reason ? JSON.stringify([reason.key, named, words.chosen]) : "";
    if (place.dataset.key === key) return;
    place.dataset.key = key;
    place.replaceChildren(reason ? sentence(words, reason.key, named) : "");
    place.hidden = !reason;
  }
}

/**
 * The page of some data, its kernels unpacked.
 *
 * @param {object} data  what Python wrote into the page
 * @param {(store: Store) => object | null} linked  makes the link to a server; a page that is a file has none
 */
export async function opened(data, linked = () => null) {
  const start = performance.now(), app = new App(data, await loadKernels(await unpacked(data.kernels.code), data.kernels.layout), linked);
  app.timing.start = performance.now() - start;
  return app;
}

/** What Python wrote into the page. */
export const carried = () => JSON.parse(document.getElementById("data").textContent);

/** Say what went wrong where everybody sees it. @param {Error} error */
export function complain(error) {
  const place = document.getElementById("status");
  place.hidden = false;
  place.textContent = `${error}`;
  throw error;
}
