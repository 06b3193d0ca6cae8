// Judges an answer by the forms that the page carries, and reads it by the grammar that mafsil/typed_number.py gives it.

/** The numbers of a text, or null if it cannot be read. */
export function numbersOf(part, typed, rules) {
  let text = [...typed].map((sign) => rules.western[sign] ?? sign).join("").trim().toLowerCase();
  if (part.choice && text in rules.choices) return [rules.choices[text]];
  if (part.unit && !(part.unit in rules.factors)) text = text.replaceAll(part.unit.toLowerCase(), " ");
  const words = text.replace(new RegExp(rules.loose, "g"), (_, sign) => sign ?? "").split(new RegExp(rules.between)).filter(Boolean);
  const numbers = words.map((word) => readNumber(part, word, rules));
  return numbers.includes(null) ? null : numbers;
}

function readNumber(part, word, rules) {
  const found = word.match(new RegExp(`^(?:${rules.number})$`, "i"));
  const factors = { ...rules.factors[part.unit], ...(part.turns.includes(1) ? rules.factors.rad : {}) };
  if (!found || (!found[2] && !found[3]) || (found[5] && !(found[5] in factors)) || (found[4] && !Number(found[4]))) return null;
  const size = ((Number(found[2]?.replaceAll("_", "") ?? 1) * (found[3] ? Math.PI : 1)) / Number(found[4] ?? 1)) * (found[5] ? factors[found[5]] : 1);
  return Number.isFinite(size) ? (found[1] === "-" ? -size : size) : null;
}

function likeEntries(part, turns, given, form, rules) {
  const length = Math.max(1e-6, ...form.filter((_, k) => !turns[k]).map(Math.abs));
  return given.map((value, k) => {
    const turn = 2 * Math.PI, apart = value - form[k];
    const around = turns[k] ? ((((apart + Math.PI) % turn) + turn) % turn) - Math.PI : apart;
    return Math.abs(around) <= (part.exact ? 1e-9 : rules.near * (turns[k] ? Math.max(Math.abs(form[k]) / Math.PI, 1) : length));
  });
}

function knownRows(part, given, form, rules) {
  const width = part.turns.length / part.rows, found = [];
  const cut = (flat) => (flat.length % width ? [] : Array.from({ length: flat.length / width }, (_, k) => flat.slice(k * width, (k + 1) * width)));
  for (const row of cut(given)) {
    const at = cut(form).findIndex((right, k) => !found.includes(k) && likeEntries(part, part.turns.slice(0, width), row, right, rules).every(Boolean));
    if (at >= 0) found.push(at);
  }
  return found.length;
}

function matches(part, given, form, rules) {
  if (given.length !== form.length) return false;
  return part.rows ? knownRows(part, given, form, rules) === part.rows : likeEntries(part, part.turns, given, form, rules).every(Boolean);
}

/** The name of the mistake, "" if there is none, and its place. */
export function judge(part, given, rules) {
  if (!given.length) return ["empty", ""];
  if (part.forms.some((form) => matches(part, given, form, rules))) return ["", ""];
  const named = part.mistakes.find(([, form]) => matches(part, given, form, rules));
  if (named) return [named[0], ""];
  const size = part.turns.length;
  if (part.rows) {
    const known = knownRows(part, given, part.forms[0], rules);
    return (size / part.rows) * known === given.length ? ["missed", String(part.rows - known)] : [known ? "solution" : "other", ""];
  }
  if (given.length !== size) return ["count", String(size)];
  const counts = part.forms.map((form) => likeEntries(part, part.turns, given, form, rules));
  const total = (like) => like.filter(Boolean).length;
  const best = counts.reduce((a, b, k) => (total(b) > total(counts[a]) ? k : a), 0);
  const wrong = counts[best].flatMap((right, k) => (right ? [] : [k]));
  if (wrong.length === size || wrong.length > Math.max(1, Math.floor(size / 2))) return ["other", ""];
  const flipped = likeEntries(part, part.turns, given.map((value) => -value), part.forms[best], rules);
  return [wrong.every((k) => flipped[k]) ? "sign" : "entries", wrong.map((k) => k + 1).join(", ")];
}
