// The page: kernels are unpacked, views mounted on one store, and drawn at most once a frame.

import { bytes, loadKernels } from "./core/kernels.js";
import { ServerLink, serverTransport } from "./core/link.js";
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

class App {
  constructor(data, kernels) {
    this.data = data;
    this.words = new Words(data.languages, data.language);
    this.store = new Store({ settings: data.settings, kernels });
    for (const { actions } of VIEWS) this.store.learn(actions ?? {});
    this.link = data.studio ? new ServerLink(this.store, data.actions, serverTransport(), crypto.randomUUID().slice(0, 8)) : null;
    this.playing = false;
    this.last = 0;
    this.waiting = false;
    /** Milliseconds: of the script until the first picture, and of one frame. */
    this.timing = { start: 0, frame: 0, frames: 0 };
    this.updates = [];
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
    document.title = `${data.robot.name} · mafsil`;
    for (const place of document.querySelectorAll("[data-say]")) place.replaceChildren(sentence(words, place.dataset.say));
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

  /** The next language. */
  speak() {
    const known = Object.keys(this.data.languages);
    this.words.chosen = known[(known.indexOf(this.words.chosen) + 1) % known.length];
    this.mount();
  }

  /** Draw with the next frame of the screen. */
  draw() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame((now) => this.frame(now));
  }

  frame(now) {
    const begin = performance.now();
    const running = this.updates.filter(({ view }) => view.tick?.(this, now)).length > 0;
    this.waiting = false;
    for (const { card, update } of this.updates) if (card.open) update();
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

async function begin() {
  const start = performance.now(), data = JSON.parse(document.getElementById("data").textContent);
  const app = new App(data, await loadKernels(await unpacked(data.kernels.code), data.kernels.layout));
  app.timing.start = performance.now() - start;
  window.mafsil = app;
}

begin().catch((error) => {
  const place = document.getElementById("status");
  place.hidden = false;
  place.textContent = `${error}`;
  throw error;
});
