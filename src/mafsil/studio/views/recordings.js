// Recorded motions: one is replayed by the arm, a second beside it as a ghost, with how far they are apart.

import { posed } from "page/core/tape.js";
import { view } from "page/core/views.js";
import { drawn, element, number, sentence, symbol, written } from "page/views/elements.js";

const WIDTH = 360, HEIGHT = 110;

view({
  name: "recordings",
  tab: "job",
  order: 75,
  open: true,
  mount(place, app) {
    const { link, words, store } = app, tapes = (link.tapes ??= new Map());
    const choices = [0, 1].map((k) => element("select", { id: `recording-${k}`, onchange: (event) => choose(k, Number(event.target.value) || null) }));
    const label = (key, field) => element("label", { class: "choice" }, sentence(words, key), field);
    const close = element("button", { type: "button", class: "quiet", onclick: () => choose(0, null) }, sentence(words, "replay_close"));
    const plot = new Curve(), said = element("div", { id: "comparison", role: "status" }), none = element("p", { class: "soft" }, sentence(words, "no_recordings"));
    const body = element("div", {}, element("div", { class: "buttons" }, label("recording_first", choices[0]), label("recording_second", choices[1])), element("div", { class: "buttons" }, close), plot.element, said);
    place.append(none, body);
    let listed = null, painted = "";

    /** Another recording for the arm (0) or the ghost (1). */
    function choose(k, number) {
      const chosen = [...(store.shown.chosen ?? [null, null])];
      chosen[k] = number;
      if (k === 0 && !number) chosen[1] = null;
      store.show({ chosen, replay: chosen[0] ? store.shown.replay : null, left: null });
    }

    /** What is chosen is fetched once; then the arm shows it. */
    async function load(chosen) {
      for (const number of chosen) if (number && !tapes.has(number)) tapes.set(number, await link.fetched("recording", { number }));
      const [first, second] = chosen.map((number) => tapes.get(number) ?? null);
      const both = first?.q && second?.q ? await link.fetched("compare", { first: first.number, second: second.number }) : null;
      if (String(chosen) !== String(store.shown.chosen)) return;
      const failed = [first, second, both].find((one) => one?.error);
      said.replaceChildren(...(failed ? [element("p", { class: "wrong" }, words.isolated(failed.error))] : both ? difference(both, words, app.data) : first ? [element("p", { class: "soft" }, sentence(words, "tracking"))] : []));
      if (first?.q) plot.draw(both?.distance ? both.t : first.t, both?.distance ?? first.tip_error);
      const shown = store.shown.replay ?? store.shown.left;
      if (shown && shown.first === first && shown.second === (second?.q ? second : null)) return;
      store.show({ left: null, replay: first?.q ? posed({ first, second: second?.q ? second : null, time: 0, playing: Boolean(store.shown.plays) }) : null, plays: false });
    }
    const update = () => {
      const list = link.heard.get("recordings")?.list ?? [], chosen = store.shown.chosen ?? [null, null], key = JSON.stringify([chosen, words.chosen]);
      if (list !== listed) fill(choices, (listed = list), words);
      none.hidden = list.length > 0;
      body.hidden = !list.length;
      choices.forEach((field, k) => { field.value = chosen[k] ?? ""; });
      if (key !== painted) { painted = key; load(chosen); }
      const replay = store.shown.replay ?? store.shown.left;
      for (const field of [close, choices[1]]) field.disabled = !replay;
      if (!replay) return;
      plot.mark(replay.time);
    };
    update();
    return update;
  },
});

/** The recordings that can be chosen; those of other robots cannot. */
function fill(choices, list, words) {
  for (const field of choices) field.replaceChildren(element("option", { value: "" }, "–"), ...list.map((one) => element("option", { value: one.number, disabled: !one.draws }, `${one.title} (${words.isolate(`${number(one.duration, 2)} s`)})`)));
}

/** How far two motions are apart, in sentences. */
function difference(both, words, data) {
  if (!both.largest && !both.joint_apart && !both.longer) return [element("p", {}, sentence(words, "apart_nothing"))];
  const unit = data.robot.joints[both.joint_place].prismatic ? "m" : "rad", list = [
    sentence(words, "apart_tip", { distance: `${number(1000 * both.largest, 3)} mm`, time: `${number(both.largest_time, 2)} s` }),
    sentence(words, "apart_joint", { joint: both.joint, angle: `${number(both.joint_apart, 5)} ${unit}`, time: `${number(both.joint_time, 2)} s` }),
  ];
  if (both.longer) list.push(sentence(words, both.longer > 0 ? "first_longer" : "second_longer", { time: `${number(Math.abs(both.longer), 3)} s` }));
  return list.map((one) => element("p", {}, one));
}

/** A curve over time with a mark where the replay is; from left to right in every language. */
class Curve {
  constructor() {
    this.line = drawn("polyline", { class: "curve", points: "" });
    this.now = drawn("line", { class: "now", y1: 0, y2: HEIGHT, x1: 0, x2: 0 });
    const drawing = drawn("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, preserveAspectRatio: "none", class: "distance", "aria-hidden": "true" });
    drawing.append(this.line, this.now);
    this.most = element("bdi", { dir: "ltr", class: "soft" });
    this.element = element("div", { dir: "ltr" }, element("div", {}, symbol("d"), " ", this.most), drawing);
    this.end = 1;
  }

  /** @param {number[]} t [s] @param {number[]} values [m] */
  draw(t, values) {
    const most = Math.max(...values, 1e-12);
    this.end = t.at(-1) || 1;
    this.line.setAttribute("points", values.map((value, k) => `${(WIDTH * t[k] / this.end).toFixed(1)},${((HEIGHT - 2) * (1 - value / most) + 1).toFixed(1)}`).join(" "));
    written(this.most, `0 … ${number(1000 * most, 3)} mm`);
  }

  mark(time) {
    const x = WIDTH * Math.min(1, time / this.end);
    this.now.setAttribute("x1", x);
    this.now.setAttribute("x2", x);
  }
}
