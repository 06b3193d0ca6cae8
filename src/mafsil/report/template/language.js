// The texts of the other language: they wait in templates and change places with those that are shown.
class Languages {
  constructor(data, changed) {
    Object.assign(this, { data, changed, codes: Object.keys(data.languages), shown: document.documentElement.lang });
    this.slots = [...document.querySelectorAll("[data-slot]")];
    this.texts = { [this.shown]: Object.fromEntries(this.slots.map(slot => [slot.dataset.slot, [...slot.childNodes]])) };
    for (const kept of document.querySelectorAll("template[data-language]"))
      this.texts[kept.dataset.language] = Object.fromEntries([...kept.content.children].map(part => [part.dataset.for, [...part.childNodes]]));
    this.button = document.getElementById("language");
    this.button.hidden = this.codes.length < 2;
    this.button.addEventListener("click", () => this.speak(this.next()));
    this.name();
  }
  next() { return this.codes[(this.codes.indexOf(this.shown) + 1) % this.codes.length]; }
  // The button bears the name of the language that it leads to, in that language.
  name() {
    this.button.textContent = this.data.labels.other_language;
    this.button.lang = this.next();
  }
  speak(code) {
    const { data } = this, words = data.languages[code], page = document.documentElement;
    this.shown = page.lang = code;
    page.dir = words.direction;
    document.title = words.title;
    for (const slot of this.slots) slot.replaceChildren(...this.texts[code][slot.dataset.slot]);
    for (const node of document.querySelectorAll("[data-say]")) node.textContent = words.labels[node.dataset.say];
    for (const node of document.querySelectorAll("[data-label]")) node.setAttribute("aria-label", words.labels[node.dataset.label]);
    Object.assign(data.labels, words.labels);
    data.moves.forEach((move, k) => { move.name = words.moves[k]; });
    this.name();
    this.changed(words);
  }
}
