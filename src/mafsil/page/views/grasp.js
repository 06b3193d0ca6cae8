// A grasp in the plane to be drawn: fingers on a body, friction to slide, and the wrench that they cannot resist.

import { coneWrenches, fingerAt, graspPython, lengthNear, planarClosure } from "../core/planar_grasp.js";
import { view } from "../core/views.js";
import { drawn, element, isolated, number, sentence, symbol, written } from "./elements.js";

const BODIES = {
  rectangle: [[-1, -0.6], [1, -0.6], [1, 0.6], [-1, 0.6]],
  triangle: [[-1, -0.6], [1, -0.6], [0, 1]],
  corner: [[-0.9, -0.9], [0.9, -0.9], [0.9, -0.1], [-0.1, -0.1], [-0.1, 0.9], [-0.9, 0.9]],
};
const MOST_FINGERS = 8, CONE = 0.42, FORCE = 0.55, FAR = 1.3; // lengths in the picture [m]

view({
  name: "grasp",
  tab: "analyse",
  order: 75,
  mount(place, app) {
    const { words } = app, grasp = (app.grasp ??= { body: "rectangle", fingers: [1, 4.2], mu: 0.3 });
    const corners = () => BODIES[grasp.body], changed = () => app.draw();
    const picture = drawn("svg", { viewBox: "-1.6 -1.35 3.2 2.7", class: "grasp", role: "group", "aria-label": words.text("view_grasp") });
    const world = drawn("g", { transform: "scale(1 -1)" }), body = drawn("polygon", { class: "body" }), cones = drawn("g"),
      wrench = drawn("g", { class: "wrench" }), dots = drawn("g");
    world.append(body, cones, wrench, dots);
    picture.append(world);
    const where = (event) => { const { x, y } = new DOMPoint(event.clientX, event.clientY).matrixTransform(world.getScreenCTM().inverse()); return [x, y]; };
    const bodies = element(
      "select", { "aria-label": words.text("grasp_body"), onchange: () => { grasp.body = bodies.value; changed(); } },
      ...Object.keys(BODIES).map((name) => element("option", { value: name }, words.text(`body_${name}`)))
    );
    bodies.value = grasp.body;
    const mu = element(
      "input",
      {
        type: "range", id: "friction", min: 0, max: 1, step: 0.01, value: grasp.mu, dir: "ltr", "aria-label": words.text("friction"),
        oninput: () => { grasp.mu = Number(mu.value); changed(); }
      }
    );
    const button = (key, act) => element(
      "button", { type: "button", class: "quiet", "data-do": key, onclick: () => { act(); changed(); } }, sentence(words, key)
    );
    const more = button("finger_more", () => grasp.fingers.push(grasp.fingers.length * 0.9)), less = button("finger_less", () => grasp.fingers.pop());
    const shown = isolated(""), verdict = element("p", { class: "verdict" }), code = element(
      "pre", { dir: "ltr", tabindex: 0, role: "region", id: "grasp-code", "aria-label": words.text("view_grasp") }
    );
    place.append(
      element("p", { class: "soft" }, sentence(words, "grasp_about")), element("div", { class: "buttons" }, bodies, more, less),
      element(
        "label", { class: "friction" },
        element("span", {}, sentence(words, "friction"), " ", element("bdi", { dir: "ltr" }, symbol("μ", "", "="), " ", shown)), mu
      ),
      picture, verdict, code
    );
    let before = "";
    return () => {
      const now = JSON.stringify([grasp, words.chosen]);
      if (now === before) return;
      before = now;
      const fingers = grasp.fingers.map((length) => fingerAt(corners(), length)), found = planarClosure(coneWrenches(fingers, grasp.mu));
      written(shown, number(grasp.mu, 2));
      [more.disabled, less.disabled] = [fingers.length >= MOST_FINGERS, fingers.length <= 1];
      body.setAttribute("points", corners().map((corner) => corner.join()).join(" "));
      cones.replaceChildren(...fingers.map((finger) => coneOf(finger, grasp.mu)));
      while (dots.children.length > fingers.length) dots.lastChild.remove();
      while (dots.children.length < fingers.length) dots.append(dot(dots.children.length));
      fingers.forEach(({ point: [cx, cy] }, k) => settled(dots.children[k], { cx, cy }));
      wrench.replaceChildren(...(found.unresisted ? wrenchOf(found.unresisted) : []));
      const values = found.closed ? { margin: number(found.margin, 4) } : { wrench: `(${found.unresisted.map((x) => number(x, 3)).join(", ")})` };
      verdict.replaceChildren(sentence(words, found.closed ? "grasp_closed" : "grasp_open", values));
      verdict.classList.toggle("open", !found.closed);
      written(code, graspPython(fingers, grasp.mu));
    };

    /** A finger to be dragged along the boundary, or led by the arrows. */
    function dot(k) {
      const made = drawn("circle", { r: 0.075, tabindex: 0, role: "slider", "aria-label": words.text("finger", { finger: k + 1 }), "aria-valuenow": 0 });
      const moved = (length) => { grasp.fingers[k] = length; made.setAttribute("aria-valuenow", number(length, 2)); changed(); };
      made.addEventListener("pointerdown", (event) => { made.setPointerCapture(event.pointerId); event.preventDefault(); made.focus(); });
      made.addEventListener("pointermove", (event) => { if (made.hasPointerCapture(event.pointerId)) moved(lengthNear(corners(), where(event))); });
      made.addEventListener("keydown", (event) => {
        const step = { ArrowRight: 0.02, ArrowUp: 0.02, ArrowLeft: -0.02, ArrowDown: -0.02 }[event.key];
        if (!step) return;
        event.preventDefault();
        moved(grasp.fingers[k] + step);
      });
      return made;
    }
  },
});

/** The namespace of drawings, from the parser: the page holds no address. */
function settled(made, attributes) {
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
}

/** The forces that a finger can give; without friction one direction. */
function coneOf({ point: [x, y], normal: [a, b] }, mu) {
  const long = CONE / Math.hypot(1, mu), ends = [mu, -mu].map((t) => [x + long * (a - t * b), y + long * (b + t * a)].join());
  return drawn("polygon", { class: "cone", points: [[x, y].join(), ...ends].join(" ") });
}

/** A wrench as a force along its line, or as a turn where it is a moment or its line is far away. */
function wrenchOf([m, u, v]) {
  const f = Math.hypot(u, v), [x, y] = f > 1e-9 ? [(m * v) / (f * f), (-m * u) / (f * f)] : [FAR, FAR];
  if (Math.hypot(x, y) < FAR) {
    const [a, b] = [u / f, v / f], tip = [x + FORCE * a, y + FORCE * b];
    return [drawn("path", { d: `M${x - FORCE * a} ${y - FORCE * b}L${tip.join(" ")}` }), arrow(tip, [a, b])];
  }
  const sense = Math.sign(m) || 1, r = 0.4;
  return [drawn("path", { d: `M${r} 0A${r} ${r} 0 1 ${sense > 0 ? 1 : 0} 0 ${-sense * r}` }), arrow([0, -sense * r], [1, 0])];
}

const arrow = ([x, y], [a, b]) => drawn(
  "polygon",
  { points: [[x + 0.13 * a, y + 0.13 * b], [x - 0.06 * b, y + 0.06 * a], [x + 0.06 * b, y - 0.06 * a]].map((corner) => corner.join()).join(" ") }
);
