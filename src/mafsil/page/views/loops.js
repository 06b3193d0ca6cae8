// A robot with loops: what moves, and what is left out because it is not computed with closed loops.

import { view } from "../core/views.js";
import { element, sentence } from "./elements.js";

view({
  name: "loops",
  order: 5,
  open: true,
  wanted: ({ settings }) => Boolean(settings.driven),
  mount(place, { store, words }) {
    const { settings, kernels } = store.arm, keys = [settings.driven.length ? "loops_move" : "loops_still", "loops_left_out"];
    if (!kernels.closed_efforts) keys.push("loops_no_loads");
    for (const key of keys) place.append(element("p", { class: "soft" }, sentence(words, key)));
    return () => {};
  },
});
