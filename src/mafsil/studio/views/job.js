// The job: its text, which all windows share, what is wrong with it, the run with its progress, and what came of it.

import { view } from "page/core/views.js";
import { element, isolated, sentence } from "page/views/elements.js";

const TYPING = 300; // ms after the last key before the text is sent

view({
  name: "job",
  tab: "job",
  order: 70,
  open: true,
  mount(place, app) {
    const { link, words, store } = app, send = (path, body = {}) => link.transport.send(path, body);
    const text = element(
      "textarea",
      { id: "job", dir: "ltr", rows: 16, wrap: "off", spellcheck: "false", autocomplete: "off", "aria-label": words.text("view_job"), oninput: () => written() }
    );
    const wrong = element(
      "p", { id: "job-wrong", class: "wrong", role: "alert" }
    ), note = element("span", { class: "soft", role: "status" }), doubts = element("ul", { class: "findings", id: "job-doubts" });
    const bar = element(
      "progress", { id: "job-progress", max: 1, "aria-label": words.text("run_share") }
    ), outcome = element("div", { id: "job-outcome", role: "status" });
    const button = (key, act, id) => element("button", { type: "button", class: "quiet", id, onclick: act }, sentence(words, key));
    const run = element("button", { type: "button", class: "strong", id: "job-run", onclick: () => begin() }, sentence(words, "run"));
    const stop = button("stop", () => send("job/stop"), "job-stop"), save = button("save_job", () => keep(), "job-save");
    place.append(
      element("p", { class: "soft" }, sentence(words, "job_about")), text, wrong, element("div", { role: "status" }, doubts),
      element("div", { class: "buttons" }, run, stop, save, note), bar, outcome
    );
    let timer = 0, seen = null, told = null;

    function written() {
      clearTimeout(timer);
      timer = setTimeout(deliver, TYPING);
    }
    /** The text goes to the server, if it is not there yet. */
    async function deliver() {
      clearTimeout(timer);
      timer = 0;
      if (text.value !== link.heard.get("job")?.text) complain(await send("job", { text: text.value, window: link.window }));
    }
    async function begin() {
      note.replaceChildren();
      await deliver();
      link.heard.delete("motion");
      link.watch = { motion: null, begun: false, told: false };
      const answer = await send("job/run");
      if (answer.status !== 200) link.watch = null;
      complain(answer);
    }
    async function keep() {
      await deliver();
      const answer = await send("job/save");
      complain(answer);
      if (answer.status === 200) note.replaceChildren(sentence(words, "saved", { file: answer.data.file }));
    }
    function complain({ status, data }) {
      if (status !== 200) note.replaceChildren(words.isolated(data.error));
    }
    /** What another window wrote comes in here, unless somebody writes here just now. */
    function takeJob(job) {
      if (job.window !== link.window && !timer && text.value !== job.text) text.value = job.text;
      if (!seen) text.value = job.text;
      save.hidden = !job.file;
      paintWrong(wrong, job.wrong, words, text);
      doubts.replaceChildren(...(job.remarks ?? []).map((one) => element(
        "li", { class: "warning" }, words.isolated(one.sentence), ...lineButton(one.line, words, text)
      )));
      run.disabled = Boolean(job.wrong) || link.heard.get("run")?.status === "running";
    }
    function takeRun(now) {
      const running = now.status === "running";
      bar.hidden = stop.hidden = !running;
      run.disabled = running || Boolean(link.heard.get("job")?.wrong);
      if (running) bar.value = now.share;
      outcome.replaceChildren(...result(now, words, text, (number) => {
        document.getElementById("view-recordings").open = true;
        store.show({ chosen: [number, null], plays: true });
      }));
    }
    const update = () => {
      const job = link.heard.get("job"), state = link.heard.get("run");
      if (job && job !== seen) { takeJob(job); seen = job; }
      if (state && state !== told) takeRun(told = state);
    };
    update();
    return update;
  },
});

/** What is wrong with the text; a click goes to the line. */
function paintWrong(place, wrong, words, text) {
  place.replaceChildren();
  text.style.setProperty("--line", wrong?.line ?? 0);
  text.setAttribute("aria-invalid", String(Boolean(wrong)));
  place.hidden = !wrong;
  if (!wrong) return;
  place.append(words.isolated(wrong.sentence));
  place.append(...lineButton(wrong.line, words, text));
}

/** A button that leads to a line of the text, where one is known. */
function lineButton(line, words, text) {
  return line ? [
    " ",
    element("button", { type: "button", class: "quiet", "data-line": line, onclick: () => goTo(text, line) }, sentence(words, "to_line", { line }))
  ] : [];
}

/** The caret to a line, counted from one. */
function goTo(text, line) {
  const lines = text.value.split("\n"), begin = lines.slice(0, line - 1).join("\n").length + (line > 1 ? 1 : 0);
  text.focus();
  text.setSelectionRange(begin, begin + (lines[line - 1] ?? "").length);
  text.scrollTop = Math.max(0, (line - 4) / lines.length * text.scrollHeight);
}

/** How the run goes or ended: a sentence, findings, report and recording. */
function result(run, words, text, replay) {
  if (run.status === "none") return [];
  if (run.status === "running") return [element("p", { class: "soft" }, sentence(words, run.stage))];
  if (run.status === "stopped") return [element("p", {}, sentence(words, "run_stopped"))];
  const first = element("p", { class: run.status === "done" ? "good" : "wrong" }, words.isolated(run.sentence));
  first.append(...lineButton(run.line, words, text));
  const made = [first];
  if (run.findings?.length) made.push(element(
    "ul", { class: "findings" }, ...run.findings.map((one) => element("li", { class: one.level }, words.isolated(one)))
  ));
  if (run.more) made.push(element("p", { class: "soft" }, sentence(words, "more_findings", { count: run.more })));
  if (run.recording) {
    const report = element("a", { href: `reports/${run.recording}/report.html`, target: "_blank", rel: "noopener", id: "report" }, sentence(words, "report"));
    made.push(element(
      "div", { class: "buttons" }, report,
      element("button", { type: "button", class: "quiet", onclick: () => replay(run.recording) }, sentence(words, "replay"))
    ));
  }
  return made;
}
