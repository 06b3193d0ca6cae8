// The closed loop: computed torque leads the arm to its goal while something pushes the tip.

/**
 * @param {import("../core/state.js").State} state
 * @param {number} ticks  steps of the control law
 * @param {import("../core/state.js").Arm} arm
 * @returns {import("../core/state.js").State}
 */
export function simulated(state, ticks, { settings, kernels }) {
  const n = settings.n, rest = new Array(n).fill(0);
  const desired = Array.from(kernels.forward_kinematics(state.goal)[0]), reference = [...state.goal, ...rest, ...rest];
  const effort = settings.effort.map((value) => value ?? Infinity), step = [settings.step];
  let now = [...state.q, ...state.qd];
  for (let tick = 0; tick < ticks; tick++)
    now = kernels.closed_loop(now, reference, settings.gains, step, desired, effort, state.push)[0].slice();
  now = Array.from(now);
  if (!now.every(Number.isFinite)) return { ...state, status: "diverged", reason: { key: "why_diverged", values: {} } };
  return { ...state, q: now.slice(0, n), qd: now.slice(n), ticks: state.ticks + ticks, status: "ready", reason: null };
}
