// The page of a studio: linked to the server that it came from.

import { carried, complain, opened } from "page/app.js";
import { written } from "page/views/elements.js";
import { ServerLink, serverTransport } from "page/core/link.js";
import { quaternionOf } from "page/core/rotations.js";
import { posed } from "page/core/tape.js";

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

/** The text of the job follows what is placed; undo brings back the text from before. */
function placing(app) {
  const { link, store } = app, texts = [], send = (path, body) => link.transport.send(path, body);
  app.placed = async (thing, T) => {
    const job = link.heard.get("job"), row = (k) => [0, 1, 2, 3].map((c) => T[4 * c + k]), quaternion = quaternionOf([0, 1, 2].flatMap(row));
    const { status, data } = await send("job/place", { thing, position: Array.from(T.slice(12, 15)), quaternion });
    if (status === 200) texts.push({ before: job.text, after: data.text, actions: store.entries.length });
    else {
      if (link.heard.get("job").around) app.player.surround(link.heard.get("job").around);
      app.say({ key: "not_placed", values: {} });
    }
  };
  app.takeBack = () => {
    const last = texts.at(-1);
    if (!last || store.entries.length > last.actions) return false;
    texts.pop();
    if (link.heard.get("job").text !== last.after) return false;
    send("job", { text: last.before, window: "" });
    return true;
  };
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
    placing(app);
    window.mafsil = app;
  })
  .catch(complain);
