// Efforts that hold the arm against gravity, as shares of what its motors can.

import { view } from "../core/views.js";
import { element, isolated, number, sentence, written } from "./elements.js";

const HELD = 1e-6; // share of what is needed that driven joints may leave to nobody

/** Efforts of the driven joints of a robot with loops; no numbers where they do not hold it still. */
function loopEfforts([tau, , missing, , needed, , doubt]) {
  return doubt[0] < 1 && missing[0] <= HELD * Math.max(1, needed[0]) ? tau : tau.map(() => NaN);
}

/** The joints with motors, and the efforts that hold the arm still there; no numbers where nothing does. */
export function heldEfforts({ arm: { settings: { motors, n }, kernels }, state: { q } }, { robot }) {
  const rest = new Array(n).fill(0);
  return motors ? { motors, efforts: loopEfforts(kernels.closed_efforts(q, rest, rest)) } : {
    motors: robot.joints.map((_, k) => k), efforts: kernels.gravity_torque(q)[0]
  };
}

view({
  name: "gravity",
  tab: "analyse",
  order: 50,
  open: true,
  wanted: ({ kernels }) => "gravity_torque" in kernels || "closed_efforts" in kernels,
  mount(place, { store, words, data }) {
    const { effort } = store.arm.settings, { motors } = heldEfforts(store, data);
    const seen = element("input", { type: "checkbox", id: "show-loads", onchange: () => store.show({ loads: seen.checked }) });
    seen.checked = Boolean(store.shown.loads);
    place.append(element("p", { class: "soft" }, sentence(words, "gravity_about")), element("label", { class: "choice" }, seen, sentence(words, "loads_seen")));
    const rows = motors.map((k) => {
      const joint = data.robot.joints[k];
      const value = isolated("", { class: "value" }), bar = element("i", {});
      const most = effort[k] === null ? "" : ` / ${number(effort[k], 0)}`, unit = joint.prismatic ? "N" : "N·m";
      place.append(element(
        "div", { class: "bar" }, isolated(joint.name, { class: "name", title: joint.name }),
        element("span", { class: "track", dir: "ltr" }, bar),
        element("span", { dir: "ltr" }, value, isolated(`${most} ${unit}`, { class: "soft" }))
      ));
      return { value, bar };
    });
    return () => {
      const { efforts: tau } = heldEfforts(store, data), most = Math.max(1, ...Array.from(tau, Math.abs).filter(Number.isFinite));
      rows.forEach(({ value, bar }, k) => {
        const share = tau[k] / (effort[motors[k]] ?? most), width = 50 * Math.min(1, Math.abs(share));
        written(value, number(tau[k], 2));
        bar.style.insetInlineStart = `${share < 0 ? 50 - width : 50}%`;
        bar.style.inlineSize = `${width}%`;
        bar.classList.toggle("beyond", Math.abs(share) > 1);
      });
    };
  },
});
