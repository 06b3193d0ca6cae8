// Robots with loops: the driven joints are moved, and the loops move the others.

import { placed } from "../core/state.js";

/** All joints with closed loops while the driven ones are somewhere; null where they do not close. */
function closedAt(guess, driven, { settings, kernels }) {
  if (!kernels.closed_following) throw new RangeError("the driven joints of this robot do not decide the others");
  const motion = [...driven, ...new Array(2 * driven.length).fill(0)];
  for (let k = 0, at = guess; k < settings.patience; k++) {
    const [q, , , doubt] = kernels.closed_following(at, motion);
    at = Array.from(q);
    if (!at.every(Number.isFinite)) return null;
    if (doubt[0] < 1) return at;
  }
  return null;
}

/**
 * The body Jacobian of the tip, 6 rows of n: of all joints, or with loops of the driven joints, which the others follow.
 *
 * @param {number[]} q
 * @param {import("../core/state.js").Arm} arm
 * @returns {{J: ArrayLike<number>, n: number, joints: number[]}}  joints: whose columns they are
 */
export function tipJacobian(q, { settings: { n, driven }, kernels }) {
  if (!driven) return { J: kernels.jacobian_body(q)[0], n, joints: q.map((_, k) => k) };
  const here = driven.map((k) => q[k]), rest = new Array(driven.length).fill(0), a = driven.length;
  const rates = driven.map((_, k) => Array.from(kernels.closed_following(q, [...here, ...rest.with(k, 1), ...rest])[1]));
  const tree = kernels.tree_jacobian(q)[0];
  const J = Float64Array.from({ length: 6 * a }, (_, at) => rates[at % a].reduce((sum, rate, j) => sum + tree[n * Math.floor(at / a) + j] * rate, 0));
  return { J, n: a, joints: driven };
}

/** Whether `tipJacobian` knows one. @param {import("../core/state.js").Arm} arm */
export const hasJacobian = ({ kernels }) => "jacobian_body" in kernels || "tree_jacobian" in kernels;

/**
 * The driven joints where they are wanted, at once or in strides; the arm where it was, with the reason, where the loops
 * do not close on the way. The same bits as `mafsil.page.Session`.
 *
 * @param {import("../core/state.js").State} state
 * @param {number[]} wanted  of which the driven joints count
 * @param {number[]} guess  where the others are looked for first
 * @param {import("../core/state.js").Arm} arm
 */
export function followed(state, wanted, guess, arm) {
  const { driven, stride } = arm.settings, goal = driven.map((k) => wanted[k]), begin = driven.map((k) => state.q[k]);
  let found = guess === state.q ? null : closedAt(guess, goal, arm);
  if (!found) {
    const way = Math.max(0, ...goal.map((value, k) => Math.abs(value - begin[k])));
    const count = Number.isFinite(way) ? Math.max(1, Math.ceil(way / stride)) : 0;
    found = count ? state.q : null;
    for (let k = 1; k <= count && found; k++) found = closedAt(found, goal.map((value, i) => begin[i] + (value - begin[i]) * (k / count)), arm);
  }
  return found ? placed(state, found) : { ...state, status: "loops_open", reason: { key: "why_loops", values: {} } };
}
