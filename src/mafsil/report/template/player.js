// The replay of a run: its bar, its clock, what stands around the arm; and the arm taken over from where it is.

import { goOn, lengthOf, play, posed, seek } from "../../page/core/tape.js";
import { element, sentence, written } from "../../page/views/elements.js";
import { Scenery, floats } from "./scenery.js";

const by = (id) => document.getElementById(id);

export class Player {
  /**
   * @param {object} app  the page
   * @param {(time: number) => void} told  where the replay is [s]
   */
  constructor(app, told) {
    const { tape, moves } = app.data, q = floats(tape.q), n = app.store.arm.settings.n;
    const first = { t: Array.from({ length: tape.frames }, (_, k) => Math.min(k * tape.period, tape.end)), q: Array.from({ length: tape.frames }, (_, k) => q.subarray(n * k, n * k + n)) };
    Object.assign(this, { app, told, moves, period: tape.period, end: lengthOf(first) || 1e-9, seen: {} });
    this.scenery = new Scenery(app.stage.figure, tape, app.stage.kind === "flat");
    this.marks = moves.map(({ from, to }) => {
      const mark = element("i");
      mark.style.left = `${100 * from / this.end}%`;
      mark.style.width = `calc(${100 * (to - from) / this.end}% - 2px)`;
      return mark;
    });
    by("moves").append(...this.marks);
    const moment = /^#t=([0-9.]+)$/.exec(location.hash), still = moment || matchMedia("(prefers-reduced-motion: reduce)").matches;
    const time = moment ? Math.min(this.end, Number(moment[1])) : 0;
    app.store.show({ replay: posed({ first, second: null, time, playing: !still }) });
    this.listen();
    this.speak();
    app.join({ tick: ({ store }, now) => goOn(store, now), update: () => this.update(), spoken: () => this.speak(), items: (stage) => this.items(stage) });
  }

  /** The replay, or the one that was left to lead the arm. */
  get replay() {
    const { shown } = this.app.store;
    return shown.replay ?? shown.left;
  }

  listen() {
    const { store } = this.app;
    by("play").addEventListener("click", () => play(store, !store.shown.replay?.playing));
    by("time").addEventListener("input", ({ target }) => seek(store, Number(target.value) * this.end));
    by("speed").addEventListener("change", ({ target }) => Object.assign(this.replay, { speed: Number(target.value) }));
    by("show-path").addEventListener("change", ({ target }) => { this.scenery.shown = target.checked; this.app.draw(); });
    by("take").addEventListener("click", () => { if (store.shown.replay) store.takeOver(); else seek(store, this.replay.time); });
    by("tools").addEventListener("click", () => this.unfold(by("views").hidden));
    document.addEventListener("keydown", (event) => {
      if (event.key !== " " || /^(BUTTON|INPUT|SELECT|SUMMARY|TEXTAREA|PRE)$/.test(event.target.tagName)) return;
      event.preventDefault();
      by("play").click();
    });
  }

  /** Show the cards, or fold them away. @param {boolean} open */
  unfold(open) {
    by("views").hidden = !open;
    by("replay").classList.toggle("open", open);
    by("tools").setAttribute("aria-expanded", String(open));
    this.app.draw();
  }

  /** Names of the moves, and what the buttons say, in the language that is chosen. */
  speak() {
    const { data, words } = this.app;
    this.marks.forEach((mark, k) => { mark.title = data.texts[words.chosen].moves[k]; });
    this.seen = {};
    this.app.draw();
  }

  /** What has changed since the last picture. */
  update() {
    const { store, words, data, stage } = this.app, led = !store.shown.replay, { time, playing } = this.replay;
    if (led && !this.seen.led && !stage.drag.going) { // the picture stays as wide as it is while the pointer leads the tool
      this.seen.led = true;
      this.unfold(true);
    }
    if (!led) this.seen.led = false;
    const now = JSON.stringify([time, playing, led, words.chosen]);
    if (this.seen.shown === now) return;
    this.seen.shown = now;
    if (document.activeElement !== by("time") || playing) by("time").value = time / this.end;
    written(by("clock"), `${time.toFixed(2)} s`);
    const active = this.moves.findLastIndex(({ from }) => from <= time);
    this.marks.forEach((mark, k) => mark.classList.toggle("on", k === active));
    by("move-name").replaceChildren(led ? sentence(words, "taken_over") : data.texts[words.chosen].moves[active] ?? "");
    by("play").classList.toggle("on", playing && !led);
    for (const name of ["aria-label", "title"]) by("play").setAttribute(name, words.text(playing && !led ? "pause" : "play"));
    by("take").replaceChildren(sentence(words, led ? "to_replay" : "take_over"));
    by("take").classList.toggle("strong", led);
    this.told(time);
  }

  /** What stands around the arm, at the time of the replay. */
  items(stage) {
    const { store } = this.app;
    return this.scenery.items(this.replay.time / this.period, store.arm.kernels.forward_kinematics(store.state.q)[0], stage.colours.accent);
  }
}
