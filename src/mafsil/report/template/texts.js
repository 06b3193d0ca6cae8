// The texts of the other language: they wait in templates and change places with those that are shown.

export class Texts {
  /** @param {string} shown  the language that stands in the page */
  constructor(shown) {
    this.slots = [...document.querySelectorAll("[data-slot]")];
    this.kept = { [shown]: Object.fromEntries(this.slots.map((slot) => [slot.dataset.slot, [...slot.childNodes]])) };
    for (const { content, dataset } of document.querySelectorAll("template[data-language]"))
      this.kept[dataset.language] = Object.fromEntries([...content.children].map((part) => [part.dataset.for, [...part.childNodes]]));
  }

  /** @param {string} code  of the language */
  show(code) {
    for (const slot of this.slots) slot.replaceChildren(...this.kept[code][slot.dataset.slot]);
    for (const table of document.querySelectorAll(".wide > table")) nameCells(table);
  }
}

/** What stands above a column in each of its cells, for screens that are too narrow for columns. @param {HTMLTableElement} table */
function nameCells(table) {
  const heads = [...table.querySelectorAll("th")].map((head) => head.textContent);
  for (const row of table.querySelectorAll("tbody tr")) [...row.cells].forEach((cell, k) => { cell.dataset.head = heads[k] ?? ""; });
}
