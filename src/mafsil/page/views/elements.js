// Elements of the page: text becomes text nodes, so nothing in a name can become markup; numbers are isolated.

/**
 * An element.
 *
 * @param {string} tag
 * @param {Object<string, any>} attributes  `on...` functions listen; false and null are left out
 * @param {...(Node | string)} children
 * @returns {any}
 */
export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (value !== false && value !== null) made.setAttribute(name, value === true ? "" : value);
  }
  made.append(...children);
  return made;
}

/** A number, name or formula that keeps its direction in any sentence. */
export const isolated = (text, attributes = {}) => element("bdi", { dir: "ltr", ...attributes }, text);

/** A sentence of the page's language. @param {import("../core/words.js").Words} words */
export function sentence(words, key, values = {}) {
  const made = document.createDocumentFragment();
  for (const { text, foreign } of words.runs(key, values)) made.append(foreign && words.direction === "rtl" ? isolated(text) : text);
  return made;
}

/** An element of a drawing. @param {string} tag @param {Object<string, any>} attributes */
export function drawn(tag, attributes = {}) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
}

/** An element of mathematics, which reads from left to right in every language. */
function mathematics(tag, ...children) {
  const made = document.createElementNS("http://www.w3.org/1998/Math/MathML", tag);
  made.append(...children);
  return made;
}

/** A symbol with an index, such as J_b, and what follows it. @param {string} letter @param {string} index */
export function symbol(letter, index = "", after = "") {
  const base = mathematics("mi", letter), math = mathematics("math");
  math.setAttribute("dir", "ltr");
  math.append(index ? mathematics("msub", base, mathematics("mi", index)) : base);
  if (after) math.append(mathematics("mo", after));
  return math;
}

/**
 * A matrix in brackets, and a function that writes numbers into it.
 *
 * @param {number} rows @param {number} columns @param {Element[]} before
 * @param {{rows: string[], columns: string[]} | null} names  of rows and columns, which stand beside the numbers
 * @returns {{math: Element, write: (rows: number[][]) => void}}
 */
export function matrix(rows, columns, before = [], names = null) {
  const cells = Array.from({ length: rows }, () => Array.from({ length: columns }, () => mathematics("mn", "0")));
  const line = (list) => mathematics("mtr", ...list.map((cell) => mathematics("mtd", cell))), text = (word) => mathematics("mtext", word);
  const head = names ? [line(["", ...names.columns].map(text))] : [];
  const table = mathematics("mtable", ...head, ...cells.map((row, k) => line(names ? [text(names.rows[k]), ...row] : row)));
  const math = mathematics("math", ...before, mathematics("mrow", mathematics("mo", "["), table, mathematics("mo", "]")));
  math.setAttribute("dir", "ltr");
  const write = (values) => values.forEach((row, i) => row.forEach((value, j) => written(cells[i][j], number(value))));
  return { math, write };
}

/** Put a text where another stands, only if it is another. */
export function written(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

/** A number in a field: so many decimals, no minus before zero. */
export const decimals = (value, digits) => value.toFixed(digits).replace(/^-(?=[0.]*$)/, "");

/** A number for reading: four decimals, a true minus sign, no minus before zero. */
export function number(value, digits = 4) {
  if (!Number.isFinite(value)) return value === Infinity ? "∞" : value === -Infinity ? "−∞" : "–";
  return (Math.abs(value) >= 1e5 ? value.toExponential(3) : decimals(value, digits)).replace("-", "−");
}

/** Hand a text or a picture to the reader as a file; no request leaves the page. @param {string} name @param {string | Blob} text @param {string} type */
export function saveFile(name, text, type) {
  const link = element("a", { href: URL.createObjectURL(new Blob([text], { type })), download: name.replace(/[^\p{L}\p{N} ._-]+/gu, "_") });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.getAttribute("href")), 10_000);
}
