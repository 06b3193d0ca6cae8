// The journal: every action as a line of Python, to be copied, saved and done again elsewhere to the same bits.

import { view } from "../core/views.js";
import { line, script } from "../core/journal.js";
import { ScriptError, scriptActions } from "../core/script.js";
import { element, sentence } from "./elements.js";

view({
  name: "code",
  order: 80,
  open: true,
  mount(place, app) {
    const { store, words, data } = app;
    const list = element("pre", { dir: "ltr", tabindex: 0, id: "journal", "aria-label": words.text("view_code") });
    const note = element("div", { class: "soft", role: "status" });
    const text = () => script(store.journal, data.actions, data.robot.python);
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
    const chooser = element("input", { type: "file", id: "script", accept: ".py,text/x-python,text/plain", hidden: true, "aria-label": words.text("open"), onchange: async () => {
      const [file] = chooser.files;
      if (file) read(await file.text());
      chooser.value = "";
    } });
    /** Do what a script says, or say why not. */
    const read = (given) => {
      try {
        const actions = scriptActions(given, data.actions, data.robot.python);
        app.playing = false;
        store.replay(actions);
        note.replaceChildren(sentence(words, "opened", { count: actions.length }));
      } catch (error) {
        if (!(error instanceof ScriptError)) throw error;
        note.replaceChildren(sentence(words, error.reason.key, error.reason.values));
      }
    };
    place.append(element("p", { class: "soft" }, sentence(words, "code_about")), list, element("div", { class: "buttons" }, button("copy", copy), button("save", save), button("open", () => chooser.click()), button("undo", () => store.undo()), chooser), note);
    const rows = element("span", {});
    list.append(script([], data.actions, data.robot.python).split("\nprint")[0].trimEnd(), rows);
    let shown = "", count = 0, seen = store.entries;
    return () => {
      const entries = store.journal, last = entries.at(-1), now = `${entries.length} ${last ? line(last, data.actions) : ""}`;
      if (now === shown && seen === store.entries) return;
      shown = now;
      // While a gesture goes on only its line changes: a new text of the whole would be laid out with every picture.
      if (entries.length === count && seen === store.entries && last) rows.lastChild.data = line(last, data.actions);
      else {
        count = entries.length;
        seen = store.entries;
        const lines = entries.map((action) => [document.createTextNode("\n"), document.createTextNode(line(action, data.actions))]).flat();
        rows.replaceChildren(...lines);
        list.scrollTop = list.scrollHeight;
      }
    };
  },
});
