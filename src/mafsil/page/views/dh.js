// The Denavit-Hartenberg table; a row that is pointed at shows its frame.

import { view } from "../core/views.js";
import { element, isolated, number, sentence, symbol } from "./elements.js";

view({
  name: "dh",
  order: 70,
  wanted: (arm, data) => Boolean(data.dh),
  mount(place, { store, words, data }) {
    const head = element("tr", {}, element("th", {}, "i"));
    for (const [letter, index] of [["α", "i−1"], ["a", "i−1"], ["d", "i"], ["θ", "i"]]) head.append(element("th", {}, symbol(letter, index)));
    const body = element("tbody", {});
    data.dh.rows.forEach((row, k) => {
      const show = () => store.show({ frame: k }), hide = () => store.show({ frame: -1 });
      const joint = (letter) => (row.prismatic === (letter === "d") ? ` + q${row.place + 1}` : "");
      const cells = [`${number(row.alpha * 180 / Math.PI, 2)}°`, `${number(row.a)} m`, `${number(row.d)} m${joint("d")}`, `${number(row.theta * 180 / Math.PI, 2)}°${joint("theta")}`];
      body.append(element("tr", { tabindex: 0, onpointerenter: show, onpointerleave: hide, onfocus: show, onblur: hide }, element("td", {}, isolated(String(k + 1))), ...cells.map((cell) => element("td", {}, isolated(cell)))));
    });
    place.append(element("p", { class: "soft" }, sentence(words, "dh_about")), element("div", { class: "wide" }, element("table", { dir: "ltr" }, element("thead", {}, head), body)));
    return () => {};
  },
});
