// The page of a studio: linked to the server that it came from.

import { carried, complain, opened } from "page/app.js";
import { ServerLink, serverTransport } from "page/core/link.js";

const whole = carried();

opened(whole, (store) => new ServerLink(store, whole.actions, serverTransport(), crypto.randomUUID().slice(0, 8)))
  .then((app) => { window.mafsil = app; })
  .catch(complain);
