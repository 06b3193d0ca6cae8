// Where the arm is and what it is doing. A state is never changed; every action makes a new one.

/**
 * @typedef {{q: number[], qd: number[], goal: number[], loop: boolean, push: number[], ticks: number,
 *            status: string, reason: Reason | null}} State
 *   q, qd: coordinates and rates; goal: where the controller leads; loop: whether it moves the arm, or the actions do;
 *   push: wrench on the tip in its frame; ticks of the loop since it was closed; status: how the last action ended;
 *   reason: why it was refused
 * @typedef {{key: string, values: Object<string, string | number>}} Reason  a sentence of the words and what it names
 * @typedef {{n: number, places: number[], start: number[], lower: (number | null)[], upper: (number | null)[],
 *            task: (number | null)[], starts: number[][], ratios: number[], rotates: boolean, tolerance: number, attempts: number,
 *            steps: number, centre: number[], radius: number | null, locked: number[], step: number, gains: number[],
 *            effort: (number | null)[], driven: number[] | null, motors: number[] | null, stride: number,
 *            patience: number}} Settings
 *   driven, motors, stride, patience: with loops the joints that may be moved, those with efforts, the most that they move at
 *   once, and how often it is tried to close the loops then
 * @typedef {{settings: Settings, kernels: Object<string, import("./kernels.js").Kernel>}} Arm
 */

const zeros = (n) => new Array(n).fill(0);

/** @param {Settings} settings @returns {State} */
export function firstState({ start, n }) {
  return { q: start, qd: zeros(n), goal: start, loop: false, push: zeros(6), ticks: 0, status: "ready", reason: null };
}

/** What actions change: the goal in the loop, else the coordinates. @param {State} state */
export const hereOf = (state) => (state.loop ? state.goal : state.q);

/** The arm, or the goal of its controller, at other coordinates. @returns {State} */
export function placed(state, q, status = "ready") {
  const done = { ...state, status, reason: null };
  return state.loop ? { ...done, goal: q } : { ...done, q, goal: q, qd: zeros(q.length) };
}

/** The loop closed or opened, at rest. @returns {State} */
export function looped(state, closed) {
  const rest = { goal: state.q, qd: zeros(state.q.length), push: zeros(6), ticks: 0, status: "ready", reason: null };
  return { ...state, ...rest, loop: closed };
}

/** The coordinates that move the tip. @param {Settings} settings @param {number[]} q */
export const partOf = (settings, q) => settings.places.map((place) => q[place]);

/** All coordinates, those that move the tip replaced. */
export function lifted(settings, q, part) {
  const all = q.slice();
  settings.places.forEach((place, k) => { all[place] = part[k]; });
  return all;
}

/** Bounds of the coordinates that move the tip, infinite where there is none. */
export function boundsOf({ places, lower, upper }) {
  return [places.map((place) => lower[place] ?? -Infinity), places.map((place) => upper[place] ?? Infinity)];
}
