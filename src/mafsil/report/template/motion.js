// The plots of a run with their legend, one of them in the timeline, and their numbers as a table to be saved.

import { element, saveFile } from "../../page/views/elements.js";
import { Plot, TimeAxis, cell, figure, swatch } from "../../page/plot.js";
import { floats } from "../../page/stage/scenery.js";

export class Motion {
  /**
   * @param {object} data  of the report
   * @param {(time: number) => void} seek  where a plot was clicked [s]
   */
  constructor(data, seek) {
    const time = floats(data.time), bands = data.moves.map(({ from, to }) => [from, to]), place = document.getElementById("plots");
    Object.assign(this, { axis: new TimeAxis(), hidden: new Set(), docked: null });
    this.made = (parent, k) => new Plot(
      parent, { ...data.plots[k], bands }, time, data.plots[k].names.length ? data.texts[data.language].plots[k].names : data.joints, seek,
      this.axis
    );
    this.plots = data.plots.map((_, k) => this.made(place, k));
    this.ofJoints = this.plots.filter((_, k) => !data.plots[k].names.length);
    document.getElementById("legend").append(...data.joints.map((name, k) => this.joint(name, k)));
    document.getElementById("save-table").addEventListener("click", () => saveFile(`${document.title}.csv`, tableText(data, time, this.plots), "text/csv"));
    addEventListener("beforeprint", () => this.axis.show(null));
  }

  /** The legend belongs to all plots of joints: hover brings one joint forward with its limits, click hides it. */
  joint(name, k) {
    const choose = (chosen) => { for (const plot of this.ofJoints) { plot.chosen = chosen; plot.draw(); } };
    const hide = () => {
      if (!this.hidden.delete(k)) this.hidden.add(k);
      button.setAttribute("aria-pressed", String(!this.hidden.has(k)));
      for (const plot of this.ofJoints) Object.assign(plot, { hidden: this.hidden, chosen: null }).draw();
    };
    const button = element(
      "button",
      {
        type: "button", "aria-pressed": "true", onclick: hide, onpointerenter: () => { if (!this.hidden.has(k)) choose(k); },
        onpointerleave: () => choose(null)
      },
      swatch(k), element("span", {}, name)
    );
    return button;
  }

  /** A signal in the timeline, to be chosen among those that are plotted. @param {HTMLElement} bar */
  dock(bar) {
    const place = element("div", { id: "docked" });
    this.choice = element("select", { id: "signal", onchange: () => {
      this.docked?.card.remove();
      this.axis.plots = this.plots.slice();
      this.docked = this.choice.value === "" ? null : this.made(place, Number(this.choice.value));
      this.speak(...this.said);
    } });
    bar.append(this.choice, place);
  }

  /** @param {number} time  where the replay is [s] */
  mark(time) {
    for (const plot of this.axis.plots) plot.mark(time);
  }

  /** In other units. @param {(unit: string, curve: number) => {factor: number, sign: string}} measure */
  measure(measure) {
    this.measured = measure;
    for (const plot of this.axis.plots) plot.measure(measure);
  }

  /** In a language. @param {{title: string, names: string[]}[]} texts @param {(key: string) => string} say */
  speak(texts, say) {
    this.said = [texts, say];
    this.plots.forEach((plot, k) => plot.rename(texts[k], say));
    if (!this.choice) return;
    const { value } = this.choice;
    this.choice.setAttribute("aria-label", say("signal_shown"));
    this.choice.replaceChildren(element("option", { value: "" }, say("signal_shown")), ...texts.map(({ title }, k) => element("option", { value: k }, title)));
    this.choice.value = value;
    this.docked?.rename(texts[Number(value)], say);
    if (this.docked && this.measured) this.docked.measure(this.measured);
  }
}

/** The numbers of all plots for spreadsheets: columns named as in recording.csv. */
export function tableText(data, time, plots) {
  const heads = [
    "t",
    ...data.plots.flatMap(({ column, names, keys }) => keys.length
      ? keys.map(key => `${column}[${key}]`) : names.length ? [column] : data.joints.map(joint => `${column}[${joint}]`))
  ];
  const lines = Array.from(
    time,
    (t, row) => [t, ...plots.flatMap(({ values, joints }) => Array.from(values.subarray(row * joints.length, (row + 1) * joints.length)))]
  );
  return [heads.map(cell), ...lines.map(line => line.map(figure))].map(line => line.join(",")).join("\n") + "\n";
}
