// The views of a page: each is one file that describes itself here.

/**
 * @typedef {{name: string, order: number, tab?: string, title?: Object<string, string>, open?: boolean, needs?: string[],
 *            actions?: Object<string, (state: object, given: any, arm: object) => [string, object][]>,
 *            wanted?: (arm: import("./state.js").Arm, data: object) => boolean,
 *            mount: (place: HTMLElement, app: object) => (() => void),
 *            tick?: (app: object, now: number) => boolean}} View
 *   name: also of its title, the sentence `view_<name>`; order: among the others; tab: of the inspector, "move" where
 *   it says none; title: by language, where there is no such sentence; open: unfolded at first; needs: quantities of
 *   the robot whose kernels it calls, which Python reads from the file: one line of names; actions: what it does
 *   besides, by name, each as a list of actions that are there; wanted: whether this arm has it; mount: fills the place
 *   and returns what brings it up to date, called for every picture while the view is open; tick: lets time pass,
 *   before every picture, and says whether there is more to come
 */

/** @type {View[]} */
export const VIEWS = [];

/** @param {View} described */
export function view(described) {
  VIEWS.push(described);
  VIEWS.sort((a, b) => a.order - b.order);
}
