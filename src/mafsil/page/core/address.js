// The state of a page as text that an address ends with: where the arm is, from where it is seen, what is open.

const SHARED_DIGITS = 7;
const listOf = (values) => values.map((value) => Number(Number(value).toPrecision(SHARED_DIGITS))).join(",");
const numbersOf = (text, count) => {
  const found = (text ?? "").split(",").map(Number);
  return text && found.every(Number.isFinite) && (!count || found.length === count) ? found : null;
};

/** What the page is to open with: what it was left with before a reload, else what its address says. */
export const wantedState = () => history.state?.kept || location.hash.slice(1);

/** @param {object} app */
export function stateText({ store, stage, words, tab }) {
  const { camera } = stage, { shown } = store, replay = shown.replay ?? shown.left;
  const fields = {
    q: listOf(store.state.q), camera: listOf([...camera.target, camera.azimuth, camera.elevation, camera.distance]), tab,
    language: words.chosen, units: `${shown.angle},${shown.length}`
  };
  if (shown.theme !== "system") fields.theme = shown.theme;
  if (shown.replay) delete fields.q;
  if (replay) fields.t = replay.time.toFixed(3);
  return new URLSearchParams(fields).toString();
}

/**
 * Bring a page to what a text says; what is not understood there is left out.
 *
 * @param {string} text
 * @param {object} app
 */
export function takeState(text, app) {
  const given = new URLSearchParams(text), { store, stage, words, data } = app, { n } = store.arm.settings;
  const [angle, length] = (given.get("units") ?? "").split(",");
  if (["rad", "deg"].includes(angle)) store.shown.angle = angle;
  if (["m", "mm"].includes(length)) store.shown.length = length;
  if (["light", "dark"].includes(given.get("theme"))) store.shown.theme = given.get("theme");
  if (given.get("language") in data.languages) words.chosen = given.get("language");
  if (app.tabs.includes(given.get("tab"))) app.tab = given.get("tab");
  const q = numbersOf(given.get("q"), n), camera = numbersOf(given.get("camera"), 6);
  if (q && !app.link && listOf(store.state.q) !== listOf(q)) store.do("set_joints", { values: q });
  if (!camera) return;
  stage.framed = false;
  Object.assign(stage.camera, { target: camera.slice(0, 3), distance: Math.max(1e-3, camera[5]) });
  stage.camera.look(camera[3], camera[4]);
}
