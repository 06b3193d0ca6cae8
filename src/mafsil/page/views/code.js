// The journal: every action as a line of Python, to be copied, saved and done again elsewhere to the same bits.

import { view } from "../core/views.js";
import { notedLine, script } from "../core/journal.js";
import { ScriptError, scriptActions } from "../core/script.js";
import { element, sentence } from "./elements.js";

view({
  name: "code",
  tab: "code",
  order: 80,
  open: true,
  mount(place, app) {
    const { store, words, data } = app;
    const list = element("pre", { dir: "ltr", tabindex: 0, role: "region", id: "journal", "aria-label": words.text("view_code") });
    const note = element("div", { class: "soft", role: "status" });
    const text = () => script(store.journal, data.actions, data.robot.python, data.robot.imports);
    const button = (key, act) => element("button", { type: "button", class: "quiet", "data-do": key, onclick: act }, sentence(words, key));
    const copy = async () => {
      try {
        await navigator.clipboard.writeText(text());
        note.replaceChildren(sentence(words, "copied"));
      } catch {
        getSelection().selectAllChildren(list);
        note.replaceChildren(sentence(words, "copy_by_hand"));
      }
    };
    const save = () => {
      const link = element("a", { href: URL.createObjectURL(new Blob([text()], { type: "text/x-python" })), download: `${data.robot.name}.py` });
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
    };
    const chooser = element("input", { type: "file", id: "script", accept: ".py,text/x-python,text/plain",
      hidden: true, "aria-label": words.text("open"), onchange: async () => {
      const [file] = chooser.files;
      if (file) read(await file.text());
      chooser.value = "";
    } });
    /** Do what a script says, or say why not. */
    const read = (given) => {
      try {
        const actions = scriptActions(given, data.actions, data.robot.python, data.robot.imports);
        app.playing = false;
        store.replay(actions);
        note.replaceChildren(sentence(words, "opened", { count: actions.length }));
      } catch (error) {
        if (!(error instanceof ScriptError)) throw error;
        note.replaceChildren(sentence(words, error.reason.key, error.reason.values));
      }
    };
    place.append(
      element("p", { class: "soft" }, sentence(words, "code_about")), list,
      element("div", { class: "buttons" }, button("copy", copy), button("save", save), button("open", () => chooser.click()), chooser), note
    );
    const rows = element("span", {});
    list.append(script([], data.actions, data.robot.python, data.robot.imports).split("\nprint")[0].trimEnd(), rows);
    /** Actions whose lines stand there; a gesture that goes on puts another in the place of its last. */
    const shown = [];
    return () => {
      const { entries } = store;
      let k = 0;
      while (k < shown.length && k < entries.length && shown[k] === entries[k].action) k++;
      if (k === shown.length && k === entries.length) return;
      const scrolls = entries.length !== shown.length;
      while (rows.childNodes.length > entries.length) rows.lastChild.remove();
      shown.length = k;
      for (const { action } of entries.slice(k)) {
        const text = `\n${notedLine(action, data.actions)}`, node = rows.childNodes[shown.length];
        if (node) node.data = text;
        else rows.append(text);
        shown.push(action);
      }
      if (scrolls) list.scrollTop = list.scrollHeight;
    };
  },
});
