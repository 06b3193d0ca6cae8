// The page of a section: its figures are drawn here, and drawn again as their sliders move.

const page = JSON.parse(document.getElementById("data").textContent);
const root = document.documentElement, SVG = "http://www.w3.org/2000/svg";

function tag(name, attributes, parent) {
  const one = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) one.setAttribute(key, value);
  parent?.append(one);
  return one;
}

const path = (flat, closed) => flat.reduce((d, x, k) => d + (k % 2 ? " " : k ? "L" : "M") + x / 10, "") + (closed ? "Z" : "");

/** A word with its indices, `S_1` or `S_{12}`, below the line. */
function word(text, place, shape, parent) {
  const [x, y] = place.map((value, k) => value / 10 + (k ? -1.3 : 1.3) * (shape.o?.[k] ?? 0));
  const look = { fill: shape.c, "font-size": 1.4 * shape.w, "text-anchor": shape.f ? "start" : "middle", class: shape.f ? "code" : "" };
  const one = tag("text", { x, y, "dominant-baseline": "middle", ...look }, parent);
  text.split("\n").forEach((line, row) => {
    const begin = tag("tspan", { x: one.getAttribute("x"), dy: row ? "1.25em" : 0 }, one);
    for (const [k, piece] of (shape.f ? [line] : line.split(/_(\{[^}]*\}|\w)/)).entries()) {
      const part = k % 2 ? tag("tspan", { "font-size": "75%", "baseline-shift": "sub" }, begin) : begin;
      part.append(k % 2 ? piece.replace(/[{}]/g, "") : piece);
    }
  });
}

function drawShape(shape, parent) {
  const { k, c, w, p } = shape;
  const stroke = { stroke: c, fill: "none", "stroke-width": 1.2 * w, "stroke-linejoin": "round", "stroke-linecap": "round" };
  if (k === "line") tag("path", { d: path(p), ...stroke, "stroke-dasharray": shape.d ?? "none" }, parent);
  if (k === "fill") tag("path", { d: path(p, true), fill: c, "fill-opacity": shape.a ?? 1 }, parent);
  if (k === "surface") {
    const thin = { ...stroke, "stroke-width": 0.7, "stroke-opacity": Math.min(1, 0.4 + shape.a) };
    for (const line of p) tag("path", { d: path(line), ...thin }, parent);
  }
  if (k === "dots") for (let i = 0; i < p.length; i += 2) tag("circle", { cx: p[i] / 10, cy: p[i + 1] / 10, r: 0.62 * w, fill: c }, parent);
  if (k === "label") word(shape.t, p, shape, parent);
  if (k === "arrow") {
    const [x, y, u, v] = p, length = Math.hypot(u - x, v - y) || 1, head = Math.min(95, 0.4 * length);
    const e = [(u - x) / length, (v - y) / length];
    const corner = (side) => [u - head * (e[0] - side * e[1]), v - head * (e[1] + side * e[0])];
    tag("path", { d: path(p), ...stroke }, parent);
    tag("path", { d: path([u, v, ...corner(0.4), ...corner(-0.4)], true), fill: c }, parent);
  }
}

function drawPanel(svg, panel, shapes) {
  svg.replaceChildren();
  if (panel.box) {
    const [x, y, u, v] = panel.box.map((t) => t / 10), grey = { c: "var(--soft)", w: 8 }, short = (value) => String(Number(value.toPrecision(3)));
    tag("rect", { x, y: v, width: u - x, height: y - v, fill: "none", stroke: "var(--line)" }, svg);
    word(short(panel.ends[0]), [10 * x, 10 * y + 110], grey, svg); word(short(panel.ends[2]), [10 * u, 10 * y + 110], grey, svg);
    word(short(panel.ends[1]), [10 * x - 160, 10 * y], grey, svg); word(short(panel.ends[3]), [10 * x - 160, 10 * v], grey, svg);
    word(panel.labels[0], [5 * (x + u), 10 * y + 240], grey, svg); word(panel.labels[1], [10 * x, 10 * v - 150], grey, svg);
  }
  const order = { surface: 0, fill: 1, line: 2, arrow: 3, dots: 4, label: 5 };
  for (const shape of [...shapes].sort((a, b) => order[a.k] - order[b.k])) drawShape(shape, svg);
}

const altered = (shape, change) => (!change ? shape : Array.isArray(change) ? { ...shape, p: change } : change);
const whole = (first, change) => (change.length === first.length ? first.map((shape, k) => altered(shape, change[k])) : change);
const mix = (a, b, t) => a.map((x, k) => (Array.isArray(x) ? mix(x, b[k], t) : x + t * (b[k] - x)));
const fits = (p, q) => p.length === q.length && p.every((x, k) => !Array.isArray(x) || x.length === q[k].length);
const between = (a, b, t) => (a.k === b.k && a.t === b.t && fits(a.p, b.p) ? { ...a, p: mix(a.p, b.p, t) } : t < 0.5 ? a : b);

function live(block, figure) {
  const pictures = figure.panels.map((_, k) => {
    const heading = Object.entries(figure.headings[k]).filter(([, text]) => text);
    const box = document.createElement("figure");
    for (const [code, text] of heading) {
      const line = Object.assign(document.createElement("figcaption"), { lang: code, textContent: text });
      line.dataset.lang = code;
      box.append(line);
    }
    block.querySelector(".pictures").append(box);
    return tag("svg", { viewBox: "-280 -220 560 440", role: "img", "aria-labelledby": block.getAttribute("aria-labelledby") }, box);
  });
  const draw = (parts) => figure.panels.forEach((panel, k) => drawPanel(pictures[k], panel, parts[k] ?? []));
  const item = (text) => Object.assign(document.createElement("li"), { textContent: text });
  const tell = (facts) => {
    for (const list of block.querySelectorAll(".facts")) list.replaceChildren(...facts[list.dataset.lang].map(item));
  };
  const rest = (moving) => {
    for (const other of block.querySelectorAll("input")) {
      if (other === moving) continue;
      other.value = figure.sliders[Number(other.dataset.k)].value;
      other.nextElementSibling.textContent = Number(other.value).toFixed(2);
    }
  };
  draw(figure.panels.map((panel) => panel.shapes)); tell(figure.facts);
  for (const slider of block.querySelectorAll("input")) {
    const along = figure.sliders[Number(slider.dataset.k)], shown = slider.nextElementSibling;
    const drawing = (parts) => parts.map((change, k) => change && whole(figure.panels[k].shapes, change));
    const frames = along.frames.map(([parts, facts]) => [drawing(parts), facts]);
    slider.addEventListener("input", () => {
      rest(slider);
      const at = ((Number(slider.value) - along.least) / (along.greatest - along.least)) * (frames.length - 1);
      const k = Math.min(Math.floor(at), frames.length - 2), t = at - k;
      shown.textContent = Number(slider.value).toFixed(2);
      draw(frames[k][0].map((shapes, n) => {
        const next = frames[k + 1][0][n];
        return shapes && next && shapes.length === next.length ? shapes.map((shape, i) => between(shape, next[i], t)) : t < 0.5 ? shapes : next;
      }));
      tell(frames[Math.round(at)][1]);
    });
  }
}

page.figures.forEach((figure, k) => live(document.getElementById(`figure-${k}`), figure));
document.addEventListener("click", ({ target }) => {
  if (!target.closest("[data-say=other_language]")) return;
  root.lang = root.lang === "ar" ? "en" : "ar";
  root.dir = root.lang === "ar" ? "rtl" : "ltr";
  document.title = page.titles[root.lang];
  target.textContent = page.other[root.lang];
});
