"""Windows that act at the same time, in Node: whatever the order in which messages arrive, all end with one journal."""

from __future__ import annotations

import json
from pathlib import Path

from tests.page.node import run_module

SCRIPT = """
import { ServerLink } from "./page/core/link.js";
import { Store } from "./page/core/store.js";

const ARGS = { set_joint: ["joint", "value"], set_joints: ["values"], push: ["wrench"] };
const settings = { n: 2, start: [0, 0] };

/** A generator of numbers that is the same every time. */
function dice(seed) {
  let state = seed >>> 0;
  return (n) => { state = (Math.imul(state, 1664525) + 1013904223) >>> 0; return Math.floor(state / 4294967296 * n); };
}

/** The journal as the server keeps it; messages wait until somebody lets them through. */
class Server {
  constructor(throws) { Object.assign(this, { lines: new Map(), windows: [], requests: [], throws, lost: 0 }); }
  transport() {
    const window = { queue: [], heard: null };
    this.windows.push(window);
    return {
      send: (path, body) => new Promise((answer, fail) => {
        this.requests.push({ body: JSON.parse(JSON.stringify(body)), answer, fail });
      }),
      listen: (heard) => { window.heard = heard; },
    };
  }
  tell(message) { for (const one of this.windows) one.queue.push(message); }
  all() { return { kind: "all", journal: [...this.lines].map(([id, done]) => ({ id, ...done })), rest: {} }; }
  serve(k) {
    const [{ body, answer, fail }] = this.requests.splice(k, 1), before = this.throws(10);
    if (before === 0) { this.lost++; fail(new Error("lost before")); return; }
    for (const { kind, id, ...done } of body) {
      if (kind === "put") { this.lines.set(id, done); this.tell({ kind, id, ...done }); }
      else if (this.lines.delete(id)) this.tell({ kind, id });
    }
    if (before === 1) { this.lost++; fail(new Error("lost after")); return; }
    answer({ status: 200, data: {} });
  }
}

const results = [];
globalThis.setTimeout = (done) => { queueMicrotask(done); };
const rest = async () => { for (let k = 0; k < 20; k++) await null; };

for (let seed = 1; seed <= Number(process.argv[2]); seed++) {
  const roll = dice(seed), server = new Server(roll), stores = [], mine = new Map();
  let foreign = 0, hidden = 0;
  for (let w = 0; w < 3; w++) {
    stores.push(new Store({ settings, kernels: {} }));
    new ServerLink(stores[w], ARGS, server.transport(), `w${w}`);
    server.windows[w].heard(server.all());
  }
  const step = async (acting) => {
    const w = roll(3), store = stores[w], window = server.windows[w], what = roll(acting ? 8 : 2);
    if (what === 0 && server.requests.length) server.serve(roll(server.requests.length));
    else if (what === 1 && window.queue.length) window.heard(window.queue.shift());
    else if (what === 2 && roll(4) === 0) { window.queue.length = 0; window.heard(server.all()); } // lost and back
    else if (what === 3) store.release();
    else if (what === 4 && roll(3) === 0 && store.entries.length) {
      mine.set(store.entries.at(-1).id, null);
      store.undo();
    }
    else if (what > 4) {
      if (what === 7) store.open = true; // as the closed loop does while time passes
      store.do("set_joint", { joint: roll(2), value: roll(1000) / 7 }, { gesture: roll(2) === 0 });
      const { id, action } = store.entries.at(-1);
      if (!id.startsWith(`w${w}-`)) foreign++;
      mine.set(id, JSON.stringify(action));
    }
    await rest();
    // What a window did itself is seen there, sooner or later than the server says so.
    stores.forEach((one, k) => {
      const shown = new Map(one.entries.map(({ id, action }) => [id, JSON.stringify(action)]));
      const own = [...mine].filter(([id, action]) => action && id.startsWith(`w${k}-`) && shown.has(id));
      for (const [id, action] of own) if (shown.get(id) !== action) hidden++;
      for (const [id, action] of one.link.pending) if (shown.has(id) !== (action !== null)) hidden++;
    });
  };
  for (let k = 0; k < 80; k++) await step(true);
  while (server.requests.length || server.windows.some((one) => one.queue.length)) await step(false);
  const journal = JSON.stringify([...server.lines.values()]);
  results.push({
    same: stores.every((store) => JSON.stringify(store.journal) === journal && store.link.pending.size === 0),
    states: new Set(stores.map((store) => JSON.stringify(store.state))).size,
    lines: server.lines.size,
    lost: server.lost,
    foreign,
    hidden,
  });
}
console.log(JSON.stringify(results));
"""


def test_windows_end_with_one_journal_and_one_state(tmp_path: Path) -> None:
    """Three windows, requests lost before and after they were served, connections that break, lines taken back."""
    results = json.loads(run_module(SCRIPT, tmp_path, "400"))
    assert len(results) == 400
    assert all(one["same"] and one["states"] == 1 for one in results)
    assert not any(one["foreign"] or one["hidden"] for one in results)
    assert sum(one["lines"] for one in results) > 4000
    assert sum(one["lost"] for one in results) > 1000
