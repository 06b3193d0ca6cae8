// What a page does: views mounted on one store, and drawn at most once a frame.

import { stateText, takeState, wantedState } from "./core/address.js";
import { bytes, loadKernels } from "./core/kernels.js";
import { Store } from "./core/store.js";
import { VIEWS } from "./core/views.js";
import { Words } from "./core/words.js";
import { isLed } from "./loops/follow.js";
import { Player } from "./stage/player.js";
import { Stage } from "./stage/stage.js";
import { Tree } from "./tree.js";
import { element, isolated, saveFile, sentence } from "./views/elements.js";

const SMOOTHING = 0.1;
const KEPT = 500; // ms after which what a reload comes back to is kept
const TABS = ["move", "analyse", "job", "model", "code"];
const UNITS = {
  rad: { sign: "rad", factor: 1, digits: 3 }, deg: { sign: "°", factor: 180 / Math.PI, digits: 1 }, m: { sign: "m", factor: 1, digits: 3 },
  mm: { sign: "mm", factor: 1000, digits: 1 }
};
const THEMES = ["system", "light", "dark"], SIGNS = { system: "◐", light: "☀", dark: "☾" };
const byId = (id) => document.getElementById(id);

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
    const wanted = VIEWS.filter((one) => one.wanted?.(this.store.arm, data) ?? true);
    this.tabs = TABS.filter((tab) => wanted.some((one) => (one.tab ?? "move") === tab));
    this.tab = this.tabs[0];
    this.stage = new Stage(byId("scene"), byId("labels"), this);
    this.player = new Player(this);
    this.tree = new Tree(byId("tree"), this);
    this.stage.home();
    this.stage.finest = new URLSearchParams(location.hash.slice(1)).has("picture");
    document.documentElement.classList.toggle("picture", this.stage.finest);
    if (data.shown) this.showPostures(data.shown);
    takeState(wantedState(), this);
    this.store.listen(() => this.draw());
    this.listen();
    this.mount();
  }

  listen() {
    const { store, stage } = this, click = (id, act) => byId(id).addEventListener("click", act);
    click("language", () => this.speak());
    click("home", () => { stage.home(); this.draw(); });
    click("undo", () => this.undo());
    click("menu", () => byId("menu").setAttribute("aria-expanded", String(byId("top").classList.toggle("open"))));
    click("share", () => this.share());
    click("image", async () => saveFile(`${this.data.robot.name}.png`, await stage.photograph(), "image/png"));
    click("theme", () => this.paintTheme(THEMES[(THEMES.indexOf(store.shown.theme) + 1) % THEMES.length]));
    click("angles", () => this.measure({ angle: store.shown.angle === "rad" ? "deg" : "rad" }));
    click("lengths", () => this.measure({ length: store.shown.length === "m" ? "mm" : "m" }));
    byId("frames").addEventListener("change", ({ target }) => store.show({ frames: target.checked }));
    document.addEventListener("keydown", (event) => {
      if (event.key !== "z" || !(event.ctrlKey || event.metaKey) || /^(INPUT|TEXTAREA)$/.test(event.target.tagName)) return;
      event.preventDefault();
      this.undo();
    });
  }

  /** Take back what was done last: a thing of the job that was placed, where there is a job, or an action. */
  undo() {
    if (!this.takeBack?.()) this.store.undo();
  }

  /** Other postures than that of the arm as ghosts, with the names of all. @param {{name: string, q: number[]}[]} postures */
  showPostures(postures) {
    const { store, stage } = this, colour = (k) => (k ? `s${(k - 1) % 8}` : "ink");
    const row = ({ name }, k) => {
      const made = element("li", {}, isolated(name));
      made.style.setProperty("--own", `var(--${colour(k)})`);
      return made;
    };
    stage.canvas.after(element("ul", { id: "postures" }, ...postures.map(row)));
    const ghost = ({ q }, k) => stage.figure.ghost(store.arm.kernels.link_poses(q)[0], stage.colours[colour(k + 1)]);
    this.join({ along: () => postures.map(({ q }) => q), items: () => postures.slice(1).flatMap(ghost) });
    stage.home();
  }

  /** Light, dark, or as the reader's system has it. @param {string} theme */
  paintTheme(theme) {
    this.store.shown.theme = theme;
    document.documentElement.dataset.theme = theme;
    byId("theme").textContent = SIGNS[theme];
    for (const name of ["aria-label", "title"]) byId("theme").setAttribute(name, this.words.text(`theme_${theme}`));
    this.stage.readColours();
    this.stage.changed();
  }

  /** The unit of a length or an angle: how it is written, and how many there are in a metre or a radian. */
  unit(prismatic) {
    return UNITS[prismatic ? this.store.shown.length : this.store.shown.angle];
  }

  /**
   * A unit as it is written now: how many there are in one, for a curve of a plot.
   *
   * @param {string} unit  such as "rad/s", or "rad, m" for joints of both kinds
   * @param {number} curve  whose number is that of a joint
   */
  scale(unit, curve) {
    const parts = unit.split(", ").map((part) => {
      const [, base, rest = ""] = /^(rad|m)(\/s)?$/.exec(part) ?? [], { factor, sign } = base ? this.unit(base === "m") : { factor: 1, sign: part };
      return { factor, sign: sign + rest };
    });
    const { factor } = parts[Number(parts.length > 1 && Boolean(this.data.robot.joints[curve]?.prismatic))];
    return { factor, sign: parts.map(({ sign }) => sign).join(", ") };
  }

  /** All numbers in other units. */
  measure(units) {
    this.store.show(units);
    this.mount();
    for (const one of this.joined) one.spoken?.();
  }

  /** The address of this state, to be sent to somebody. */
  async share() {
    const address = `${location.href.split("#")[0]}#${stateText(this)}`;
    try {
      await navigator.clipboard.writeText(address);
      this.say({ key: "copied", values: {} });
    } catch {
      location.hash = stateText(this);
    }
  }

  /** Show a reason until the next action. @param {import("./core/state.js").Reason} refusal */
  say(refusal) {
    this.store.show({ refusal });
  }

  /** A card where it is seen. @param {string} name  of the view */
  unfold(name) {
    const { view, card } = this.updates.find((one) => one.view.name === name);
    card.open = true;
    this.turn(view.tab ?? "move");
  }

  /** Another tab. @param {string} tab */
  turn(tab) {
    this.tab = tab;
    for (const button of byId("tabs").children) {
      button.setAttribute("aria-selected", String(button.dataset.tab === tab));
      button.tabIndex = button.dataset.tab === tab ? 0 : -1;
    }
    for (const { view, card } of this.updates) card.hidden = (view.tab ?? "move") !== tab;
    this.draw();
  }

  /** One button for each tab; arrows go from one to the next. */
  mountTabs() {
    const step = (event, k) => {
      const way = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      if (!way) return;
      const at = (k + (this.words.direction === "rtl" ? -way : way) + this.tabs.length) % this.tabs.length;
      this.turn(this.tabs[at]);
      byId("tabs").children[at].focus();
    };
    byId("tabs").replaceChildren(...this.tabs.map((tab, k) => element(
      "button",
      { type: "button", role: "tab", "data-tab": tab, "aria-controls": "views", onclick: () => this.turn(tab), onkeydown: (event) => step(event, k) },
      sentence(this.words, `tab_${tab}`)
    )));
  }

  /** All views, in the language that is chosen. */
  mount() {
    const { words, data, store } = this, root = document.documentElement, panel = byId("views");
    root.lang = words.chosen;
    root.dir = words.direction;
    document.title = data.titles?.[words.chosen] ?? `${data.robot.name} · mafsil`;
    for (const place of document.querySelectorAll("[data-say]")) place.replaceChildren(sentence(
      words, place.dataset.say === "hint" && !isLed(store.arm) ? "hint_loops" : place.dataset.say
    ));
    for (const place of document.querySelectorAll("[data-label]")) place.setAttribute("aria-label", words.text(place.dataset.label));
    for (const [id, prismatic] of [["angles", false], ["lengths", true]]) byId(id).textContent = this.unit(prismatic).sign;
    this.stage.compass.speak((way) => words.text("look_along", { way }));
    const open = this.updates.length ? new Set(this.updates.filter(({ card }) => card.open).map(({ view }) => view.name)) : null;
    this.updates = [];
    panel.replaceChildren();
    for (const view of VIEWS.filter((one) => one.wanted?.(store.arm, data) ?? true)) {
      const card = element(
        "details", { id: `view-${view.name}`, open: open ? open.has(view.name) : view.open ?? false, ontoggle: () => this.draw() },
        element("summary", {}, view.title?.[words.chosen] ?? sentence(words, `view_${view.name}`))
      );
      const place = element("div", {});
      card.append(place);
      panel.append(card);
      this.updates.push({ view, card, update: view.mount(place, this) });
    }
    this.mountTabs();
    this.turn(this.tab);
    this.paintTheme(store.shown.theme);
    this.tree.speak();
    this.player.speak();
  }

  /**
   * Something beside the cards: its time passes and it is brought up to date with every picture, where another language
   * or unit was chosen it is called, and it adds to what is drawn.
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
    for (const { card, update } of this.updates) if (card.open && !card.hidden) update();
    this.tree.update();
    for (const { update } of this.joined) update?.();
    this.paintStatus();
    this.stage.paint();
    const taken = performance.now() - begin;
    this.timing.frame = this.timing.frames++ ? this.timing.frame + SMOOTHING * (taken - this.timing.frame) : taken;
    if (running) this.draw();
    clearTimeout(this.keeping);
    this.keeping = setTimeout(() => this.keep(), KEPT);
  }

  /** What a reload of the page comes back to; a page in a frame of another has no history. */
  keep() {
    try {
      history.replaceState({ kept: stateText(this) }, "");
    } catch { /* nothing is kept there */ }
  }

  /** How the last action ended, or why the tool cannot be led where the pointer is. */
  paintStatus() {
    const { store, words, data } = this, place = byId("status");
    const reason = store.shown.refusal ?? store.state.reason;
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
