// Efforts that hold the arm against gravity, as shares of what its motors can.

import { view } from "../core/views.js";
import { element, isolated, number, sentence, written } from "./elements.js";

view({
  name: "gravity",
  order: 50,
  wanted: ({ kernels }) => "gravity_torque" in kernels,
  mount(place, { store, words, data }) {
    const { effort } = store.arm.settings;
    place.append(element("p", { class: "soft" }, sentence(words, "gravity_about")));
    const rows = data.robot.joints.map((joint, k) => {
      const value = isolated("", { class: "value" }), bar = element("i", {});
      const most = effort[k] === null ? "" : ` / ${number(effort[k], 0)}`, unit = joint.prismatic ? "N" : "N·m";
      place.append(element("div", { class: "bar" }, isolated(joint.name, { class: "name", title: joint.name }), element("span", { class: "track", dir: "ltr" }, bar), element("span", { dir: "ltr" }, value, isolated(`${most} ${unit}`, { class: "soft" }))));
      return { value, bar };
    });
    return () => {
      const tau = store.arm.kernels.gravity_torque(store.state.q)[0], most = Math.max(1, ...Array.from(tau, Math.abs));
      rows.forEach(({ value, bar }, k) => {
        const share = tau[k] / (effort[k] ?? most), width = 50 * Math.min(1, Math.abs(share));
        written(value, number(tau[k], 2));
        bar.style.insetInlineStart = `${share < 0 ? 50 - width : 50}%`;
        bar.style.inlineSize = `${width}%`;
        bar.classList.toggle("beyond", Math.abs(share) > 1);
      });
    };
  },
});
