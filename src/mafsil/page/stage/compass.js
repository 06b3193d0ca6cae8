// The axes of the world in a corner of the picture, each a button that looks along it; gravity among them; the scale.

import { Vector } from "../../scene/matrix.js";
import { drawn, element, written } from "../views/elements.js";

const WIDE_COMPASS = 116, LONG_AXIS = 45; // pixels
const WAYS_OF_COMPASS = [["x", [1, 0, 0], 0, 0], ["y", [0, 1, 0], Math.PI / 2, 0], ["z", [0, 0, 1], -Math.PI / 2, 1.57],
  ["−x", [-1, 0, 0], Math.PI, 0], ["−y", [0, -1, 0], -Math.PI / 2, 0]];
const LONG_SCALE = 100; // pixels that the bar of the scale has at most

export class Compass {
  /**
   * @param {HTMLElement} place
   * @param {import("./viewport.js").Viewport} stage
   * @param {number[]} gravity  [m/s^2]
   */
  constructor(place, stage, gravity) {
    const lines = drawn("svg", { viewBox: `${-WIDE_COMPASS / 2} ${-WIDE_COMPASS / 2} ${WIDE_COMPASS} ${WIDE_COMPASS}`, "aria-hidden": "true" });
    this.stage = stage;
    this.ways = WAYS_OF_COMPASS.map(([name, way, azimuth, elevation]) => {
      const line = drawn("line", { x1: 0, y1: 0, class: `axis ${name}` });
      const button = element(
        "button",
        { type: "button", class: name.length > 1 ? "back" : name, onclick: () => { stage.camera.look(azimuth, elevation); stage.frame(); stage.changed(); } },
        name.length > 1 ? "" : name
      );
      if (name.length === 1) lines.append(line);
      return { name, way, line, button };
    });
    this.down = Vector.length(gravity) ? Vector.unit(gravity) : null;
    this.arrow = drawn("path", { class: "gravity" });
    this.letter = drawn("text", { class: "gravity" });
    this.letter.textContent = this.down ? "g" : "";
    lines.append(this.arrow, this.letter);
    this.bar = element("i", {});
    this.length = element("span", {});
    place.replaceChildren(lines, ...this.ways.map(({ button }) => button));
    place.after(element("div", { id: "scale", dir: "ltr" }, this.bar, this.length));
  }

  /** What the buttons are called. @param {(way: string) => string} named */
  speak(named) {
    for (const { name, button } of this.ways) {
      button.setAttribute("aria-label", named(name));
      button.title = named(name);
    }
  }

  paint() {
    const { camera, height } = this.stage, { right, up, away } = camera;
    const at = (way) => [LONG_AXIS * Vector.dot(way, right), -LONG_AXIS * Vector.dot(way, up)];
    for (const { way, line, button } of this.ways) {
      const [x, y] = at(way);
      line.setAttribute("x2", x);
      line.setAttribute("y2", y);
      Object.assign(button.style, { left: `${WIDE_COMPASS / 2 + x}px`, top: `${WIDE_COMPASS / 2 + y}px`, zIndex: Math.round(3 + 2 * Vector.dot(way, away)) });
    }
    if (this.down) this.paintGravity(...at(this.down));
    const most = LONG_SCALE * camera.reach(camera.distance, height), power = 10 ** Math.floor(Math.log10(most));
    const long = [5, 2, 1].map((k) => k * power).find((one) => one <= most);
    this.bar.style.inlineSize = `${(long / camera.reach(camera.distance, height)).toFixed(1)}px`;
    written(this.length, long < 1 ? `${Number((1000 * long).toPrecision(3))} mm` : `${long} m`);
  }

  paintGravity(x, y) {
    const long = Math.hypot(x, y), [u, v] = long ? [x / long, y / long] : [0, 0], tip = (s, side) => `${x + s * u - side * v} ${y + s * v + side * u}`;
    this.arrow.setAttribute(
      "d",
      long < 6 ? "M -3 0 A 3 3 0 1 0 3 0 A 3 3 0 1 0 -3 0" : `M 0 0 L ${tip(-6, 0)} M ${tip(-6, 3.5)} L ${tip(0, 0)} L ${tip(-6, -3.5)} Z`
    );
    this.letter.setAttribute("x", x + 8);
    this.letter.setAttribute("y", y + 4);
  }
}
