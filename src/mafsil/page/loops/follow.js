// Robots with loops: the driven joints are moved, and the loops move the others.

import { symmetricEigen } from "../core/linear.js";
import { product, quaternionOf } from "../core/rotations.js";
import { placed } from "../core/state.js";

const TRIES = 6, FARTHEST = 0.15; // steps towards a pose; rad | m that a driven joint goes with one of them
const SOFT = 1e-4; // damping of a step, as share of the largest square of a singular value
const THERE = 1e-6; // m | rad

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

/** Whether the tool of this arm can be led: without loops always, else where driven joints move it. @param {import("../core/state.js").Arm} arm */
export const isLed = ({ settings: { driven }, kernels }) => !driven || (driven.length > 0 && "tree_jacobian" in kernels);

/** Turn and shift in the tip's frame that are left to a pose; of the shift alone where too few joints are driven. */
function leftTo(T, now, turns) {
  const [w, x, y, z] = product(quaternionOf(now).map((part, k) => (k ? -part : part)), quaternionOf(T)), away = [3, 7, 11].map((k) => T[k] - now[k]);
  const shift = [0, 1, 2].map((c) => now[c] * away[0] + now[4 + c] * away[1] + now[8 + c] * away[2]);
  return [...(turns ? [x, y, z].map((part) => 2 * Math.sign(w || 1) * part) : [0, 0, 0]), ...shift];
}

/**
 * The driven joints led so that the tip comes as near to a pose as damped steps find, within the limits and with closed
 * loops; fewer than six lead its place alone.
 *
 * @param {import("../core/state.js").State} state @param {number[]} T
 * @param {import("../core/state.js").Arm} arm
 * @returns {{q: number[], miss: number}}  miss: what is left [m | rad]
 */
export function ledTo(state, T, arm) {
  const { driven, lower, upper } = arm.settings, turns = driven.length >= 6, rows = turns ? [0, 1, 2, 3, 4, 5] : [3, 4, 5];
  const left = (q) => leftTo(T, arm.kernels.forward_kinematics(q)[0], turns);
  let { q } = state, miss = Math.hypot(...left(q));
  for (let k = 0, trust = 1; k < TRIES && miss > THERE; k++) {
    const { J, n } = tipJacobian(q, arm), error = left(q), columns = driven.map((_, j) => rows.map((i) => J[n * i + j]));
    const { values, vectors } = symmetricEigen(columns.map((a) => columns.map((b) => a.reduce((sum, x, i) => sum + x * b[i], 0))));
    const slope = columns.map((a) => a.reduce((sum, x, i) => sum + x * error[rows[i]], 0));
    const step = slope.map(() => 0);
    vectors.forEach((v, at) => v.forEach((x, j) => { step[j] += x * v.reduce((sum, y, i) => sum + y * slope[i], 0) / (values[at] + SOFT * values[0]); }));
    const share = trust * Math.min(1, FARTHEST / Math.max(1e-12, ...step.map(Math.abs))), wanted = q.slice();
    driven.forEach((joint, j) => { wanted[joint] = Math.min(upper[joint] ?? Infinity, Math.max(lower[joint] ?? -Infinity, q[joint] + share * step[j])); });
    const next = followed({ ...state, q }, wanted, q, arm), nearer = next.reason ? Infinity : Math.hypot(...left(next.q));
    if (nearer < miss) [q, miss, trust] = [next.q, nearer, 1];
    else trust /= 4;
  }
  return { q, miss };
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
