// All configurations that reach the tip's pose, each with its name; or that there is only the numerical search.

import { view } from "../core/views.js";
import { hereOf, lifted } from "../core/state.js";
import { branchesAt, excessOf, nearestRow, swung, tipPose } from "../loops/reach.js";
import { element, isolated, number, sentence, written } from "./elements.js";

view({
  name: "branches",
  order: 30,
  wanted: ({ settings }) => !settings.driven,
  open: true,
  mount(place, app) {
    const { store, words, data } = app, { arm } = store, inUnits = (q) => q.map((value, k) => number(
      value * app.unit(data.robot.joints[arm.settings.places[k]].prismatic).factor, Math.max(1, app.unit(false).digits - 1)
    ));
    const inUnit = ({ excess, prismatic }) => { const { sign, factor, digits } = app.unit(prismatic); return `${number(excess * factor, digits)} ${sign}`; };
    if (!arm.kernels.branches) {
      place.append(element("p", {}, sentence(words, "no_closed_form")));
      return () => {};
    }
    const ghosts = element("input", { type: "checkbox", onchange: (event) => store.show({ ghosts: event.target.checked }) });
    ghosts.checked = store.shown.ghosts;
    const method = element("input", { type: "checkbox", onchange: (event) => store.show({ method: event.target.checked ? "search" : "exact" }) });
    method.checked = store.shown.method === "search";
    place.append(element(
      "div", { class: "buttons" }, element("label", { class: "choice" }, ghosts, sentence(words, "ghosts")),
      element("label", { class: "choice" }, method, sentence(words, "by_search"))
    ));
    if (arm.settings.locked.length) place.append(element(
      "p", { class: "soft" },
      sentence(words, "locked_about", { joint: arm.settings.locked.map((k) => data.robot.joints[k].name).join(", ") })
    ));
    const swings = arm.settings.locked.map((joint) => swing(place, joint, app));
    const list = element("div", { class: "branches" }), rows = [], hide = () => store.show({ peek: -1 });
    place.append(list);
    for (let row = 0; row < data.branches.rows; row++) {
      const name = element("span", {}), state = element("span", { class: "soft" });
      const mark = element("i"), button = element(
        "button",
        {
          type: "button", "data-branch": row, onclick: () => store.do("choose", { branch: row }),
          onpointerenter: () => store.show({ peek: row }), onfocus: () => store.show({ peek: row }), onpointerleave: hide, onblur: hide
        },
        mark, name, state
      );
      mark.style.background = `var(--s${row % 8})`;
      list.append(button);
      rows.push({ button, name, state });
    }
    return () => {
      for (const update of swings) update();
      const here = hereOf(store.state), found = branchesAt(store.state, tipPose(store.state, arm), arm);
      found.forEach((branch, row) => {
        const { button, name, state } = rows[row], q = lifted(arm.settings, here, branch.q);
        const same = branch.within && Math.hypot(...q.map((value, k) => value - here[k])) < 1e-6;
        button.disabled = !branch.within;
        button.setAttribute("aria-pressed", String(same));
        written(name, `${row} · ` + (branch.solves ? branchName(data.branches[words.chosen], branch) : words.text("no_solution")));
        const text = branch.within ? words.isolate(`(${inUnits(branch.q).join(", ")})`) : words.text(
          "beyond", { excess: inUnit(excessOf(branch, arm.settings)) }
        );
        written(state, branch.solves ? text : "");
      });
    };
  },
});

/** What a branch is called. @param {{sides: string[], roots: string[], joint: string}} names */
export const branchName = ({ sides, roots, joint }, { code, row }) => [sides[code], roots[row]].filter(Boolean).join(joint);

/** A slider that turns a free joint while the tool stays; where no configuration does, the arm stays, with the reason. */
function swing(place, joint, app) {
  const { store, words, data } = app;
  const { arm } = store, { lower, upper } = arm.settings, { name, prismatic } = data.robot.joints[joint];
  const range = element(
    "input",
    {
      type: "range", min: lower[joint] ?? -Math.PI, max: upper[joint] ?? Math.PI, step: "any", dir: "ltr", id: `swing-${joint}`,
      "aria-label": words.text("swing", { joint: name }), oninput: () => lead(Number(range.value)),
      onchange: () => { store.release(); store.show({ wish: null, refusal: null }); }
    }
  );
  const value = isolated("", { class: "soft" });
  place.append(element("label", { class: "swing" }, element("span", {}, sentence(words, "swing", { joint: name })), value, range));
  function lead(wanted) {
    const { base } = store, T = tipPose(base, arm), row = nearestRow(base, branchesAt(base, T, arm), arm.settings);
    if (row < 0) return;
    const given = { joint, value: wanted, branch: row }, { reason } = swung(base, given, arm);
    if (!reason) store.do("swing", given, { gesture: true });
    store.show({ wish: reason ? T : null, refusal: reason });
  }
  return () => {
    const here = hereOf(store.state)[joint];
    if (document.activeElement !== range || !store.shown.wish) range.value = here;
    const { sign, factor, digits } = app.unit(prismatic);
    written(value, `${number(here * factor, digits)} ${sign}`);
  };
}
