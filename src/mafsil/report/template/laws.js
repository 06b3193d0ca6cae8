// Laws side by side: their curves with a legend that belongs to all plots, and the texts of both languages.

import { Words } from "../../page/core/words.js";
import { sentence } from "../../page/views/elements.js";
import { Motion } from "./motion.js";
import { Texts } from "./texts.js";

const bench = JSON.parse(document.getElementById("data").textContent);
const words = new Words(bench.languages, bench.language), texts = new Texts(bench.language), motion = new Motion(bench, () => {});

/** Everything in the language that is chosen. */
function speak() {
  const root = document.documentElement;
  root.lang = words.chosen;
  root.dir = words.direction;
  document.title = bench.titles[words.chosen];
  for (const place of document.querySelectorAll("[data-say]")) place.replaceChildren(sentence(words, place.dataset.say));
  for (const place of document.querySelectorAll("[data-label]")) place.setAttribute("aria-label", words.text(place.dataset.label));
  texts.show(words.chosen);
  document.querySelectorAll("#legend span").forEach((name, k) => { name.textContent = bench.texts[words.chosen].laws[k]; });
  motion.speak(bench.texts[words.chosen].plots, (key) => words.text(key));
}

document.getElementById("language").addEventListener("click", () => {
  const known = Object.keys(bench.languages);
  words.chosen = known[(known.indexOf(words.chosen) + 1) % known.length];
  speak();
});
speak();
