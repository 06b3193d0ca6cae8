// The report: the page of a robot with a recorded run, its plots and its numbers.

import { carried, complain, opened } from "../../page/app.js";
import { seek } from "../../page/core/tape.js";
import { Words } from "../../page/core/words.js";
import { Motion } from "./motion.js";
import { Texts } from "./texts.js";

const report = carried(), texts = new Texts(report.language);
let open = null;
const motion = new Motion(report, (time) => open && seek(open.store, time));

/** The plots in the language that is chosen. @param {Words} words */
const speak = (words) => motion.speak(report.texts[words.chosen].plots, (key) => words.text(key));
speak(new Words(report.languages, report.language));

opened(report).then((app) => {
  open = app;
  app.motion = motion;
  app.player.told = (time) => motion.mark(time);
  const spoken = () => { texts.show(app.words.chosen); speak(app.words); motion.measure((unit, curve) => app.scale(unit, curve)); };
  motion.dock(document.getElementById("bar"));
  app.join({ spoken });
  spoken();
  window.mafsil = app;
}).catch(complain);
