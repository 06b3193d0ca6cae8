// Joints: a slider and a number for each, its limits, and how much of the range is left.

import { view } from "../core/views.js";
import { hereOf } from "../core/state.js";
import { element, isolated, number, sentence } from "./elements.js";

const FREE = Math.PI; // half the range of a slider without limits [rad | m]

view({
  name: "joints",
  order: 10,
  open: true,
  mount(place, { store, words, data }) {
    const { lower, upper, start, driven } = store.arm.settings;
    const rows = data.robot.joints.map((joint, k) => {
      const low = lower[k] ?? -FREE, high = upper[k] ?? FREE, unit = joint.prismatic ? "m" : "rad";
      const set = (value, gesture) => store.do("set_joint", { joint: k, value }, { gesture });
      const range = element("input", { type: "range", min: low, max: high, step: "any", dir: "ltr", "aria-label": joint.name, oninput: (event) => set(Number(event.target.value), true), onchange: () => store.release() });
      const field = element("input", { type: "number", step: "any", dir: "ltr", "aria-label": `${joint.name} [${unit}]`, onchange: (event) => { if (event.target.value !== "" && Number.isFinite(Number(event.target.value))) set(Number(event.target.value), false); } });
      const bounds = `${number(lower[k] ?? -Infinity, 2)} … ${number(upper[k] ?? Infinity, 2)} ${unit}`;
      if (driven && !driven.includes(k)) field.disabled = range.disabled = true; // the loops move it
      const row = element("div", { class: "joint" }, isolated(joint.name, { class: "name", title: joint.name }), field, range, isolated(bounds, { class: "soft" }));
      place.append(row);
      return { row, range, field };
    });
    const button = (key, values) => element("button", { type: "button", class: "quiet", onclick: () => store.do("set_joints", { values }) }, sentence(words, key));
    place.append(element("div", { class: "buttons" }, button("to_start", start), button("to_zero", start.map(() => 0))));
    return () => {
      const here = hereOf(store.state);
      rows.forEach(({ row, range, field }, k) => {
        if (Number(range.value) !== here[k]) range.value = here[k];
        if (document.activeElement !== field) field.value = here[k].toFixed(5);
        const outside = here[k] < (lower[k] ?? -Infinity) - 1e-9 || here[k] > (upper[k] ?? Infinity) + 1e-9;
        row.classList.toggle("beyond", outside);
        range.setAttribute("aria-valuetext", number(here[k]));
      });
    };
  },
});
