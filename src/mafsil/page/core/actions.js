// Everything that can be done. An action is data, {do: name, with: {argument: value}}; doing it gives the next state.
// Names and arguments are those of the methods of `mafsil.page.Session`, which does the same to the same bits.

import { looped, placed } from "./state.js";
import { followed } from "../loops/follow.js";
import { poseFrom, swung, taken, tipPose } from "../loops/reach.js";
import { searched } from "../loops/search.js";
import { simulated } from "../loops/simulate.js";

/**
 * @typedef {{do: string, with: Object<string, any>, note?: string}} Action  note: a remark on its line of Python
 * @typedef {import("./state.js").State} State
 * @typedef {import("./state.js").Arm} Arm
 */

/** @type {Object<string, (state: State, given: any, arm: Arm) => State>} */
export const ACTIONS = {
  set_joint: (state, { joint, value }, arm) => {
    const q = (state.loop ? state.goal : state.q).with(index(joint, state.q.length), value), { driven } = arm.settings;
    if (driven && !driven.includes(joint)) throw new RangeError(`driven are the joints ${driven}, not ${joint}`);
    return driven ? followed(state, q, state.q, arm) : placed(state, q);
  },
  set_joints: (state, { values }, arm) => {
    const q = numbers(values, state.q.length);
    return arm.settings.driven ? followed(state, q, q, arm) : placed(state, q);
  },
  reach: (state, { position, quaternion, branch }, arm) => taken(state, poseFrom(position, quaternion), branch, arm),
  choose: (state, { branch }, arm) => taken(state, tipPose(state, arm), branch, arm),
  swing: (state, given, arm) => swung(state, given, arm),
  search: (state, { position, quaternion }, arm) => searched(state, poseFrom(position, quaternion), arm),
  loop: (state, { closed }) => looped(state, closed),
  push: (state, { wrench }) => ({ ...state, push: numbers(wrench, 6) }),
  simulate: (state, { ticks }, arm) => simulated(state, ticks, arm),
};

/** A place in a list, as it is. */
function index(k, count) {
  if (!Number.isInteger(k) || k < 0 || k >= count) throw new RangeError(`places are 0 to ${count - 1}, not ${k}`);
  return k;
}

/** A copy of so many numbers. */
function numbers(values, count) {
  if (values.length !== count) throw new RangeError(`${count} numbers, not ${values.length}`);
  return Array.from(values);
}

/**
 * How a later action of the same gesture joins the one before: it is done again from where the gesture began, or its
 * ticks are added. So the journal holds one line for a gesture, and that line alone leads to the same state.
 *
 * @type {Object<string, "again" | "added">}
 */
export const JOINS = { set_joint: "again", set_joints: "again", reach: "again", swing: "again", search: "again", push: "again", simulate: "added" };

/** Whether an action continues the gesture of the one before. @param {Action | undefined} last @param {Action} next */
export function joins(last, next) {
  if (!last || last.do !== next.do || !(next.do in JOINS)) return false;
  return next.do !== "set_joint" || last.with.joint === next.with.joint;
}
