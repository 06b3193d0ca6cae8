// The body Jacobian, its singular values and manipulability.

import { view } from "../core/views.js";
import { singularValues, tipEllipsoids } from "../core/linear.js";
import { hasJacobian, tipJacobian } from "../loops/follow.js";
import { element, isolated, matrix, number, sentence, symbol, written } from "./elements.js";

view({
  name: "jacobian",
  tab: "analyse",
  order: 40,
  open: true,
  wanted: hasJacobian,
  mount(place, { store, words, data }) {
    const names = { rows: [..."xyz"].map((axis) => `ω${axis} [rad/s]`).concat([..."xyz"].map((axis) => `v${axis} [m/s]`)), columns: [] };
    const { n, joints } = tipJacobian(store.state.q, store.arm);
    names.columns = joints.map((k) => `q${k} [${data.robot.joints[k].prismatic ? "m/s" : "rad/s"}]`);
    const J_b = matrix(6, n, [symbol("J", "b", "=")], names), values = isolated(""), measure = isolated("");
    const list = element(
      "dl", { class: "tall" }, element("dt", {}, sentence(words, "singular_values")), element("dd", {}, values),
      element("dt", {}, sentence(words, "manipulability")), element("dd", {}, measure)
    );
    const choices = element("div", { class: "buttons" });
    for (const name of ["ellipsoid", "forces"]) {
      const choice = element("input", { type: "checkbox", id: `show-${name}`, onchange: (event) => store.show({ [name]: event.target.checked }) });
      choice.checked = store.shown[name];
      choices.append(element("label", { class: "choice" }, choice, sentence(words, name)));
    }
    const axes = [isolated(""), isolated("")];
    for (const [k, name] of ["ellipsoid", "forces"].entries()) list.append(element("dt", {}, sentence(words, `${name}_axes`)), element("dd", {}, axes[k]));
    place.append(
      list, choices,
      element("div", { class: "wide small", dir: "ltr", tabindex: 0, role: "group", "aria-label": words.text("view_jacobian") }, J_b.math)
    );
    return () => {
      const T = store.arm.kernels.forward_kinematics(store.state.q)[0].slice(), { J } = tipJacobian(store.state.q, store.arm);
      const rows = Array.from({ length: 6 }, (_, i) => Array.from(J.subarray(n * i, n * i + n)));
      J_b.write(rows);
      const found = singularValues(rows).slice(0, Math.min(6, n));
      written(values, found.map((x) => number(x, 3)).join("  "));
      const { velocities, forces } = tipEllipsoids(J, n, T);
      written(axes[0], velocities.map((x) => number(x, 3)).join("  "));
      written(axes[1], forces.map((x) => number(x ?? Infinity, 3)).join("  "));
      written(measure, number(found.reduce((a, b) => a * b, 1)));
    };
  },
});
