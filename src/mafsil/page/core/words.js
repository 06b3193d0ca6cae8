// The page's sentences in its languages. Numbers, names and formulas inside them come isolated from Python, by the
// function that all of mafsil uses; values are put into the isolates here.

/**
 * @typedef {{text: string, foreign: boolean}} Run
 * @typedef {{direction: "ltr" | "rtl", sentences: Object<string, (string | [string])[]>}} Language  foreign runs in lists
 */

export class Words {
  /** @param {Object<string, Language>} languages @param {string} chosen */
  constructor(languages, chosen) {
    this.languages = languages;
    this.chosen = chosen;
  }

  get direction() {
    return this.languages[this.chosen].direction;
  }

  /**
   * A sentence in runs; values without a place in it are left out.
   *
   * @param {string} key
   * @param {Object<string, string | number>} values
   * @returns {Run[]}
   */
  runs(key, values = {}) {
    const runs = this.languages[this.chosen].sentences[key];
    if (!runs) throw new RangeError(`no sentence is called ${key}`);
    return runs.map((run) => ({ foreign: Array.isArray(run), text: filled(String(run), values) }));
  }

  /** The same as one text, for attributes and for what is written anew with every frame. */
  text(key, values = {}) {
    return this.runs(key, values).map((run) => (run.foreign ? this.isolate(run.text) : run.text)).join("");
  }

  /** The words of this language among those of all, as when the server says something. @param {Object<string, string>} all */
  isolated(all) {
    const text = all[this.chosen] ?? all.code ?? "";
    return this.direction === "rtl" ? `\u2067${text}\u2069` : text;
  }

  /** A number, name or formula that keeps its direction in a text of this language. @param {string} text */
  isolate(text) {
    return this.direction === "rtl" ? `\u2066${text}\u2069` : text;
  }
}

function filled(text, values) {
  return text.replace(/\{(\w+)\}/g, (whole, name) => (name in values ? String(values[name]) : whole));
}
