// A recorded motion: where it has the arm at a time, how it goes on while it plays, and how one comes back to it.

/**
 * @typedef {{t: ArrayLike<number>, q: ArrayLike<number>[], live?: boolean, duration?: number}} Tape  times [s] and
 *   coordinates; live: more of them come, up to the duration
 * @typedef {{first: Tape, second: Tape | null, time: number, playing: boolean, speed?: number, since?: number,
 *            q?: number[], ghost?: number[] | null}} Replay
 *   first: of the arm; second: of a ghost beside it; since: when the last picture was made [ms]; q, ghost: coordinates
 */

const LONGEST = 0.25; // s that pass with one picture: a page that was away does not jump

/** Duration of a tape [s]. @param {Tape} tape */
export const lengthOf = ({ t }) => t[t.length - 1];

/** Coordinates at a time, on straight lines. @param {Tape} tape @param {number} time */
export function between({ t, q }, time) {
  let low = 0, high = t.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (t[middle] <= time) low = middle;
    else high = middle;
  }
  const span = t[high] - t[low], share = span > 0 ? Math.min(1, Math.max(0, (time - t[low]) / span)) : 0;
  return Array.from(q[low], (value, k) => value + share * (q[high][k] - value));
}

/** A replay with the arm and the ghost where they were at its time. @param {Replay} replay */
export function posed(replay) {
  const { first, second, time } = replay;
  return Object.assign(replay, { q: between(first, time), ghost: second ? between(second, Math.min(time, lengthOf(second))) : null });
}

/** Play, from the beginning where the end was reached; or pause. @param {import("./store.js").Store} store @param {boolean} on */
export function play(store, on) {
  const replay = store.shown.replay ?? store.shown.left;
  if (!replay) return;
  const time = on && replay.time >= lengthOf(replay.first) ? 0 : replay.time;
  store.show({ replay: posed({ ...replay, time, playing: on, since: 0 }), left: null });
}

/** Go to a time and stay there; also from where the arm was led to since. @param {import("./store.js").Store} store */
export function seek(store, time) {
  const replay = store.shown.replay ?? store.shown.left;
  if (replay) store.show({ replay: posed({ ...replay, time, playing: false }), left: null });
}

/**
 * Let the replay go on as fast as time passes, and put the arm and the ghost where they were.
 *
 * @param {import("./store.js").Store} store
 * @param {number} now  [ms]
 * @returns {boolean}  whether there is more to come
 */
export function goOn({ shown: { replay } }, now) {
  if (!replay) return false;
  const end = lengthOf(replay.first);
  if (replay.playing) {
    if (replay.since) replay.time = Math.min(end, replay.time + Math.min(LONGEST, (now - replay.since) / 1000) * (replay.speed ?? 1));
    replay.since = now;
    replay.playing = replay.time < end || Boolean(replay.first.live);
  }
  posed(replay);
  return replay.playing;
}
