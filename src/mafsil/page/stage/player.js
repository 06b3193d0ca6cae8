// The replay of a run: its bar, its clock, what stands around the arm; and the arm taken over from where it is.

import { wantedState } from "../core/address.js";
import { goOn, lengthOf, play, posed, seek } from "../core/tape.js";
import { element, sentence, written } from "../views/elements.js";
import { Scenery, floats } from "./scenery.js";

const KEY_FRAMES = 5, STOPS = 60; // of a run on paper; colours of a lane
const ROOM = 0.03; // of the picture, beside what is seen on paper
const SEEN = 12; // configurations along a motion that the picture is framed by
const at = (id) => document.getElementById(id);

export class Player {
  /** @param {object} app  the page; its data may hold a run, or what stands around the arm */
  constructor(app) {
    const { tape, around, moves = [] } = app.data;
    Object.assign(this, { app, moves, seen: {}, told: () => {} });
    if (tape ?? around) this.scenery = new Scenery(app.stage.figure, tape ?? around, app.stage.kind === "flat");
    if (tape) this.open(tape);
    this.marks = moves.map(({ from, to }) => {
      const mark = element("i");
      mark.style.left = `${100 * from / this.end}%`;
      mark.style.width = `calc(${100 * (to - from) / this.end}% - 2px)`;
      return mark;
    });
    moves.forEach(({ level }, k) => this.marks[k].classList.add(level));
    at("moves").append(...this.marks);
    this.flags = (app.data.flags ?? []).map(({ time, level }) => {
      const flag = element("button", { type: "button", class: level, onclick: () => seek(app.store, time) });
      flag.style.left = `${100 * Math.min(1, time / this.end)}%`;
      return flag;
    });
    at("flags").append(...this.flags);
    at("lanes").append(...lanesOf(app.data));
    this.listen();
    app.join({
      tick: ({ store }, now) => goOn(store, now), update: () => this.update(), items: (stage) => this.items(stage),
      along: () => this.along(), outermost: () => this.scenery?.outermost() ?? []
    });
  }

  /** The run that the page carries, from its beginning or from where the address says. */
  open(tape) {
    const { store } = this.app, q = floats(tape.q), { n } = store.arm.settings;
    const first = {
      t: Array.from({ length: tape.frames }, (_, k) => Math.min(k * tape.period, tape.end)),
      q: Array.from({ length: tape.frames }, (_, k) => q.subarray(n * k, n * k + n))
    };
    this.period = tape.period;
    const moment = new URLSearchParams(wantedState()).get("t"), still = moment !== null || matchMedia("(prefers-reduced-motion: reduce)").matches;
    store.show({ replay: posed({ first, second: null, time: Math.min(lengthOf(first), Number(moment) || 0), playing: !still }) });
  }

  /** Duration of the replay [s]. */
  get end() {
    return (this.replay && (this.replay.first.duration ?? lengthOf(this.replay.first))) || 1e-9;
  }

  /** Something else stands around the arm. @param {object} around  as a page carries it */
  surround(around) {
    const { planned } = this.scenery ?? {};
    this.scenery = new Scenery(this.app.stage.figure, around, this.app.stage.kind === "flat");
    this.period = around.period;
    if (!around.frames) this.scenery.planned = planned;
    this.app.tree.speak();
    if (this.app.stage.framed) this.app.stage.frame();
    this.app.draw();
  }

  /** Configurations along the replay. */
  along() {
    const q = this.replay?.first.q;
    return q ? Array.from({ length: SEEN }, (_, k) => q[Math.round(k * (q.length - 1) / (SEEN - 1))]) : [];
  }

  /** The replay, or the one that was left to lead the arm. */
  get replay() {
    const { shown } = this.app.store;
    return shown.replay ?? shown.left;
  }

  listen() {
    const { store } = this.app;
    at("play").addEventListener("click", () => play(store, !store.shown.replay?.playing));
    at("time").addEventListener("input", ({ target }) => seek(store, Number(target.value) * this.end));
    at("speed").addEventListener("change", ({ target }) => Object.assign(this.replay, { speed: Number(target.value) }));
    at("show-path").addEventListener("change", ({ target }) => { this.scenery.shown = target.checked; this.app.draw(); });
    at("take").addEventListener("click", () => { if (store.shown.replay) store.takeOver(); else seek(store, this.replay.time); });
    addEventListener("beforeprint", () => this.strip());
    document.addEventListener("keydown", (event) => {
      if (event.key !== " " || /^(BUTTON|INPUT|SELECT|SUMMARY|TEXTAREA|PRE)$/.test(event.target.tagName)) return;
      event.preventDefault();
      at("play").click();
    });
  }

  /** Key frames for paper, where nothing plays: evenly from the beginning of the replay to its end. */
  strip() {
    const { replay, app: { stage } } = this;
    if (!replay || !stage.canvas.width) return;
    const { time } = replay, spread = this.spread();
    at("strip").replaceChildren(...Array.from({ length: KEY_FRAMES }, (_, k) => {
      posed(Object.assign(replay, { time: k * this.end / (KEY_FRAMES - 1) }));
      stage.draw(stage.items(), true);
      const { width, height } = stage.canvas, [left, right] = spread.map((x) => Math.round(x * width / stage.width)),
        copy = element("canvas", { width: right - left, height });
      copy.getContext("2d").drawImage(stage.canvas, -left, 0);
      return element("figure", {}, copy, element("figcaption", { dir: "ltr" }, `${replay.time.toFixed(2)} s`));
    }));
    posed(Object.assign(replay, { time }));
    stage.paint();
  }

  /** From where to where the picture is filled, from left to right, with some room [CSS pixels]. */
  spread() {
    const { stage } = this.app, places = stage.camera.projected(stage.outermost(), stage.width, stage.height).map(({ x }) => x);
    const room = ROOM * stage.width;
    return places.length ? [Math.max(0, Math.min(...places) - room), Math.min(stage.width, Math.max(...places) + room)] : [0, stage.width];
  }

  /** Names of the moves, and what the buttons say, in the language that is chosen. */
  speak() {
    const { data, words } = this.app;
    this.marks.forEach((mark, k) => { mark.title = data.texts[words.chosen].moves[k]; });
    this.flags.forEach((flag, k) => { for (const name of ["aria-label", "title"]) flag.setAttribute(name, data.texts[words.chosen].flags[k]); });
    for (const lane of at("lanes").children) lane.title = words.text(`lane_${lane.dataset.lane}`);
    this.seen = {};
    this.app.draw();
  }

  /** What has changed since the last picture. */
  update() {
    const { store, words, data } = this.app, led = !store.shown.replay;
    at("bar").hidden = at("overlay").hidden = !this.replay;
    if (!this.replay) return;
    const { time, playing } = this.replay;
    const now = JSON.stringify([time, playing, led, words.chosen]);
    if (this.seen.shown === now) return;
    this.seen.shown = now;
    if (document.activeElement !== at("time") || playing) at("time").value = time / this.end;
    written(at("clock"), `${time.toFixed(2)} s`);
    const active = this.moves.findLastIndex(({ from }) => from <= time);
    this.marks.forEach((mark, k) => mark.classList.toggle("on", k === active));
    at("move-name").replaceChildren(led ? sentence(words, "taken_over") : data.texts?.[words.chosen].moves[active] ?? "");
    at("play").classList.toggle("on", playing && !led);
    for (const name of ["aria-label", "title"]) at("play").setAttribute(name, words.text(playing && !led ? "pause" : "play"));
    at("take").replaceChildren(sentence(words, led ? "to_replay" : "take_over"));
    at("take").classList.toggle("strong", led);
    this.told(time);
  }

  /** What stands around the arm, at the time of the replay. */
  items(stage) {
    const { store } = this.app;
    if (!this.scenery) return [];
    const tip = store.arm.kernels.forward_kinematics(store.state.q)[0].slice(), frame = this.replay ? this.replay.time / this.period : 0,
      list = this.scenery.items(
      frame, tip, stage.colours.accent, store.shown
    );
    if (this.app.placed && !this.replay) list.push(...this.scenery.gripDots(stage.colours.accent));
    return store.shown.replay ? [...list, ...stage.push(tip, this.scenery.force(frame)).map((one) => ({ ...one, over: true }))] : list;
  }
}

/** Strips over time that turn red: where something comes nearer than four times the clearance, where limits are used up. */
function lanesOf({ time, plots = [] }) {
  const heat = {
    clearance: (row, [bound]) => (4 * Math.max(bound, 1e-3) - row[0]) / (3 * Math.max(bound, 1e-3)),
    limit_used: (row) => (Math.max(...row.filter(Number.isFinite)) - 60) / 40
  };
  return plots.filter(({ column }) => column in heat).map(({ column, values, limits, names }) => {
    const t = floats(time), numbers = floats(values), width = names.length, lane = element("i", { "data-lane": column });
    const row = (k) => Array.from(numbers.subarray(k * width, k * width + width)), bound = (k) => (width > 1 ? row(k)[1] : limits?.[0][0] ?? 0);
    const hot = new Array(STOPS).fill(0);
    for (let k = 0; k < t.length; k++) {
      const stop = Math.min(STOPS - 1, Math.floor(STOPS * t[k] / (t.at(-1) || 1)));
      hot[stop] = Math.max(hot[stop], Math.min(1, heat[column](row(k), [bound(k)]) || 0));
    }
    lane.style.background = `linear-gradient(to right, ${hot
      .map((share) => `color-mix(in srgb, var(--${column === "clearance" ? "bad" : "accent"}) ${Math.round(100 * share)}%, var(--good-soft))`).join(", ")})`;
    return lane;
  });
}
