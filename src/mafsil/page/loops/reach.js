// Poses reached by the closed form: all branches of a pose, the one that is wanted, and why there is none.

import { boundsOf, hereOf, lifted, partOf, placed } from "../core/state.js";

const COLUMNS = 6; // residual, subproblem residual, free coordinates, code, branch margin, excess
export const LEEWAY = 1e-12; // by how much a coordinate may be beyond its limit: winding rounds
const NO_POSE = 1e-6;

/**
 * @typedef {import("../core/state.js").State} State
 * @typedef {import("../core/state.js").Arm} Arm
 * @typedef {{row: number, code: number, q: number[], residual: number, excess: number, solves: boolean,
 *            within: boolean}} Branch
 */

/** 16 numbers of a pose, by plain products and sums in the order of `mafsil.page.session.pose_from`. */
export function poseFrom([px, py, pz], [w, x, y, z]) {
  const size = w * w + x * x + y * y + z * z, s = 2 / size;
  if (!Number.isFinite(size) || size === 0) throw new RangeError("a quaternion of zeros turns nothing");
  return [
    1 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y), px,
    s * (x * y + w * z), 1 - s * (x * x + z * z), s * (y * z - w * x), py,
    s * (x * z - w * y), s * (y * z + w * x), 1 - s * (x * x + y * y), pz,
    0, 0, 0, 1];
}

/** 16 numbers of the tip's pose. @param {State} state @param {Arm} arm */
export function tipPose(state, { settings, kernels }) {
  return Array.from(kernels.tip_pose(partOf(settings, hereOf(state)))[0]);
}

/**
 * All rows of the closed form for a pose, those that do not solve it included.
 *
 * @param {State} state  from which angles are wound and which locked joints keep
 * @param {ArrayLike<number>} T
 * @param {Arm} arm
 * @returns {Branch[]}
 */
export function branchesAt(state, T, { settings, kernels }) {
  const here = partOf(settings, hereOf(state)), m = here.length;
  const turns = Array.from(kernels.turns(here)[0]);
  const [rows, details, defect] = kernels.branches(T, here, turns, ...boundsOf(settings));
  const found = [];
  for (let row = 0; row * COLUMNS < details.length; row++) {
    const [residual, , , , , excess] = details.subarray(COLUMNS * row, COLUMNS * (row + 1));
    const solves = residual <= settings.tolerance && defect[0] <= NO_POSE, q = Array.from(rows.subarray(m * row, m * row + m));
    const code = solves ? kernels.branch_code(q)[0][0] : -1;
    found.push({ row, code, q, residual, excess, solves, within: solves && excess <= LEEWAY });
  }
  return found;
}

/** The arm on a branch of a pose, or where it was, with the reason. @returns {State} */
export function taken(state, T, row, arm) {
  const branches = branchesAt(state, T, arm), one = branches[row];
  if (!one) throw new RangeError(`there are ${branches.length} branches, counted from 0; ${row} is none`);
  if (one.within) return placed(state, lifted(arm.settings, hereOf(state), one.q), "solved");
  const status = one.solves ? "beyond_limits" : "no_branch";
  return { ...state, status, reason: reasonAt(T, branches, arm) ?? reasonOf(one, branches, arm) };
}

/**
 * A joint that is free to choose turned while the tip stays, on a branch of its pose; or where it was, with the reason.
 *
 * @param {State} state
 * @param {{joint: number, value: number, branch: number}} given
 * @param {Arm} arm
 * @returns {State}
 */
export function swung(state, { joint, value, branch }, arm) {
  if (!arm.settings.locked.includes(joint)) throw new RangeError(`free to choose are ${arm.settings.locked}, not ${joint}`);
  const T = tipPose(state, arm), next = taken(placed(state, hereOf(state).with(joint, value)), T, branch, arm);
  return next.status === "solved" ? next : { ...state, status: next.status, reason: next.reason };
}

/** Why one branch does not reach a pose that others reach. */
function reasonOf(one, branches, { settings }) {
  const count = branches.filter((branch) => branch.within).length;
  if (!one.solves) return { key: "why_branch_none", values: { branch: one.row, count } };
  return { key: "why_branch_limits", values: { branch: one.row, excess: excessText(one, settings), count } };
}

const short = (x) => Number(x.toPrecision(4));

/** By how much a branch is beyond the limits, in the unit of the joint that is farthest beyond. @param {Branch} branch */
export function excessOf({ q, excess }, settings) {
  const [lower, upper] = boundsOf(settings), over = q.map((value, k) => Math.max(value - upper[k], lower[k] - value));
  return { excess, prismatic: settings.prismatic[settings.places[over.indexOf(Math.max(...over))]] };
}

/** The same in words. */
const excessText = (branch, settings) => `${short(branch.excess)} ${excessOf(branch, settings).prismatic ? "m" : "rad"}`;

/** The row whose coordinates are nearest to where the arm is, among those that solve the pose within the limits. */
export function nearestRow(state, branches, settings) {
  const here = partOf(settings, hereOf(state));
  const distance = ({ q }) => Math.hypot(...q.map((value, k) => value - here[k]));
  const usable = branches.filter((branch) => branch.within);
  return usable.length ? usable.reduce((a, b) => (distance(b) < distance(a) ? b : a)).row : -1;
}

/**
 * Why a pose is not reached, as a sentence and the numbers that prove it; null where a branch reaches it.
 *
 * @param {ArrayLike<number>} T
 * @param {Branch[]} branches
 * @param {Arm} arm
 * @returns {import("../core/state.js").Reason | null}
 */
export function reasonAt(T, branches, { settings }) {
  if (branches.some((branch) => branch.within)) return null;
  const solving = branches.filter((branch) => branch.solves);
  if (solving.length) {
    const nearest = solving.reduce((a, b) => (b.excess < a.excess ? b : a));
    return { key: "why_limits", values: { count: solving.length, excess: excessText(nearest, settings) } };
  }
  const distance = Math.hypot(...settings.centre.map((c, k) => T[4 * k + 3] - c));
  if (settings.radius !== null && distance > settings.radius)
    return { key: "why_far", values: { distance: short(distance), reach: short(settings.radius) } };
  const miss = Math.min(...branches.map((branch) => (branch.residual >= 0 ? branch.residual : Infinity)));
  const values = { miss: Number.isFinite(miss) ? short(miss) : "–", joint: settings.locked.map((k) => k + 1).join(", ") };
  return { key: settings.locked.length ? "why_locked" : "why_none", values };
}
