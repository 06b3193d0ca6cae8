// The plots of a run with their legend, and their numbers as a table to be saved.

import { element } from "../../page/views/elements.js";
import { Plot, swatch } from "./plot.js";
import { floats } from "../../page/stage/scenery.js";
import { saveTable, tableText } from "./table.js";

export class Motion {
  /**
   * @param {object} data  of the report
   * @param {(time: number) => void} seek  where a plot was clicked [s]
   */
  constructor(data, seek) {
    const time = floats(data.time), bands = data.moves.map(({ from, to }) => [from, to]), place = document.getElementById("plots");
    this.plots = data.plots.map((plot, k) => new Plot(place, { ...plot, bands }, time, plot.names.length ? data.texts[data.language].plots[k].names : data.joints, seek));
    this.ofJoints = this.plots.filter((_, k) => !data.plots[k].names.length);
    this.hidden = new Set();
    document.getElementById("legend").append(...data.joints.map((name, k) => this.joint(name, k)));
    document.getElementById("save-table").addEventListener("click", () => saveTable(`${document.title}.csv`, tableText(data, time, this.plots)));
    addEventListener("beforeprint", () => { for (const plot of this.plots) plot.draw(); });
  }

  /** The legend belongs to all plots of joints: hover brings one joint forward with its limits, click hides it. */
  joint(name, k) {
    const choose = (chosen) => { for (const plot of this.ofJoints) { plot.chosen = chosen; plot.draw(); } };
    const hide = () => {
      if (!this.hidden.delete(k)) this.hidden.add(k);
      button.setAttribute("aria-pressed", String(!this.hidden.has(k)));
      for (const plot of this.ofJoints) Object.assign(plot, { hidden: this.hidden, chosen: null }).draw();
    };
    const button = element("button", { type: "button", "aria-pressed": "true", onclick: hide, onpointerenter: () => { if (!this.hidden.has(k)) choose(k); }, onpointerleave: () => choose(null) }, swatch(k), element("span", {}, name));
    return button;
  }

  /** @param {number} time  where the replay is [s] */
  mark(time) {
    for (const plot of this.plots) plot.mark(time);
  }

  /** In a language. @param {{title: string, names: string[]}[]} texts @param {string} share  what the buttons say */
  speak(texts, share) {
    this.plots.forEach((plot, k) => plot.rename(texts[k], share));
  }
}
