// What has been done, as data and as Python: one line for every action.

/** @typedef {import("./actions.js").Action} Action */

/** A value as Python writes it; numbers in full, so that they are read back to the bit. */
export function python(value) {
  if (typeof value === "boolean") return value ? "True" : "False";
  if (typeof value === "number") {
    if (!Number.isFinite(value)) throw new RangeError(`${value} is no number for a journal`);
    return Object.is(value, -0) ? "-0.0" : String(value);
  }
  if (typeof value === "string") return JSON.stringify(value);
  return `[${Array.from(value, python).join(", ")}]`;
}

/**
 * The line of an action.
 *
 * @param {Action} action
 * @param {Object<string, string[]>} args  of every action, the names of its arguments in their order
 */
export function line(action, args) {
  const given = args[action.do].map((name) => `${name}=${python(action.with[name])}`);
  return `arm.${action.do}(${given.join(", ")})`;
}

/** The same with what is noted behind it. @param {Action} action */
export function notedLine(action, args) {
  return line(action, args) + (action.note ? `  # ${action.note}` : "");
}

/**
 * The script that does it all again.
 *
 * @param {Action[]} actions
 * @param {Object<string, string[]>} args
 * @param {string} robot  the Python expression that names the robot
 * @param {string[]} imports  what that expression needs
 */
export function script(actions, args, robot, imports = []) {
  const head = ["from mafsil.page import Session", ...imports, "", `arm = Session(${robot})`];
  return [...head, ...actions.map((action) => notedLine(action, args)), "print(arm.status, arm.q.tolist())", ""].join("\n");
}
