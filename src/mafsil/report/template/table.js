// The numbers of all plots as a table for spreadsheets: columns named as in recording.csv, seven digits.
const DIGITS = 7; // what the page carries

// A column's name as a cell; quoted where a comma or a quotation mark would end it.
const cell = text => /[",\n\r]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
const figure = value => Number.isFinite(value) ? String(Number(value.toPrecision(DIGITS))) : Number.isNaN(value) ? "nan" : value > 0 ? "inf" : "-inf";

export function tableText(data, time, plots) {
  const heads = ["t", ...data.plots.flatMap(({ column, names, keys }) => keys.length ? keys.map(key => `${column}[${key}]`) : names.length ? [column] : data.joints.map(joint => `${column}[${joint}]`))];
  const lines = Array.from(time, (t, row) => [t, ...plots.flatMap(({ values, joints }) => Array.from(values.subarray(row * joints.length, (row + 1) * joints.length)))]);
  return [heads.map(cell), ...lines.map(line => line.map(figure))].map(line => line.join(",")).join("\n") + "\n";
}

// Hand a text to the reader as a file; no request leaves the page.
export function saveTable(name, text) {
  const link = document.createElement("a");
  link.setAttribute("href", URL.createObjectURL(new Blob([text], { type: "text/csv" })));
  link.setAttribute("download", name.replace(/[^\p{L}\p{N} ._-]+/gu, "_"));
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.getAttribute("href")), 10_000);
}
