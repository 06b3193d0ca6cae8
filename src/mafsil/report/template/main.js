// Ties the page together: one clock drives the replay, the slider and the cursors of all plots.
const data = JSON.parse(document.getElementById("data").textContent), by = id => document.getElementById(id);
const last = data.duration || 1e-9, clock = { t: 0, playing: false, speed: 1, since: 0 };
let replay = null;
try { replay = new Replay(by("scene"), data.scene); } catch (reason) { by("no-scene").hidden = false; by("scene").hidden = true; by("hint").hidden = true; console.warn(String(reason)); }

const time = unpack(data.time);
const plots = data.plots.map(plot => new Plot(by("plots"), { ...plot, bands: data.moves.map(m => [m.from, m.to]) }, time, plot.names.length ? plot.names : data.joints, data.labels, seek));
const ofJoints = plots.filter((plot, k) => !data.plots[k].names.length);
const marks = data.moves.map(move => {
  const mark = element("i", "", by("moves"));
  mark.title = move.name;
  mark.style.left = `${100 * move.from / last}%`;
  mark.style.width = `calc(${100 * (move.to - move.from) / last}% - 2px)`;
  return mark;
});

function seek(t) {
  clock.t = Math.max(0, Math.min(last, t));
  by("time").value = clock.t / last;
  by("clock").textContent = `${clock.t.toFixed(2)} s`;
  const active = data.moves.findLastIndex(m => m.from <= clock.t);
  marks.forEach((mark, k) => mark.classList.toggle("on", k === active));
  by("move-name").textContent = active < 0 ? "" : data.moves[active].name;
  if (replay) replay.show(clock.t / data.scene.period);
  plots.forEach(plot => plot.mark(clock.t));
}
function play(on) {
  clock.playing = on;
  by("play").classList.toggle("on", on);
  by("play").setAttribute("aria-label", on ? data.labels.pause : data.labels.play);
  by("play").title = on ? data.labels.pause : data.labels.play;
  clock.since = performance.now();
  if (on) requestAnimationFrame(tick);
}
function tick(now) {
  if (!clock.playing) return;
  const t = clock.t + Math.min(0.1, (now - clock.since) / 1000) * clock.speed;
  clock.since = now;
  seek(t);
  if (t >= last) play(false);
  else requestAnimationFrame(tick);
}
by("play").addEventListener("click", () => { if (!clock.playing && clock.t >= last - 1e-6) seek(0); play(!clock.playing); });
by("time").addEventListener("input", e => { play(false); seek(e.target.value * last); });
by("speed").addEventListener("change", e => { clock.speed = Number(e.target.value); });
by("show-path").addEventListener("change", e => { if (replay) { replay.showPath = e.target.checked; replay.changed(); } });
by("show-frames").addEventListener("change", e => { if (replay) { replay.showFrames = e.target.checked; replay.changed(); } });
by("view").addEventListener("click", () => replay && replay.home());
document.addEventListener("keydown", e => { if (e.key === " " && !/^(BUTTON|INPUT|SELECT|SUMMARY)$/.test(e.target.tagName)) { e.preventDefault(); by("play").click(); } });

// The legend belongs to all plots of joints: hover brings one joint forward with its limits, click hides it.
const hidden = new Set();
data.joints.forEach((name, j) => {
  const button = element("button", "", by("legend"));
  button.type = "button";
  button.setAttribute("aria-pressed", true);
  element("i", "", button).style.background = `var(--s${j % 8})`;
  element("span", "", button, name);
  const choose = chosen => ofJoints.forEach(plot => { plot.chosen = chosen; plot.draw(); });
  button.addEventListener("pointerenter", () => { if (!hidden.has(j)) choose(j); });
  button.addEventListener("pointerleave", () => choose(null));
  button.addEventListener("click", () => {
    if (!hidden.delete(j)) hidden.add(j);
    button.setAttribute("aria-pressed", !hidden.has(j));
    ofJoints.forEach(plot => { plot.hidden = hidden; plot.chosen = null; plot.draw(); });
  });
});
addEventListener("beforeprint", () => plots.forEach(plot => plot.draw()));
const moment = /^#t=([0-9.]+)$/.exec(location.hash);
seek(moment ? Number(moment[1]) : 0);
if (!moment && !matchMedia("(prefers-reduced-motion: reduce)").matches && replay) play(true);
