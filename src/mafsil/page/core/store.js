// One state, changed by actions alone; views listen.

import { ACTIONS, JOINS, joins } from "./actions.js";
import { ScriptError } from "./script.js";
import { firstState } from "./state.js";

/**
 * @typedef {import("./actions.js").Action} Action
 * @typedef {import("./state.js").State} State
 * @typedef {import("./state.js").Arm} Arm
 */

/** The link of a page that is a file: nobody else acts. */
const NO_LINK = { name: () => "", owns: () => true, put() {}, drop() {} };

export class Store {
  /** @param {Arm} arm */
  constructor(arm) {
    this.arm = arm;
    /** Where the actions have led. @type {State} */
    this.now = firstState(arm.settings);
    /** @type {{id: string, action: Action, before: State}[]} */
    this.entries = [];
    this.link = NO_LINK;
    this.open = false; // a gesture is going on
    /**
     * Actions that views bring: each is a list of actions of the package.
     *
     * @type {Object<string, (state: State, given: any, arm: Arm) => [string, object][]>}
     */
    this.own = {};
    /**
     * What views show without being asked by an action: languages, ghosts, the branch and the thing that are pointed at,
     * what is hidden, units, the joint that is touched, the thing of the job that is held, a posture that is pointed at, the pose that is wished for, the
     * replay that is going on or was left, a table that was edited.
     */
    this.shown = {
      ghosts: false, peek: -1, lit: null, hidden: new Set(), angle: "rad", length: "m", theme: "system", frames: false, touched: -1,
      selected: -1, preview: null, loads: false, ellipsoid: false, forces: false, wish: null, refusal: null, frame: -1, replay: null, left: null,
      table: null
    };
    /** @type {Set<(what: string) => void>} */
    this.listeners = new Set();
  }

  /** @returns {Action[]} */
  get journal() {
    return this.entries.map((entry) => entry.action);
  }

  /**
   * Do an action.
   *
   * @param {string} name
   * @param {Object<string, any>} given
   * @param {{gesture?: boolean, note?: string}} how  gesture: one of many that together are one, as while a slider
   *   moves; note: said behind its line of Python
   */
  do(name, given, { gesture = false, note = "" } = {}) {
    if (Object.hasOwn(this.own, name)) {
      for (const [part, values] of this.own[name](this.state, given, this.arm)) this.do(part, values, { gesture });
      return;
    }
    const known = ACTIONS[name];
    if (!known) throw new RangeError(`no action is called ${name}`);
    this.takeOver();
    this.shown.refusal = null;
    const last = this.entries.at(-1), action = note ? { do: name, with: given, note } : { do: name, with: given };
    if (gesture && this.open && last && this.link.owns(last.id) && joins(last.action, action)) {
      const added = JOINS[name] === "added";
      this.now = known(added ? this.now : last.before, given, this.arm);
      last.action = added ? { do: name, with: { ticks: last.action.with.ticks + given.ticks } } : action;
    } else {
      const before = this.now;
      this.now = known(before, given, this.arm);
      this.entries.push({ id: this.link.name(), action, before });
    }
    this.open = gesture;
    this.link.put(this.entries.at(-1));
    this.changed("state");
  }

  /** What is shown: the arm where a replay has it, at rest, or else where the actions have led. @returns {State} */
  get state() {
    const q = this.shown.replay?.q;
    if (!q) return this.now;
    if (this.replayed?.q !== q) this.replayed = firstState({ start: q, n: q.length });
    return this.replayed;
  }

  /** Show the arm where the actions have led, instead of a replay; one can come back to that. */
  leave() {
    const { replay, left } = this.shown;
    Object.assign(this.shown, { replay: null, left: replay ? { ...replay, playing: false } : left });
  }

  /** The arm leaves the replay that is shown and begins where it is, as a line of the journal. */
  takeOver() {
    const { replay } = this.shown;
    if (!replay?.q) return;
    this.leave();
    this.open = false;
    if (this.now.loop) this.do("loop", { closed: false });
    this.do("set_joints", { values: Array.from(replay.q) }, { note: `t = ${replay.time.toFixed(3)} s` });
  }

  /**
   * More actions, each a list of those that are there: so their lines of Python are known everywhere.
   *
   * @param {Object<string, (state: State, given: any, arm: Arm) => [string, object][]>} actions
   */
  learn(actions) {
    for (const [name, parts] of Object.entries(actions)) {
      if (Object.hasOwn(ACTIONS, name) || Object.hasOwn(this.own, name)) throw new RangeError(`two actions are called ${name}`);
      this.own[name] = parts;
    }
  }

  /**
   * Begin anew and do all of this; where something cannot be done all is as before.
   *
   * @param {{action: Action, line: number}[]} script
   */
  replay(script) {
    const { now, entries } = this;
    Object.assign(this, { now: firstState(this.arm.settings), entries: [], open: false });
    for (const { action, line } of script) {
      const before = this.now;
      try {
        this.now = ACTIONS[action.do](before, action.with, this.arm);
      } catch {
        Object.assign(this, { now, entries });
        throw new ScriptError("script_line", { line });
      }
      this.entries.push({ id: this.link.name(), action, before });
    }
    for (const { id } of entries) this.link.drop(id);
    for (const entry of this.entries) this.link.put(entry);
    this.leave();
    this.changed("state");
  }

  /** The gesture is over: the next action begins a line of its own. */
  release() {
    this.open = false;
  }

  /** The state before the last action. */
  undo() {
    const last = this.entries.pop();
    if (!last) return;
    this.now = last.before;
    this.open = false;
    this.link.drop(last.id);
    this.changed("state");
  }

  /**
   * The journal becomes another: what both begin with stays, the rest is done anew.
   *
   * @param {{id: string, action: Action}[]} journal
   * @param {(a: Action, b: Action) => boolean} same
   */
  adopt(journal, same) {
    let k = 0;
    while (k < journal.length && k < this.entries.length && this.entries[k].id === journal[k].id && same(this.entries[k].action, journal[k].action)) {
      this.entries[k].action = journal[k++].action; // the very same, so that the next comparison costs nothing
    }
    if (k === journal.length && k === this.entries.length) return;
    const mine = this.entries.at(-1)?.id;
    if (!this.lengthened(journal, k)) {
      if (k < this.entries.length) this.now = this.entries[k].before;
      this.entries.length = k;
      for (const { id, action } of journal.slice(k)) {
        this.entries.push({ id, action, before: this.now });
        this.now = ACTIONS[action.do](this.now, action.with, this.arm);
      }
    }
    this.open = this.open && this.entries.at(-1)?.id === mine;
    this.changed("state");
  }

  /** Whether only more time has passed at the end of the journal: then it is let pass, and the rest stays. */
  lengthened(journal, k) {
    const last = this.entries.at(-1), next = journal[k]?.action;
    if (k !== journal.length - 1 || k !== this.entries.length - 1 || last.id !== journal[k].id) return false;
    if (next.do !== "simulate" || last.action.do !== "simulate" || next.with.ticks < last.action.with.ticks) return false;
    this.now = ACTIONS.simulate(this.now, { ticks: next.with.ticks - last.action.with.ticks }, this.arm);
    last.action = next;
    return true;
  }

  /** The state before the gesture that is going on, or now. */
  get base() {
    return this.open ? this.entries.at(-1).before : this.state;
  }

  /** Show something else. @param {Object<string, any>} changes */
  show(changes) {
    Object.assign(this.shown, changes);
    this.changed("shown");
  }

  /** @param {(what: string) => void} listener */
  listen(listener) {
    this.listeners.add(listener);
  }

  changed(what) {
    for (const listener of this.listeners) listener(what);
  }
}
