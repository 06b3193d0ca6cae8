// Line plots as SVG: shared time axis that is zoomed, one cursor for all, values in the unit that is chosen, limits of the
// chosen joint, curves as share of their limit; each as a picture and as a table.

import { floats } from "./stage/scenery.js";
import { drawn, element, saveFile } from "./views/elements.js";

const PAD = { left: 52, right: 10, top: 10, bottom: 26 };
const DRAG = 6, CLOSEST = 500; // pixels from which on a press chooses a range; share of the whole that a zoom may show
const INKS = ["stroke", "fill", "stroke-width", "stroke-dasharray", "opacity", "font-size", "font-family"];
const DIGITS = 7; // what a page carries

function make(tag, attributes, parent, text) {
  const node = drawn(tag, attributes);
  if (text !== undefined) node.textContent = text;
  if (parent) parent.append(node);
  return node;
}
function ticks(low, high, wanted) {
  const raw = (high - low) / wanted, power = Math.pow(10, Math.floor(Math.log10(raw)));
  const step = [1, 2, 2.5, 5, 10].map(f => f * power).find(s => s >= raw), list = [];
  for (let v = Math.ceil(low / step - 1e-9) * step; v <= high + step * 1e-9; v += step) list.push(Math.abs(v) < step * 1e-9 ? 0 : v);
  return { list, digits: Math.max(0, Math.min(9, -Math.floor(Math.log10(step) + 1e-9) + (Math.abs(step / power - 2.5) < 1e-9 ? 1 : 0))) };
}
/** A patch in the colour of a curve. @param {number} k */
export function swatch(k) {
  const patch = element("i");
  patch.style.background = `var(--s${k % 8})`;
  return patch;
}
const brief = v => Math.abs(v) >= 1e4 || (v !== 0 && Math.abs(v) < 1e-3) ? v.toExponential(2) : Number(v.toPrecision(4)).toString();
/** A cell of a table; quoted where a comma or a quotation mark would end it. */
export const cell = text => /[",\n\r]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
export const figure = value => Number.isFinite(value) ? String(Number(value.toPrecision(DIGITS))) : Number.isNaN(value) ? "nan" : value > 0 ? "inf" : "-inf";

/** The time that plots share: what of it is seen, and the moment that is pointed at. */
export class TimeAxis {
  constructor() {
    Object.assign(this, { plots: [], window: null });
  }
  /** See another part of the time, or all of it. @param {[number, number] | null} window [s] */
  show(window) {
    this.window = window;
    for (const plot of this.plots) plot.draw();
  }
  /** Nearer or farther about a moment. @param {Plot} plot @param {number} t @param {number} factor */
  zoom({ from, to, last }, t, factor) {
    const span = Math.min(last, Math.max(last / CLOSEST, (to - from) * factor)), begin = Math.max(
      0, Math.min(last - span, t - (t - from) * span / (to - from))
    );
    this.show(span >= last * (1 - 1e-9) ? null : [begin, begin + span]);
  }
  /** The moment that is pointed at, in all plots; null for none. @param {number | null} t */
  point(t) {
    for (const plot of this.plots) plot.point(t);
  }
}

export class Plot {
  /**
   * @param {HTMLElement} parent
   * @param {object} plot  title, values (numbers, or base64 of them), limits, unit, names, bands in time
   * @param {ArrayLike<number>} time  [s]
   * @param {string[]} joints  names of the curves
   * @param {(time: number) => void} seek  called where the plot is clicked
   * @param {TimeAxis} axis
   */
  constructor(parent, plot, time, joints, seek, axis = new TimeAxis()) {
    Object.assign(
      this,
      { plot, time, joints, seek, axis, share: false, chosen: null, hidden: new Set(), factors: joints.map(() => 1), unit: plot.unit, from: 0, to: 1, last: 1 }
    );
    this.values = typeof plot.values === "string" ? floats(plot.values) : plot.values;
    this.title = element("h3", {});
    const button = (mark, act) => element("button", { type: "button", class: "quiet share", "data-do": mark, onclick: act });
    this.button = plot.limits ? button("share", () => { this.share = !this.share; this.draw(); }) : null;
    this.whole = button("whole", () => axis.show(null));
    this.savers = [
      button("svg", () => saveFile(`${this.plot.title}.svg`, this.picture(), "image/svg+xml")),
      button("csv", () => saveFile(`${this.plot.title}.csv`, this.table(), "text/csv"))
    ];
    this.svg = make("svg", { role: "img", direction: "ltr", tabindex: 0 });
    this.tip = element("div", { class: "tip", dir: "ltr", hidden: true });
    this.key = element("div", { class: "key" });
    this.card = element(
      "figure", { class: "plot" },
      element("div", { class: "head" }, this.title, element("span", { class: "tools" }, ...(this.button ? [this.button] : []), this.whole, ...this.savers)),
      this.svg, this.tip, this.key
    );
    parent.append(this.card);
    axis.plots.push(this);
    this.listen();
  }
  listen() {
    let begin = null;
    const range = e => [begin, this.timeAt(e)].sort((a, b) => a - b), { svg, axis } = this;
    svg.addEventListener("pointermove", e => { this.probe(e); if (begin !== null && e.buttons) this.brush(...range(e)); });
    svg.addEventListener("pointerleave", () => { this.tip.hidden = true; axis.point(null); });
    svg.addEventListener("pointerdown", e => { begin = e.pointerType === "mouse" && e.button === 0 ? this.timeAt(e) : null; });
    svg.addEventListener(
      "pointerup",
      e => { if (begin !== null && this.x(range(e)[1]) - this.x(range(e)[0]) > DRAG) axis.show(range(e)); else this.seek(this.timeAt(e)); begin = null; }
    );
    svg.addEventListener("dblclick", () => axis.show(null));
    svg.addEventListener(
      "wheel",
      e => {
        if (!e.ctrlKey && !e.shiftKey) return;
        e.preventDefault();
        axis.zoom(this, this.timeAt(e), Math.exp(Math.max(-60, Math.min(60, e.deltaY || e.deltaX)) * 0.006));
      },
      { passive: false }
    );
    svg.addEventListener("keydown", e => {
      const act = {
        "+": () => axis.zoom(this, this.now ?? 0, 0.6), "-": () => axis.zoom(this, this.now ?? 0, 1 / 0.6), Home: () => axis.show(null),
        ArrowLeft: () => this.seek(Math.max(0, (this.now ?? 0) - (this.to - this.from) / 50)),
        ArrowRight: () => this.seek(Math.min(this.last, (this.now ?? 0) + (this.to - this.from) / 50))
      }[e.key];
      if (act) { act(); e.preventDefault(); }
    });
    new ResizeObserver(() => this.draw()).observe(svg);
  }
  // Several curves that are no joints are named below them.
  nameCurves() {
    this.key.replaceChildren();
    if (this.plot.names.length < 2) return;
    this.joints.forEach((name, j) => {
      this.key.append(element("span", {}, swatch(j), element("bdi", {}, name)));
    });
  }
  // Say it in a language: its title, the names of its curves, what the buttons do.
  rename({ title, names }, say) {
    this.plot.title = title;
    this.svg.setAttribute("aria-label", title);
    if (names.length) this.joints = names;
    this.nameCurves();
    if (this.button) this.button.textContent = say("share");
    this.whole.textContent = say("whole_time");
    this.savers.forEach((button, k) => {
      const key = ["save_picture", "save_values"][k];
      button.textContent = ["svg", "csv"][k];
      button.title = say(key);
      button.setAttribute("aria-label", `${say(key)}: ${title}`);
    });
    this.draw();
  }
  /** Values in other units. @param {(unit: string, curve: number) => {factor: number, sign: string}} measure */
  measure(measure) {
    this.factors = this.joints.map((_, j) => measure(this.plot.unit, j).factor);
    this.unit = measure(this.plot.unit, 0).sign;
    this.draw();
  }
  // Value of joint j at row i, as drawn: in its unit, or in percent of the bound it moves towards.
  at(i, j) {
    const v = this.values[i * this.joints.length + j];
    if (!this.share) return v * this.factors[j];
    const [low, high] = this.plot.limits[j];
    if (low === null || high === null) return NaN;
    const middle = (low + high) / 2, half = (high - low) / 2;
    return 100 * (v - middle) / half;
  }
  // Rows that are seen, and one beyond on either side.
  rows() {
    const { time, from, to } = this;
    let first = 0, end = time.length;
    while (first + 1 < end && time[first + 1] < from) first++;
    while (end - 2 > first && time[end - 2] > to) end--;
    return [first, end];
  }
  extent() {
    let low = Infinity, high = -Infinity;
    const take = v => { if (Number.isFinite(v)) { low = Math.min(low, v); high = Math.max(high, v); } }, [first, end] = this.rows();
    for (let j = 0; j < this.joints.length; j++) if (!this.hidden.has(j)) for (let i = first; i < end; i++) take(this.at(i, j));
    if (this.share) { take(-100); take(100); }
    else if (this.chosen !== null && this.plot.limits) this.plot.limits[this.chosen].forEach(v => { if (v !== null) take(v * this.factors[this.chosen]); });
    if (low > high) { low = -1; high = 1; }
    if (high - low < 1e-12) { const d = Math.max(Math.abs(high) * 0.1, 1e-9); low -= d; high += d; }
    const margin = (high - low) * 0.06;
    return [low - margin, high + margin];
  }
  draw() {
    const width = this.svg.clientWidth || 480, height = this.svg.clientHeight || 250;
    this.last = this.time[this.time.length - 1] || 1;
    [this.from, this.to] = this.axis.window ?? [0, this.last];
    this.svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    this.svg.replaceChildren();
    this.whole.hidden = !this.axis.window;
    const [low, high] = this.extent();
    this.x = t => PAD.left + (width - PAD.left - PAD.right) * (t - this.from) / (this.to - this.from);
    this.y = v => height - PAD.bottom - (height - PAD.top - PAD.bottom) * (v - low) / (high - low);
    this.title.replaceChildren(`${this.plot.title ?? ""} `, element("bdi", { class: "soft", dir: "ltr" }, this.share ? "[%]" : `[${this.unit}]`));
    if (this.button) this.button.setAttribute("aria-pressed", this.share);
    this.grid(low, high, width, height);
    const inside = make(
      "svg",
      {
        x: PAD.left, y: 0, width: Math.max(0, width - PAD.left - PAD.right), height,
        viewBox: `${PAD.left} 0 ${Math.max(1, width - PAD.left - PAD.right)} ${height}`
      },
      this.svg
    );
    this.joints.forEach((_, j) => { if (!this.hidden.has(j)) this.curve(j, inside); });
    this.limitLines(width);
    const line = name => make("line", { class: name, y1: PAD.top, y2: height - PAD.bottom, visibility: "hidden" }, this.svg);
    this.probeLine = line("probe");
    this.range = make("rect", { class: "range", y: PAD.top, height: height - PAD.top - PAD.bottom, visibility: "hidden" }, this.svg);
    this.cursor = line("cursor");
    this.mark(this.now || 0);
  }
  grid(low, high, width, height) {
    const rows = ticks(low, high, 7), columns = ticks(
      this.from, this.to, Math.max(3, Math.floor(width / 85))
    ), within = t => Math.max(this.from, Math.min(this.to, t));
    (this.plot.bands ?? []).forEach(([from, to], k) => {
      if (k % 2) make(
        "rect",
        {
          class: "band", x: this.x(within(from)), width: Math.max(0, this.x(within(to)) - this.x(within(from))), y: PAD.top,
          height: height - PAD.top - PAD.bottom
        },
        this.svg
      );
    });
    for (const v of rows.list) {
      make("line", { class: v === 0 ? "zero" : "grid", x1: PAD.left, x2: width - PAD.right, y1: this.y(v), y2: this.y(v) }, this.svg);
      make(
        "text", { x: PAD.left - 7, y: this.y(v) + 4, "text-anchor": "end" }, this.svg,
        v === 0 ? "0" : (Math.abs(high - low) < 0.004 || Math.abs(v) >= 1e5) ? v.toExponential(1) : v.toFixed(rows.digits)
      );
    }
    for (const t of columns.list) make(
      "text", { x: this.x(t), y: height - 8, "text-anchor": this.x(t) > 0.97 * width ? "end" : "middle" }, this.svg,
      t.toFixed(columns.digits) + (t === columns.list[columns.list.length - 1] ? " s" : "")
    );
  }
  curve(j, parent) {
    let path = "", pen = "M";
    const [first, end] = this.rows();
    for (let i = first; i < end; i++) {
      const v = this.at(i, j);
      if (!Number.isFinite(v)) { pen = "M"; continue; }
      path += `${pen}${this.x(this.time[i]).toFixed(1)} ${this.y(v).toFixed(1)}`;
      pen = "L";
    }
    const node = make("path", { class: "curve" + (this.chosen !== null && this.chosen !== j ? " dim" : ""), d: path }, parent);
    node.style.stroke = `var(--s${j % 8})`;
    if (j >= 8) node.style.strokeDasharray = "7 3";
  }
  limitLines(width) {
    if (!this.plot.limits || (this.chosen === null && !this.share)) return;
    const lines = this.share ? [-100, 100] : this.plot.limits[this.chosen].filter(v => v !== null).map(v => v * this.factors[this.chosen]);
    for (const v of lines) {
      const node = make("line", { class: "limit", x1: PAD.left, x2: width - PAD.right, y1: this.y(v), y2: this.y(v) }, this.svg);
      node.style.stroke = this.share ? "var(--bad)" : `var(--s${this.chosen % 8})`;
    }
  }
  timeAt(e) {
    const box = this.svg.getBoundingClientRect();
    return Math.max(
      this.from,
      Math.min(this.to, this.from + (e.clientX - box.left - this.x(this.from)) / (this.x(this.to) - this.x(this.from)) * (this.to - this.from))
    );
  }
  // The row that is nearest to a moment.
  rowAt(t) {
    let low = 0, high = this.time.length - 1;
    while (high - low > 1) { const m = (low + high) >> 1; if (this.time[m] <= t) low = m; else high = m; }
    return t - this.time[low] < this.time[high] - t ? low : high;
  }
  probe(e) {
    const i = this.rowAt(this.timeAt(e)), box = this.card.getBoundingClientRect();
    this.axis.point(this.time[i]);
    this.tip.replaceChildren(element("div", { class: "soft" }, `${this.time[i].toFixed(3)} s`));
    this.joints.forEach((name, j) => {
      if (this.hidden.has(j) || (this.chosen !== null && this.chosen !== j) || !Number.isFinite(this.at(i, j))) return;
      this.tip.append(element("div", {}, swatch(j), element("span", {}, name), element("b", {}, brief(this.at(i, j)) + (this.share ? " %" : ""))));
    });
    this.tip.hidden = false;
    const x = e.clientX - box.left, right = x > box.width / 2;
    this.tip.style.left = right ? "" : `${x + 16}px`;
    this.tip.style.right = right ? `${box.width - x + 16}px` : "";
    this.tip.style.top = `${Math.max(4, Math.min(e.clientY - box.top - 20, box.height - this.tip.offsetHeight - 4))}px`;
  }
  // A line at a moment, which any of the plots points at.
  point(t) {
    if (this.probeLine) this.place(this.probeLine, t);
  }
  place(line, t) {
    const seen = t !== null && t >= this.from && t <= this.to;
    line.setAttribute("visibility", seen ? "visible" : "hidden");
    if (!seen) return;
    line.setAttribute("x1", this.x(t));
    line.setAttribute("x2", this.x(t));
  }
  // What of the time is chosen by the pointer.
  brush(from, to) {
    this.range.setAttribute("visibility", "visible");
    this.range.setAttribute("x", this.x(from));
    this.range.setAttribute("width", this.x(to) - this.x(from));
  }
  mark(t) {
    this.now = t;
    if (this.cursor) this.place(this.cursor, t);
  }
  /** The drawing as a file that needs no style. */
  picture() {
    const copy = this.svg.cloneNode(true), inks = [...this.svg.querySelectorAll("*")];
    [...copy.querySelectorAll("*")].forEach((node, k) => {
      const style = getComputedStyle(inks[k]);
      node.removeAttribute("style");
      if (node.matches("path, line, rect, text")) for (const ink of INKS) node.setAttribute(ink, style.getPropertyValue(ink));
      if (node.matches(".probe, .range, .cursor")) node.remove();
    });
    copy.setAttribute("xmlns", "http://www.w3.org/2000/svg");
    const place = make("text", { x: PAD.left, y: PAD.top, "font-size": 12, "font-weight": 600, "font-family": "sans-serif" }, copy, this.title.textContent);
    copy.prepend(place);
    return copy.outerHTML;
  }
  /** What is seen, as a table in the units that are chosen. */
  table() {
    const head = ["t [s]", ...this.joints.map(name => `${name} [${this.share ? "%" : this.unit}]`)], lines = [];
    for (let i = 0; i < this.time.length; i++) if (this.time[i] >= this.from && this.time[i] <= this.to) lines.push([
      this.time[i], ...this.joints.map((_, j) => this.at(i, j))
    ].map(figure));
    return [head.map(cell), ...lines].map(line => line.join(",")).join("\n") + "\n";
  }
}
