// The moves of a recorded run, one after the other; pressed, the replay goes to where one begins.

import { seek } from "../core/tape.js";
import { view } from "../core/views.js";
import { element, isolated, number } from "./elements.js";

view({
  name: "moves",
  tab: "job",
  order: 68,
  open: true,
  wanted: (arm, data) => Boolean(data.moves?.length),
  mount(place, { store, words, data, player }) {
    const rows = data.moves.map(({ from, to }, k) => element(
      "button", { type: "button", onclick: () => seek(store, from) }, element("i", {}),
      element("bdi", {}, data.texts[words.chosen].moves[k]), isolated(`${number(from, 2)} … ${number(to, 2)} s`, { class: "soft" })
    ));
    place.append(element("div", { class: "branches" }, ...rows));
    return () => {
      const time = store.shown.replay ? player.replay.time : -1, active = data.moves.findLastIndex(({ from }) => from <= time);
      rows.forEach((row, k) => row.setAttribute("aria-pressed", String(k === active)));
    };
  },
});
