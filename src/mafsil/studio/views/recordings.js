// Recorded motions: one is replayed by the arm, a second beside it as a ghost; any signal of both on one axis of time.

import { between, lengthOf, posed, seek } from "page/core/tape.js";
import { view } from "page/core/views.js";
import { Plot } from "page/plot.js";
import { element, number, sentence } from "page/views/elements.js";

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
    const signal = element("select", { id: "signal", onchange: () => draw() }), curves = element("div", { id: "curves", dir: "ltr" });
    const said = element("div", { id: "comparison", role: "status" }), none = element("p", { class: "soft" }, sentence(words, "no_recordings"));
    const body = element(
      "div", {}, element("div", { class: "buttons" }, label("recording_first", choices[0]), label("recording_second", choices[1])),
      element("div", { class: "buttons" }, label("signal_shown", signal), close), curves, said
    );
    place.append(none, body);
    let listed = null, painted = "", plot = null, here = {};

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
      said.replaceChildren(...(failed ? [element("p", { class: "wrong" }, words.isolated(failed.error))] : both ? difference(both, words, app.data) : []));
      here = { first, second: second?.q ? second : null, both: both?.distance ? both : null };
      fillSignals(signal, app, here);
      draw();
      const shown = store.shown.replay ?? store.shown.left;
      if (shown && shown.first === first && shown.second === here.second) return;
      const time = first?.q && shown?.first.duration ? Math.min(shown.time, lengthOf(first)) : 0;
      store.show({ left: null, replay: first?.q ? posed({ first, second: here.second, time, playing: Boolean(store.shown.plays) }) : null, plays: false });
    }

    /** The signal that is chosen, of both recordings. */
    function draw() {
      curves.replaceChildren();
      plot = here.first?.q ? new Plot(curves, ...signalOf(signal.value, here, app), (time) => seek(store, time)) : null;
      if (!plot) return;
      plot.svg.setAttribute("aria-label", plot.plot.title);
      plot.rename({ title: plot.plot.title, names: plot.plot.names }, (key) => words.text(key));
      plot.measure((unit, curve) => app.scale(unit, curve));
      plot.mark((store.shown.replay ?? store.shown.left)?.time ?? 0);
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
      if (replay) plot?.mark(replay.time);
    };
    update();
    return update;
  },
});

/** The recordings that can be chosen; those of other robots cannot. */
function fill(choices, list, words) {
  for (const field of choices) field.replaceChildren(
    element("option", { value: "" }, "–"),
    ...list.map((one) => element("option", { value: one.number, disabled: !one.draws }, `${one.title} (${words.isolate(`${number(one.duration, 2)} s`)})`))
  );
}

/** What can be plotted: how far the tips are apart, the path error, each joint; what was chosen stays if it is there. */
function fillSignals(field, { words, data }, { both }) {
  const { value } = field, keys = [...(both ? ["apart"] : []), "tip_error"];
  field.replaceChildren(
    ...keys.map((key) => element("option", { value: key }, words.text(`signal_${key}`))),
    ...data.robot.joints.map(({ name }, k) => element("option", { value: k }, name))
  );
  field.value = value;
  if (field.selectedIndex < 0) field.selectedIndex = 0;
}

/** A plot of a signal, its times and its curves: the second recording at the times of the first, as long as it lasts. */
function signalOf(chosen, { first, second, both }, { words, data }) {
  const title = (key) => words.text(`signal_${key}`);
  if (chosen === "apart" && both) return [{ title: title("apart"), unit: "m", values: both.distance, names: [""] }, both.t, [""]];
  const joint = data.robot.joints[chosen], names = second ? [words.text("recording_first"), words.text("recording_second")] : [""];
  const at = (tape, time) => (time > lengthOf(tape) ? NaN : joint ? between(tape, time)[chosen] : between(
    { t: tape.t, q: tape.tip_error.map((x) => [x]) }, time
  )[0]);
  const values = first.t.flatMap((time) => [first, second].slice(0, names.length).map((tape) => at(tape, time)));
  return [{ title: joint?.name ?? title("tip_error"), unit: joint && !joint.prismatic ? "rad" : "m", values, names }, first.t, names];
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
