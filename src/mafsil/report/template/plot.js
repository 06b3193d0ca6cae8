// Line plots as SVG: shared time axis, hover values, limits of the chosen joint, curves as share of their limit.

import { drawn, element } from "../../page/views/elements.js";
import { floats } from "../../page/stage/scenery.js";

const PAD = { left: 52, right: 10, top: 10, bottom: 26 };

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

export class Plot {
  /**
   * @param {HTMLElement} parent
   * @param {object} plot  values, limits, unit, bands in time
   * @param {Float32Array} time  [s]
   * @param {string[]} joints  names of the curves
   * @param {(time: number) => void} seek  called where the plot is clicked
   */
  constructor(parent, plot, time, joints, seek) {
    Object.assign(this, { plot, time, joints, seek, share: false, chosen: null, hidden: new Set() });
    this.values = floats(plot.values);
    this.title = element("h3", {});
    this.button = plot.limits ? element("button", { type: "button", class: "quiet share", onclick: () => { this.share = !this.share; this.draw(); } }) : null;
    this.svg = make("svg", { role: "img", direction: "ltr" });
    this.tip = element("div", { class: "tip", dir: "ltr", hidden: true });
    this.key = element("div", { class: "key" });
    this.card = element("figure", { class: "plot" }, element("div", { class: "head" }, this.title, ...(this.button ? [this.button] : [])), this.svg, this.tip, this.key);
    parent.append(this.card);
    this.svg.addEventListener("pointermove", e => this.probe(e));
    this.svg.addEventListener("pointerleave", () => { this.tip.hidden = true; this.probeLine.setAttribute("visibility", "hidden"); });
    this.svg.addEventListener("click", e => this.seek(this.timeAt(e)));
    new ResizeObserver(() => this.draw()).observe(this.svg);
  }
  // Several curves that are no joints are named below them.
  nameCurves() {
    this.key.replaceChildren();
    if (this.plot.names.length < 2) return;
    this.joints.forEach((name, j) => {
      this.key.append(element("span", {}, swatch(j), element("bdi", {}, name)));
    });
  }
  // Say it in a language: its title, the names of its curves, what the button does.
  rename({ title, names }, share) {
    this.plot.title = title;
    this.svg.setAttribute("aria-label", title);
    if (names.length) this.joints = names;
    this.nameCurves();
    if (this.button) this.button.textContent = share;
    this.draw();
  }
  // Value of joint j at row i, as drawn: in its unit, or in percent of the bound it moves towards.
  at(i, j) {
    const v = this.values[i * this.joints.length + j];
    if (!this.share) return v;
    const [low, high] = this.plot.limits[j];
    if (low === null || high === null) return NaN;
    const middle = (low + high) / 2, half = (high - low) / 2;
    return 100 * (v - middle) / half;
  }
  extent() {
    let low = Infinity, high = -Infinity;
    const take = v => { if (Number.isFinite(v)) { low = Math.min(low, v); high = Math.max(high, v); } };
    for (let j = 0; j < this.joints.length; j++) if (!this.hidden.has(j)) for (let i = 0; i < this.time.length; i++) take(this.at(i, j));
    if (this.share) { take(-100); take(100); }
    else if (this.chosen !== null && this.plot.limits) this.plot.limits[this.chosen].forEach(v => { if (v !== null) take(v); });
    if (low > high) { low = -1; high = 1; }
    if (high - low < 1e-12) { const d = Math.max(Math.abs(high) * 0.1, 1e-9); low -= d; high += d; }
    const margin = (high - low) * 0.06;
    return [low - margin, high + margin];
  }
  draw() {
    const width = this.svg.clientWidth || 480, height = this.svg.clientHeight || 250;
    this.svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    this.svg.replaceChildren();
    const [low, high] = this.extent(), last = this.time[this.time.length - 1] || 1;
    this.x = t => PAD.left + (width - PAD.left - PAD.right) * t / last;
    this.y = v => height - PAD.bottom - (height - PAD.top - PAD.bottom) * (v - low) / (high - low);
    this.last = last;
    this.title.replaceChildren(`${this.plot.title ?? ""} `, element("bdi", { class: "soft", dir: "ltr" }, this.share ? "[%]" : `[${this.plot.unit}]`));
    if (this.button) this.button.setAttribute("aria-pressed", this.share);
    this.grid(low, high, width, height);
    this.joints.forEach((_, j) => { if (!this.hidden.has(j)) this.curve(j); });
    this.limitLines(width);
    this.probeLine = make("line", { class: "probe", y1: PAD.top, y2: height - PAD.bottom, visibility: "hidden" }, this.svg);
    this.cursor = make("line", { class: "cursor", y1: PAD.top, y2: height - PAD.bottom }, this.svg);
    this.mark(this.now || 0);
  }
  grid(low, high, width, height) {
    const rows = ticks(low, high, 7), columns = ticks(0, this.last, Math.max(3, Math.floor(width / 85)));
    this.plot.bands.forEach(([from, to], k) => { if (k % 2) make("rect", { class: "band", x: this.x(from), width: Math.max(0, this.x(to) - this.x(from)), y: PAD.top, height: height - PAD.top - PAD.bottom }, this.svg); });
    for (const v of rows.list) {
      make("line", { class: v === 0 ? "zero" : "grid", x1: PAD.left, x2: width - PAD.right, y1: this.y(v), y2: this.y(v) }, this.svg);
      make("text", { x: PAD.left - 7, y: this.y(v) + 4, "text-anchor": "end" }, this.svg, v === 0 ? "0" : (Math.abs(high - low) < 0.004 || Math.abs(v) >= 1e5) ? v.toExponential(1) : v.toFixed(rows.digits));
    }
    for (const t of columns.list) make("text", { x: this.x(t), y: height - 8, "text-anchor": t > this.last * 0.97 ? "end" : "middle" }, this.svg, t.toFixed(columns.digits) + (t === columns.list[columns.list.length - 1] ? " s" : ""));
  }
  curve(j) {
    let path = "", pen = "M";
    for (let i = 0; i < this.time.length; i++) {
      const v = this.at(i, j);
      if (!Number.isFinite(v)) { pen = "M"; continue; }
      path += `${pen}${this.x(this.time[i]).toFixed(1)} ${this.y(v).toFixed(1)}`;
      pen = "L";
    }
    const node = make("path", { class: "curve" + (this.chosen !== null && this.chosen !== j ? " dim" : ""), d: path }, this.svg);
    node.style.stroke = `var(--s${j % 8})`;
    if (j >= 8) node.style.strokeDasharray = "7 3";
  }
  limitLines(width) {
    if (!this.plot.limits || (this.chosen === null && !this.share)) return;
    const lines = this.share ? [-100, 100] : this.plot.limits[this.chosen].filter(v => v !== null);
    for (const v of lines) {
      const node = make("line", { class: "limit", x1: PAD.left, x2: width - PAD.right, y1: this.y(v), y2: this.y(v) }, this.svg);
      node.style.stroke = this.share ? "var(--bad)" : `var(--s${this.chosen % 8})`;
    }
  }
  timeAt(e) {
    const box = this.svg.getBoundingClientRect();
    return Math.max(0, Math.min(this.last, (e.clientX - box.left - this.x(0)) / (this.x(this.last) - this.x(0)) * this.last));
  }
  probe(e) {
    const t = this.timeAt(e), box = this.card.getBoundingClientRect();
    let low = 0, high = this.time.length - 1;
    while (high - low > 1) { const m = (low + high) >> 1; if (this.time[m] <= t) low = m; else high = m; }
    const i = t - this.time[low] < this.time[high] - t ? low : high;
    this.probeLine.setAttribute("x1", this.x(this.time[i]));
    this.probeLine.setAttribute("x2", this.x(this.time[i]));
    this.probeLine.setAttribute("visibility", "visible");
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
  mark(t) {
    this.now = t;
    if (!this.cursor) return;
    this.cursor.setAttribute("x1", this.x(t));
    this.cursor.setAttribute("x2", this.x(t));
  }
}
