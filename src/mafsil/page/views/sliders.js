// Joints: a slider and a number for each, its limits, and how much of the range is left.

import { view } from "../core/views.js";
import { hereOf } from "../core/state.js";
import { decimals, element, isolated, number, sentence, written } from "./elements.js";

const FREE = Math.PI; // half the range of a slider without limits [rad]
const MOST_TURNS = 40, LOOSE = 1e-9; // half turns that a field without limits takes; what typing rounds

view({
  name: "joints",
  order: 10,
  open: true,
  mount(place, app) {
    const { store, words, data } = app, { lower, upper, start, driven } = store.arm.settings;
    const followers = element("div", {}); // joints that the loops move
    const rows = data.robot.joints.map((joint, k) => {
      const free = joint.prismatic ? data.scene.size : FREE, low = lower[k] ?? -free, high = upper[k] ?? free,
        { sign, factor, digits } = app.unit(joint.prismatic);
      const set = (value, gesture) => store.do("set_joint", { joint: k, value }, { gesture });
      const range = element(
        "input",
        {
          type: "range", min: low, max: high, step: "any", dir: "ltr", "aria-label": joint.name,
          oninput: (event) => set(Number(event.target.value), true), onchange: () => store.release()
        }
      );
      const bounds = lower[k] === null && upper[k] === null ? words.text("no_limits") : `${number((lower[k] ?? -Infinity) * factor,
        digits)} … ${number((upper[k] ?? Infinity) * factor, digits)} ${sign}`;
      const value = isolated("", { class: "soft" });
      const typed = () => {
        const value = field.value === "" ? NaN : Number(field.value) / factor, most = Math.max(MOST_TURNS * FREE, data.scene.size * 10);
        const taken = Math.abs(value) < most && value >= (lower[k] ?? -most) - LOOSE && value <= (upper[k] ?? most) + LOOSE;
        field.setAttribute("aria-invalid", String(!taken));
        if (taken) set(value, false);
        else app.say({ key: "why_field", values: { name: joint.name, bounds: words.isolate(bounds) } });
      };
      const field = element(
        "input",
        {
          type: "number", step: "any", dir: "ltr", "aria-label": `${joint.name} [${sign}]`, onchange: typed,
          onblur: () => { field.removeAttribute("aria-invalid"); app.draw(); }
        }
      );
      const name = isolated(joint.name, { class: "name", title: joint.name }), passive = driven && !driven.includes(k);
      const touch = (touched) => () => store.show({ touched });
      const row = element(
        "div", { class: "joint", onpointerenter: touch(k), onpointerleave: touch(-1), onfocusin: touch(k), onfocusout: touch(-1) }, name,
        ...(passive ? [value] : [
          field, range,
          isolated(
            bounds,
            { class: "soft bounds", title: free === high ? words.text("slider_ends", { end: words.isolate(`${number(free * factor, digits)} ${sign}`) }) : "" }
          )
        ])
      );
      (passive ? followers : place).append(row);
      return { row, range, field, value, sign, factor, digits: digits + 2 };
    });
    if (followers.childElementCount) place.append(element("p", { class: "soft" }, sentence(words, "followers")), followers);
    const button = (key, values) => element(
      "button", { type: "button", class: "quiet", onclick: () => store.do("set_joints", { values }) }, sentence(words, key)
    );
    const preview = (q) => () => store.show({ preview: driven ? null : q }), hide = preview(null);
    const posture = ({ name, q }) => element(
      "button",
      {
        type: "button", class: "quiet", "data-posture": name, onclick: () => { hide(); store.do("set_joints", { values: q }); },
        onpointerenter: preview(q), onfocus: preview(q), onpointerleave: hide, onblur: hide
      },
      isolated(name)
    );
    place.append(element(
      "div", { class: "buttons" }, button("to_start", start),
      button("to_zero", start.map((_, k) => Math.min(Math.max(0, lower[k] ?? 0), upper[k] ?? Infinity))), ...data.postures.map(posture)
    ));
    return () => {
      const here = hereOf(store.state);
      rows.forEach(({ row, range, field, value, sign, factor, digits }, k) => {
        written(value, `${number(here[k] * factor, digits)} ${sign}`);
        if (Number(range.value) !== here[k]) range.value = here[k];
        if (document.activeElement !== field) field.value = decimals(here[k] * factor, digits);
        const outside = here[k] < (lower[k] ?? -Infinity) - 1e-9 || here[k] > (upper[k] ?? Infinity) + 1e-9;
        row.classList.toggle("beyond", outside);
        range.setAttribute("aria-valuetext", number(here[k] * factor, digits));
      });
    };
  },
});
