// The link of a page to the server that several windows share; a page that is a file has none.
//
// The server keeps the journal. A window does its actions at once and sends them; what the server has told is
// `confirmed`, what it has not yet told is `pending`. A window shows the confirmed journal with its pending actions on
// top, so all windows end with the same journal, whatever was done at the same time.

import { line } from "./journal.js";

/**
 * @typedef {import("./actions.js").Action} Action
 * @typedef {{id: string, action: Action}} Named
 * @typedef {{send: (path: string, body: object) => Promise<{status: number, data: any}>,
 *            listen: (heard: (message: object) => void, connected: (now: boolean) => void) => void}} Transport
 */

const RETRY = 1000; // ms before what did not arrive is sent again

export class ServerLink {
  /**
   * @param {import("./store.js").Store} store
   * @param {Object<string, string[]>} args  of every action, the names of its arguments in their order
   * @param {Transport} transport
   * @param {string} window  a name that no other window has
   */
  constructor(store, args, transport, window) {
    Object.assign(this, { store, args, transport, window });
    this.count = 0;
    /** @type {Named[]} */
    this.confirmed = [];
    /** @type {Map<string, Action | null>}  null: to be dropped */
    this.pending = new Map();
    /** @type {Map<string, Action | null>}  what changed since it was sent */
    this.unsent = new Map();
    this.sending = false;
    this.connected = false;
    /** @type {Map<string, any>}  the last message of every other kind */
    this.heard = new Map();
    store.link = this;
    transport.listen((message) => this.hear(message), (now) => this.connect(now));
  }

  /** A name for a new entry of the journal. */
  name() {
    return `${this.window}-${++this.count}`;
  }

  /** Whether an entry was made in this window. @param {string} id */
  owns(id) {
    return id.startsWith(`${this.window}-`);
  }

  /** An entry was made, or its gesture went on. @param {Named} entry */
  put({ id, action }) {
    this.keep(id, { do: action.do, with: positive(action.with) });
  }

  /** An entry was taken back. @param {string} id */
  drop(id) {
    this.keep(id, null);
  }

  keep(id, action) {
    this.pending.set(id, action);
    this.unsent.set(id, action);
    this.flush();
  }

  /** Send what has changed, one request at a time: what changes meanwhile goes with the next. */
  async flush() {
    if (this.sending || !this.unsent.size) return;
    this.sending = true;
    const batch = [...this.unsent].slice(0, 32);
    for (const [id] of batch) this.unsent.delete(id);
    const body = batch.map(([id, action]) => (action ? { kind: "put", id, do: action.do, with: action.with } : { kind: "drop", id }));
    try {
      const { status, data } = await this.transport.send("actions", body);
      if (status !== 200) this.refused(batch, data);
      else for (const [id, action] of batch) if (!action && !this.unsent.has(id) && !this.confirmed.some((one) => one.id === id)) this.pending.delete(id);
    } catch {
      for (const [id, action] of batch) if (!this.unsent.has(id)) this.unsent.set(id, action);
      await new Promise((done) => setTimeout(done, RETRY));
    }
    this.sending = false;
    this.flush();
  }

  /** The server took none of these: the window goes back to what all share. */
  refused(batch, data) {
    for (const [id] of batch) {
      this.pending.delete(id);
      this.unsent.delete(id);
    }
    this.heard.set("refusal", data?.error ?? null);
    this.show();
  }

  /** A message of the server. @param {any} message */
  hear(message) {
    if (message.kind === "all") {
      this.confirmed = message.journal.map(({ id, ...action }) => ({ id, action }));
      for (const one of this.confirmed) this.settle(one.id, one.action);
      for (const [id, action] of this.pending) this.unsent.set(id, action);
      for (const [kind, value] of Object.entries(message.rest)) this.heard.set(kind, value);
      this.flush();
    } else if (message.kind === "put") {
      const action = { do: message.do, with: message.with }, known = this.confirmed.find((one) => one.id === message.id);
      if (known) known.action = action;
      else this.confirmed.push({ id: message.id, action });
      this.settle(message.id, action);
    } else if (message.kind === "drop") {
      this.confirmed = this.confirmed.filter((one) => one.id !== message.id);
      if (this.pending.get(message.id) === null) this.pending.delete(message.id);
    } else {
      if (message.kind === "ticks") lengthen(this.heard.get("motion"), message);
      else this.heard.set(message.kind, message);
      this.store.changed("heard");
      return;
    }
    this.show();
  }

  /** What the server has told is no longer pending, unless it has changed since. */
  settle(id, action) {
    const waiting = this.pending.get(id);
    if (waiting && this.same(waiting, action)) this.pending.delete(id);
  }

  same(a, b) {
    return a === b || (a.do === b.do && line(a, this.args) === line(b, this.args));
  }

  /** The confirmed journal with what is pending on top. */
  show() {
    const wanted = [];
    for (const { id, action } of this.confirmed) {
      const waiting = this.pending.get(id);
      if (waiting !== null) wanted.push({ id, action: waiting ?? action });
    }
    for (const [id, action] of this.pending) if (action && !this.confirmed.some((one) => one.id === id)) wanted.push({ id, action });
    this.store.adopt(wanted, (a, b) => this.same(a, b));
  }

  /** The answer of the server, or what it refuses with. @param {string} path @param {object} body */
  async fetched(path, body) {
    return (await this.transport.send(path, body)).data;
  }

  connect(now) {
    this.connected = now;
    this.store.changed("heard");
  }
}

/** More of a motion that is being computed. */
function lengthen(motion, { t, q }) {
  motion?.t.push(...t);
  motion?.q.push(...q);
}

/** Numbers without the sign of zero, which JSON does not carry. */
function positive(given) {
  const one = (value) => (typeof value === "number" ? value + 0 : Array.isArray(value) ? value.map(one) : value);
  return Object.fromEntries(Object.entries(given).map(([name, value]) => [name, one(value)]));
}

/** Requests to the server that the page came from, and its messages as they come. @returns {Transport} */
export function serverTransport() {
  return {
    async send(path, body) {
      const answer = await fetch(path, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) });
      return { status: answer.status, data: await answer.json() };
    },
    listen(heard, connected) {
      const events = new EventSource("events");
      events.onmessage = ({ data }) => heard(JSON.parse(data));
      events.onopen = () => connected(true);
      events.onerror = () => connected(false);
    },
  };
}
