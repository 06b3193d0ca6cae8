// Joints over time while the loop is closed: their distance from the goal, or their values with the goal dashed.

import { History } from "../core/history.js";
import { view } from "../core/views.js";
import { element, isolated, number, sentence } from "./elements.js";

const SAMPLES = 600; // samples: ten seconds at 60 pictures a second
const TALL = 170, LEFT = 58, LOW = 20, HIGH = 8; // pixels

view({
  name: "plot",
  order: 65,
  wanted: ({ kernels }) => "closed_loop" in kernels,
  mount(place, app) {
    const { store, words, data } = app, { n, step } = store.arm.settings;
    const history = (app.history ??= new History(1 + 2 * n, SAMPLES)), picture = element(
      "canvas", { class: "curves", dir: "ltr", role: "img", "aria-label": words.text("view_plot") }
    );
    const values = element("input", { type: "checkbox", id: "plot-values", onchange: () => app.draw() });
    const names = element("div", { class: "legend" });
    data.robot.joints.forEach((joint, k) => {
      const mark = element("i", {});
      mark.style.background = `var(--s${k % 8})`;
      names.append(element("span", {}, mark, isolated(joint.name)));
    });
    let painted = "";
    place.append(
      element("p", { class: "soft" }, sentence(words, "plot_about")),
      element("label", { class: "choice" }, values, sentence(words, "plot_values")), picture, names
    );
    return () => {
      const { state } = store, time = state.ticks * step, last = history.length ? history.at(history.length - 1, 0) : -1;
      if (time < last || (!state.loop && history.length)) history.clear();
      if (state.loop && time !== last) history.push([time, ...state.q, ...state.goal]);
      const shown = [history.count, values.checked, picture.clientWidth, app.stage.colours.s0].join();
      if (shown === painted) return;
      painted = shown;
      paintPlot(picture, history, n, values.checked, app.stage.colours);
    };
  },
});

/** Lines of all joints, with the ends of both axes written at them. */
function paintPlot(picture, history, n, values, colours) {
  const ratio = Math.min(window.devicePixelRatio || 1, 2), width = picture.clientWidth, context = picture.getContext("2d");
  if (picture.width !== Math.round(width * ratio)) [picture.width, picture.height] = [Math.round(width * ratio), TALL * ratio];
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, TALL);
  const value = (k, joint) => history.at(k, 1 + joint) - (values ? 0 : history.at(k, 1 + n + joint));
  let low = Infinity, high = -Infinity;
  for (let k = 0; k < history.length; k++) for (let joint = 0; joint < n; joint++) {
    low = Math.min(low, value(k, joint));
    high = Math.max(high, value(k, joint));
  }
  if (!(low < high)) [low, high] = [Math.min(low, 0) - 1, Math.max(high, 0) + 1].map((x, k) => (Number.isFinite(x) ? x : 2 * k - 1));
  const begin = history.length ? history.at(0, 0) : 0, end = Math.max(history.length ? history.at(history.length - 1, 0) : 0, begin + 1);
  const x = (time) => LEFT + (width - LEFT - 8) * (time - begin) / (end - begin), y = (v) => TALL - LOW - (TALL - LOW - HIGH) * (v - low) / (high - low);
  plotAxes(context, { x, y, low, high, begin, end });
  for (let joint = 0; joint < n; joint++) {
    const [r, g, b] = colours[`s${joint % 8}`].map((part) => Math.round(255 * part));
    context.strokeStyle = `rgb(${r} ${g} ${b})`;
    curve(context, history, (k) => [x(history.at(k, 0)), y(value(k, joint))], []);
    if (values) curve(context, history, (k) => [x(history.at(k, 0)), y(history.at(k, 1 + n + joint))], [3, 4]);
  }
}

function plotAxes(context, { x, y, low, high, begin, end }) {
  const ink = getComputedStyle(context.canvas).color;
  context.font = "11px system-ui, sans-serif";
  context.fillStyle = ink;
  context.strokeStyle = ink;
  context.lineWidth = 0.5;
  context.strokeRect(x(begin), y(high), x(end) - x(begin), y(low) - y(high));
  context.textAlign = "right";
  context.fillText(number(high, 3), LEFT - 4, y(high) + 8);
  context.fillText(number(low, 3), LEFT - 4, y(low));
  context.fillText(`${number(end, 1)} s`, x(end), TALL - 5);
  context.textAlign = "left";
  context.fillText(`${number(begin, 1)} s`, x(begin), TALL - 5);
  context.lineWidth = 1.5;
}

function curve(context, history, place, dashes) {
  context.setLineDash(dashes);
  context.beginPath();
  for (let k = 0; k < history.length; k++) context.lineTo(...place(k));
  context.stroke();
  context.setLineDash([]);
}
