// The Denavit-Hartenberg table; a row shows its frame, and numbers that are changed draw the arm that they make.

import { dhChain, dhPython } from "../core/dh.js";
import { view } from "../core/views.js";
import { element, isolated, number, sentence, symbol, written } from "./elements.js";

const DEGREE = Math.PI / 180;
const COLUMNS_OF_ROW = [["alpha", "°", DEGREE], ["a", "m", 1], ["d", "m", 1], ["theta", "°", DEGREE]];
const tidy = (x) => Number(x.toFixed(6)); // for reading: what is not edited keeps all its digits

view({
  name: "dh",
  tab: "model",
  order: 70,
  open: true,
  wanted: (arm, data) => Boolean(data.dh),
  mount(place, { store, words, data }) {
    const head = element("tr", {}, element("th", {}, "i"));
    for (const [letter, index, unit] of [
      ["α", "i−1", "°"], ["a", "i−1", "m"], ["d", "i", "m"], ["θ", "i", "°"]
    ]) head.append(element("th", {}, symbol(letter, index), ` [${unit}]`));
    const body = element("tbody", {}), fields = [];
    const rowsNow = () => (store.shown.table ?? data.dh).rows;
    /** One number of the table is another; the arm itself stays what it is. */
    const edit = (k, name, factor, event) => {
      const value = event.target.valueAsNumber;
      if (!Number.isFinite(value)) return;
      store.show({ table: { ...data.dh, rows: rowsNow().map((row, i) => (i === k ? { ...row, [name]: value * factor } : row)) } });
    };
    data.dh.rows.forEach((row, k) => {
      const show = () => store.show({ frame: k }), hide = () => store.show({ frame: -1 });
      const cells = COLUMNS_OF_ROW.map(([name, unit, factor]) => {
        const field = element(
          "input",
          {
            type: "number", step: unit === "m" ? "0.01" : "1", dir: "ltr", "aria-label": `${name} ${k + 1} [${unit}]`,
            onchange: (event) => edit(k, name, factor, event)
          }
        );
        fields.push({ field, k, name, factor });
        const moves = name === (row.prismatic ? "d" : "theta");
        return element("td", {}, element("span", { class: "cell" }, field, ...(moves ? [isolated(`+ q${row.place + 1}`)] : [])));
      });
      body.append(element(
        "tr", { onpointerenter: show, onpointerleave: hide, onfocusin: show, onfocusout: hide }, element("td", {}, isolated(String(k + 1))),
        ...cells
      ));
    });
    const undo = element("button", { type: "button", class: "quiet", id: "dh-back", onclick: () => store.show({ table: null }) }, sentence(words, "dh_back"));
    const away = isolated(""), code = element("pre", { dir: "ltr", tabindex: 0, role: "region", id: "dh-code", "aria-label": words.text("dh_code") });
    const edited = element(
      "div", {}, element("p", {}, sentence(words, "dh_away"), " ", away), element("p", { class: "soft" }, sentence(words, "dh_code")), code,
      undo
    );
    place.append(
      element("p", { class: "soft" }, sentence(words, "dh_about")),
      element("div", { class: "wide" }, element("table", { dir: "ltr" }, element("thead", {}, head), body)), edited
    );
    return () => {
      const { table } = store.shown, rows = rowsNow();
      for (const { field, k, name, factor } of fields) if (document.activeElement !== field) field.value = tidy(rows[k][name] / factor);
      edited.hidden = !table;
      if (!table) return;
      const [here, there] = [data.dh, table].map((one) => dhChain(one, store.state.q).at(-1));
      written(away, `${number(Math.hypot(...[3, 7, 11].map((k) => here[k] - there[k])))} m`);
      written(code, dhPython(table));
    };
  },
});
