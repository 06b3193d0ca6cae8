// Poses found by damped steps, from where the arm is and then from other starts: a search says found or not found.

import { hereOf, lifted, partOf, placed } from "../core/state.js";

const square = (v, k) => v[k] * v[k] + v[k + 1] * v[k + 1] + v[k + 2] * v[k + 2];

/**
 * @param {import("../core/state.js").State} state
 * @param {number[]} T
 * @param {import("../core/state.js").Arm} arm
 * @returns {import("../core/state.js").State}
 */
export function searched(state, T, { settings, kernels }) {
  const m = settings.places.length, limit = settings.tolerance * settings.tolerance;
  const task = settings.task.map((value, k) => value ?? (k < 9 + m ? -Infinity : Infinity));
  for (let attempt = 0; attempt < settings.attempts; attempt++) {
    let q = startOf(state, attempt, settings);
    for (let step = 0; step < settings.steps; step++) {
      const [out] = kernels.pose_step(q, T, task); // the next coordinates, then turn and shift that are left at q
      if (!out.every(Number.isFinite)) break;
      const turned = !settings.rotates || square(out, m) <= limit;
      if (turned && square(out, m + 3) <= limit)
        return placed(state, lifted(settings, hereOf(state), q), "solved");
      q = Array.from(out.subarray(0, m));
    }
  }
  const values = { attempts: settings.attempts, steps: settings.steps };
  return { ...state, status: "not_found", reason: { key: "why_not_found", values } };
}

/** Where a search begins: here, then places that fill the ranges evenly. */
function startOf(state, attempt, settings) {
  if (attempt === 0) return partOf(settings, hereOf(state));
  return settings.starts.map(([lower, span], k) => lower + span * ((attempt * settings.ratios[k]) % 1));
}
