// The tip's pose in several representations; numbers typed here lead the tool there.

import { view } from "../core/views.js";
import { isLed } from "../loops/follow.js";
import { quaternionFrom, quaternionOf, rollPitchYaw, rotationVector } from "../core/rotations.js";
import { decimals, element, isolated, matrix, number, sentence, symbol, written } from "./elements.js";

const FIELDS = ["x", "y", "z", "roll", "pitch", "yaw"];

view({
  name: "pose",
  order: 20,
  open: true,
  mount(place, app) {
    const units = FIELDS.map((_, k) => app.unit(k < 3));
    const { store, words } = app, T_sb = matrix(4, 4, [symbol("T", "sb", "=")]);
    const shown = () => {
      const T = store.arm.kernels.forward_kinematics(store.state.q)[0];
      return [T[3], T[7], T[11], ...rollPitchYaw(T)].map((value, k) => value * units[k].factor);
    };
    const step = (k) => ({ rad: 0.02, "°": 1, m: 0.01, mm: 10 })[units[k].sign];
    const fields = FIELDS.map((name, k) => element(
      "input",
      { type: "number", step: step(k), dir: "ltr", "aria-label": `${name} [${units[k].sign}]`, onchange: lead, onblur: () => app.draw() }
    ));
    function lead() {
      const values = fields.map((field, k) => Number(field.value) / units[k].factor);
      if (!values.every(Number.isFinite)) return;
      app.stage.drag.start(0, 0);
      app.stage.drag.lead(values.slice(0, 3), quaternionFrom(values.slice(3)));
      store.release();
    }
    const { driven } = store.arm.settings;
    fields.forEach((field, k) => { field.disabled = !isLed(store.arm) || (k > 2 && driven?.length < 6); });
    const grid = element("div", { class: "fields", dir: "ltr" });
    FIELDS.forEach((name, k) => grid.append(element("label", {}, `${name} [${units[k].sign}]`, fields[k])));
    const quaternion = isolated(""), vector = isolated("");
    const list = element("dl", { class: "tall" });
    for (const [key, value] of [["quaternion", quaternion], ["rotation_vector", vector]]) list.append(
      element("dt", {}, sentence(words, key)), element("dd", {}, value)
    );
    place.append(grid, element("div", { class: "wide", dir: "ltr", tabindex: 0, role: "group", "aria-label": words.text("view_pose") }, T_sb.math), list);
    return () => {
      const T = store.arm.kernels.forward_kinematics(store.state.q)[0].slice();
      T_sb.write([0, 4, 8, 12].map((k) => Array.from(T.subarray(k, k + 4))));
      written(quaternion, `(${quaternionOf(T).map((x) => number(x)).join(", ")})`);
      written(vector, `(${rotationVector(T).map((x) => number(x)).join(", ")}) rad`);
      shown().forEach((value, k) => {
        if (document.activeElement !== fields[k]) fields[k].value = decimals(value, units[k].digits + 1);
      });
    };
  },
});
