// The page of a studio: linked to the server that it came from.

import { carried, complain, opened } from "page/app.js";
import { written } from "page/views/elements.js";
import { ServerLink, serverTransport } from "page/core/link.js";
import { posed } from "page/core/tape.js";

/** The text with another position from a line on, counted from one; null where none stands in that table. */
function placedIn(text, line, key, position) {
  const begin = text.split("\n").slice(0, line - 1).join("\n").length, rest = text.slice(begin), found = new RegExp(`${key}\\s*=\\s*\\[[^\\]]*\\]`).exec(rest);
  const next = rest.slice(1).search(/^\s*\[\[/m);
  if (!found || (next >= 0 && found.index > next + 1)) return null;
  return text.slice(0, begin + found.index) + `${key} = [${position.join(", ")}]` + rest.slice(found.index + found[0].length);
}

/** A run that was begun here: its path as soon as it is planned, the arm along what is computed of it, its recording. */
function follow({ link, store, player }) {
  const { watch } = link, motion = link.heard.get("motion"), run = link.heard.get("run"), shows = () => store.shown.replay?.first === watch.motion;
  if (!watch) return;
  if (motion && motion !== watch.motion) {
    const shown = watch.motion && shows();
    watch.motion = Object.assign(motion, { live: true });
    if (shown) store.shown.replay.first = motion;
    player.scenery?.trace(motion.path);
  }
  if (motion?.t.length && !watch.begun) {
    watch.begun = true;
    store.show({ left: null, replay: posed({ first: motion, second: null, time: 0, playing: true }) });
  }
  if (run?.status === "running" || !watch.told) {
    watch.told ||= run?.status === "running";
    return;
  }
  link.watch = null;
  if (motion) motion.live = false;
  if (!run.recording || (watch.begun && !shows())) return;
  document.getElementById("view-recordings").open = true;
  store.show({ chosen: [run.recording, null], plays: true });
}

const whole = carried();

opened(whole, (store) => new ServerLink(store, whole.actions, serverTransport(), crypto.randomUUID().slice(0, 8)))
  .then((app) => {
    let seen = null;
    app.join({ update: () => follow(app) });
    /** The scene of the job as it is written now; the first one turns to the tab of the job. */
    app.join({ update: () => {
      const job = app.link.heard.get("job");
      if (!job || job === seen) return;
      if (!seen && job.file) app.turn("job");
      seen = job;
      if (job.title) written(document.querySelector("#name h1 bdi"), job.title);
    } });
    /** What stands around the arm: that of the recording that is shown, else that of the job. */
    let around = null;
    app.join({ update: () => {
      const { shown: { replay, left } } = app.store, wanted = (replay ?? left)?.first.scenery ?? app.link.heard.get("job")?.around;
      if (!wanted || wanted === around) return;
      around = wanted;
      app.player.surround(around);
    } });
    /** The text of the job follows a target or a thing that was placed; what is relative stays where it was. */
    app.placed = (k, position) => {
      const job = app.link.heard.get("job"), { targets, places } = job.around,
        [line, key] = k < targets.length ? [job.lines[k], "position"] : places[k - targets.length];
      const text = line ? placedIn(job.text, line, key, position.map((x) => Number((x * job.scale).toPrecision(9)))) : null;
      if (text === null) app.player.surround(job.around);
      else app.link.transport.send("job", { text, window: "" });
    };
    window.mafsil = app;
  })
  .catch(complain);
