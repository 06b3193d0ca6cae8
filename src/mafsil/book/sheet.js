// A sheet of exercises: answers are judged in the page, hints shown one by one, marks saved as a table.

import { saveFile } from "../page/views/elements.js";
import { judge, numbersOf } from "./judging.js";

const sheet = JSON.parse(document.getElementById("data").textContent);
const root = document.documentElement, kept = `mafsil-sheet-${sheet.key}`;
const say = (name, place = "") => sheet.words[root.lang][name].replace("{place}", place);
const fields = sheet.exercises.flatMap(({ parts }, k) => parts.map((part) => ({ part, k, box: document.getElementById(`answer-${k}-${part.name}`) })));

function speak(language) {
  root.lang = language;
  root.dir = language === "ar" ? "rtl" : "ltr";
  document.title = sheet.titles[language];
  for (const button of document.querySelectorAll("[data-say]")) button.textContent = say(button.dataset.say);
  for (const { box } of fields) if (box.dataset.shown) show(box);
  count();
}

function show(box) {
  const [mistake, place] = JSON.parse(box.dataset.shown);
  const line = document.getElementById(`${box.id}-verdict`);
  line.textContent = say(`mistake_${mistake || "none"}`, place);
  line.className = `verdict ${mistake ? "bad" : "good"}`;
  box.setAttribute("aria-invalid", String(Boolean(mistake)));
}

function count() {
  const right = fields.filter(({ box }) => box.dataset.shown && !JSON.parse(box.dataset.shown)[0]).length;
  document.getElementById("points").textContent = sheet.exam ? "" : `${right} / ${fields.length}`;
}

function check(k) {
  for (const { part, box } of fields.filter((field) => field.k === k)) {
    const given = numbersOf(part, box.value, sheet.rules);
    box.dataset.shown = JSON.stringify(given === null ? ["unread", ""] : judge(part, given, sheet.rules));
    show(box);
  }
  count();
}

function remember() {
  try {
    localStorage.setItem(kept, JSON.stringify(fields.map(({ box }) => box.value)));
  } catch { /* a browser that keeps nothing for files on disk */ }
}

function recall() {
  try {
    JSON.parse(localStorage.getItem(kept) ?? "[]").forEach((value, k) => { fields[k].box.value = value; });
  } catch { /* as above */ }
}

function save() {
  const quoted = (text) => `"${String(text).replaceAll('"', '""').replace(/\s+/g, " ")}"`;
  const lines = fields.map(({ part, k, box }) => {
    const { number, seed, level } = sheet.exercises[k];
    const points = box.dataset.shown ? Number(!JSON.parse(box.dataset.shown)[0]) : "";
    return [quoted(sheet.student), quoted(number), seed, level, quoted(part.name), quoted(box.value.replaceAll("\n", "; ")), points].join(",");
  });
  saveFile(`${sheet.name}.csv`, ["student,exercise,seed,level,quantity,answer,points", ...lines].join("\n") + "\n", "text/csv");
}

document.addEventListener("input", remember);
document.addEventListener("click", ({ target }) => {
  const button = target.closest("button"), k = Number(button?.dataset.k);
  if (button?.dataset.say === "check") check(k);
  if (button?.dataset.say === "hint") {
    const waiting = document.querySelectorAll(`#exercise-${k} .hints > li[hidden]`);
    waiting[0]?.removeAttribute("hidden");
    button.disabled = waiting.length < 2;
  }
  if (button?.dataset.say === "save_marks") save();
  if (button?.dataset.say === "print") print();
  if (button?.dataset.say === "other_language") speak(root.lang === "ar" ? "en" : "ar");
});
recall();
speak(root.lang);
