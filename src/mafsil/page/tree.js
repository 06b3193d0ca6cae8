// The scene as a tree: every body, frame and thing around with an eye, its colour and a value; what is pointed at is lit.

import { drawn, element, isolated, number, sentence, written } from "./views/elements.js";

const EYE = "M2 12s3.6-6.5 10-6.5S22 12 22 12s-3.6 6.5-10 6.5S2 12 2 12zM12 9a3 3 0 1 0 0 6 3 3 0 0 0 0-6z";
const css = ([r, g, b]) => `rgb(${[r, g, b].map((part) => Math.round(255 * part)).join(" ")})`;

export class Tree {
  /** @param {HTMLElement} place @param {object} app */
  constructor(place, app) {
    Object.assign(this, { place, app, rows: [] });
  }

  /** What there is, in groups: the key of each, its name, colour, and the value that stands beside it. */
  groups() {
    const { data, store } = this.app, around = this.app.player.scenery?.tape, { link_poses, forward_kinematics } = store.arm.kernels;
    const place = (at) => () => `(${at().map((x) => number(x * this.app.unit(true).factor, this.app.unit(true).digits)).join(", ")})`;
    const colour = ({ shapes }) => (shapes[0] ? css(shapes[0].colour) : "transparent");
    const links = data.scene.bodies.map((body, k) => ({
      key: `link ${k}`, name: body.name, colour: colour(body),
      value: () => (data.robot.masses[k] ? `${number(data.robot.masses[k], 2)} kg` : "")
    }));
    const tip = () => Array.from(forward_kinematics(store.state.q)[0]);
    const frames = [
      { key: "base", name: "{s}", value: place(() => [0, 0, 0]) },
      { key: "tip", name: data.robot.tip, value: place(() => [3, 7, 11].map((k) => tip()[k])) }
    ];
    const things = (around?.scenery.bodies ?? []).map((body, k) => ({
      key: `thing ${k}`, name: body.name, colour: colour(body), value: place(() => this.app.player.scenery.placeOf(k))
    }));
    const targets = (around?.targets ?? []).map(({ name, pose }, k) => ({ key: `target ${k}`, name, value: place(() => pose.slice(0, 3)) }));
    const loops = (data.robot.loops ?? []).map((name) => ({ key: null, name, value: () => "" }));
    return [
      ["tree_robot", links], ["tree_frames", frames], ["tree_targets", targets], ["tree_around", things], ["tree_loops", loops]
    ].filter(([, list]) => list.length);
  }

  /** All rows anew, in the language that is chosen. */
  speak() {
    this.rows = [];
    this.place.replaceChildren(...this.groups().flatMap(([title, list]) => [
      element("h2", {}, sentence(this.app.words, title)), element("ul", {}, ...list.map((one) => this.row(one)))
    ]));
  }

  row({ key, name, colour, value }) {
    const { store, words } = this.app, { hidden } = store.shown, light = (lit) => () => store.show({ lit });
    const icon = drawn("svg", { viewBox: "0 0 24 24", "aria-hidden": "true" }), patch = element("i", {}), shown = isolated(
      "", { class: key?.startsWith("link") ? "soft" : "soft below" }
    );
    icon.append(drawn("path", { d: EYE }));
    const turn = () => {
      if (!hidden.delete(key)) hidden.add(key);
      store.show({});
    };
    const eye = key === null ? element("span", {}) : element(
      "button", { type: "button", "aria-label": words.text("show_thing", { name }), onclick: turn }, icon
    );
    if (colour) patch.style.background = colour;
    const row = element(
      "li", { onpointerenter: light(key), onpointerleave: light(null) }, eye, patch, element("bdi", { class: "name", title: name }, name),
      shown
    );
    this.rows.push({ key, row, eye, shown, value });
    return row;
  }

  update() {
    const { hidden, lit } = this.app.store.shown;
    for (const { key, row, eye, shown, value } of this.rows) {
      written(shown, value());
      row.classList.toggle("lit", key !== null && lit === key);
      if (key !== null) eye.setAttribute("aria-pressed", String(!hidden.has(key)));
    }
  }
}
