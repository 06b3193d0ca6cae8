// The page of a studio: linked to the server that it came from.

import { carried, complain, opened } from "page/app.js";
import { written } from "page/views/elements.js";
import { ServerLink, serverTransport } from "page/core/link.js";

const whole = carried();

opened(whole, (store) => new ServerLink(store, whole.actions, serverTransport(), crypto.randomUUID().slice(0, 8)))
  .then((app) => {
    let seen = null;
    /** The scene of the job as it is written now; the first one turns to the tab of the job. */
    app.join({ update: () => {
      const job = app.link.heard.get("job");
      if (!job || job === seen) return;
      if (!seen && job.file) app.turn("job");
      seen = job;
      if (job.around) app.player.surround(job.around);
      if (job.title) written(document.querySelector("#name h1 bdi"), job.title);
    } });
    window.mafsil = app;
  })
  .catch(complain);
