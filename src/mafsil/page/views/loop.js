// The closed loop: a controller holds the arm at its goal while something pushes the tip.

import { view } from "../core/views.js";
import { element, isolated, number, sentence, written } from "./elements.js";

const MOST_FORCE = 40; // N
const MOST_TICKS = 34; // of a frame: a page that was away does not hurry after the time

view({
  name: "loop",
  order: 60,
  open: true,
  wanted: ({ kernels }) => "closed_loop" in kernels,
  mount(place, app) {
    const { store, words, data } = app, unit = data.robot.joints.some((joint) => joint.prismatic) ? "rad | m" : "rad", time = isolated(""), away = isolated("");
    const toggle = element(
      "button",
      {
        type: "button", id: "loop", class: "strong",
        onclick: () => { app.playing = !store.state.loop; store.do("loop", { closed: app.playing }); app.last = performance.now(); }
      }
    );
    const forces = ["x", "y", "z"].map((axis, k) => element(
      "input",
      { type: "range", min: -MOST_FORCE, max: MOST_FORCE, step: 1, value: 0, dir: "ltr", "aria-label": `${axis} [N]`, oninput: () => push(true) }
    ));
    function push(gesture) {
      store.do("push", { wrench: [0, 0, 0, ...forces.map((field) => Number(field.value))] }, { gesture });
    }
    const none = element(
      "button", { type: "button", class: "quiet", onclick: () => { for (const field of forces) field.value = 0; push(false); } },
      sentence(words, "no_push")
    );
    const grid = element("div", { class: "forces", dir: "ltr" });
    forces.forEach((field, k) => grid.append(element("label", {}, `F${"xyz"[k]} [N]`, field)));
    place.append(
      element("p", { class: "soft" }, sentence(words, "loop_about")), element("div", { class: "buttons" }, toggle, none), grid,
      element("p", { "aria-live": "off" }, sentence(words, "loop_time"), " ", time, " · ", sentence(words, "loop_away"), " ", away)
    );
    let label = null;
    const update = () => {
      const { state, arm } = store;
      if (label !== state.loop) toggle.replaceChildren(sentence(words, (label = state.loop) ? "loop_open" : "loop_close"));
      for (const field of [...forces, none]) field.disabled = !state.loop;
      forces.forEach((field, k) => { if (document.activeElement !== field) field.value = state.push[3 + k]; });
      written(time, `${number(state.ticks * arm.settings.step, 2)} s`);
      written(away, `${number(Math.max(...state.q.map((value, k) => Math.abs(value - state.goal[k]))), 4)} ${unit}`);
    };
    update();
    return update;
  },
  tick,
});

/** Let as much time pass in the loop as has passed for whoever watches. */
function tick(app, now) {
  const { store } = app;
  if (!store.state.loop || !app.playing) return false;
  const ticks = Math.min(MOST_TICKS, Math.floor((now - app.last) / (1000 * store.arm.settings.step)));
  if (ticks > 0) {
    app.last = ticks === MOST_TICKS ? now : app.last + 1000 * ticks * store.arm.settings.step;
    store.do("simulate", { ticks }, { gesture: store.journal.at(-1)?.do === "simulate" });
    store.open = true;
    if (store.state.status === "diverged") app.playing = false;
  }
  return true;
}
