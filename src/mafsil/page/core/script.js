// A script that a page saved, read back into actions. Only its own lines are understood; nothing is ever run.

/** @typedef {import("./actions.js").Action} Action */

/** A line that is not understood, or not this robot's. */
export class ScriptError extends Error {
  /** @param {string} key  of the sentence @param {Object<string, string | number>} values */
  constructor(key, values) {
    super(key);
    this.reason = { key, values };
  }
}

/**
 * The actions of a script, each with the number of its line.
 *
 * @param {string} text
 * @param {Object<string, string[]>} args  of every action, the names of its arguments in their order
 * @param {string} robot  the Python expression that names the robot
 * @param {string[]} imports  lines in front that it needs
 * @returns {{action: Action, line: number}[]}
 */
export function scriptActions(text, args, robot, imports = []) {
  let session = null;
  const found = [];
  for (const [k, whole] of text.split(/\r?\n/).entries()) {
    const code = whole.trim(), refused = () => new ScriptError("script_line", { line: k + 1 });
    if (code === "" || /^#|^from mafsil\.page import Session$|^print\(/.test(code) || imports.includes(code)) continue;
    const made = /^(\w+) = Session\((.*)\)$/.exec(code), called = /^(\w+)\.(\w+)\((.*)\)(\s*#.*)?$/.exec(code);
    if (made && session === null) {
      session = made[1];
      if (plainQuotes(made[2]) !== plainQuotes(robot)) throw new ScriptError("script_robot", { robot: made[2] });
    } else if (called && called[1] === session && Object.hasOwn(args, called[2])) {
      const given = argumentsOf(called[3], args[called[2]]);
      if (!given) throw refused();
      found.push({ action: { do: called[2], with: given }, line: k + 1 });
    } else throw refused();
  }
  if (session === null) throw new ScriptError("script_empty", {});
  return found;
}

const plainQuotes = (code) => code.replaceAll('"', "'");

/** Arguments by name; null where they are not those of the action. */
function argumentsOf(code, names) {
  const given = {};
  for (const [k, part] of commaParts(code).entries()) {
    const keyword = /^\s*([a-z_]\w*)\s*=(.*)$/.exec(part), name = keyword ? keyword[1] : names[k];
    const value = literal(keyword ? keyword[2] : part);
    if (value === null || !names.includes(name) || Object.hasOwn(given, name)) return null;
    given[name] = value;
  }
  return Object.keys(given).length === names.length ? given : null;
}

/** Pieces between the commas that stand in no bracket. */
function commaParts(code) {
  const pieces = [""];
  let depth = 0;
  for (const letter of code) {
    depth += Number("[(".includes(letter)) - Number("])".includes(letter));
    if (letter === "," && depth === 0) pieces.push("");
    else pieces[pieces.length - 1] += letter;
  }
  if (pieces.at(-1).trim() === "") pieces.pop();
  return pieces;
}

/** A number, True, False, or a list of numbers; null for anything else. */
function literal(code) {
  const text = code.trim(), list = /^[[(](.*)[\])]$/.exec(text);
  if (text === "True" || text === "False") return text === "True";
  if (!list) return /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(text) && Number.isFinite(Number(text)) ? Number(text) : null;
  const values = commaParts(list[1]).map(literal);
  return values.every((value) => typeof value === "number") ? values : null;
}
