"""One-joint arms under their laws, row by row, compiled: continuous feedback, sampled loops with real conditions."""

# pyright: reportMissingParameterType=false, reportUnknownVariableType=false, reportUnknownParameterType=false
# pyright: reportUnknownMemberType=false, reportUnknownArgumentType=false
from __future__ import annotations

import numpy as np

from mafsil.kernels.loops.loop import compiled

RUNAWAY = 1e6
"""Speed [rad/s] beyond which a run ends."""

MOST_STOPS = 200
"""Times that an arm may stop within one substep; beyond, the run ends as one that chatters."""

HALVINGS = 60
"""Of a substep in which the arm comes to rest."""


@compiled
def moving_friction(f, w, sign):
    """Friction of the numbers f = (static, kinetic, viscous, Stribeck speed, exponent) in motion of that sign."""
    dry = f[1]
    if f[3] > 0.0:
        dry += (f[0] - f[1]) * np.exp(-(abs(w / f[3]) ** f[4]))
    return dry * sign + f[2] * w


@compiled
def sign_of(x):
    """-1, 0 or 1."""
    return 1.0 if x > 0.0 else -1.0 if x < 0.0 else 0.0


@compiled
def model_torque(model, kind, q, w, u, v, a, feedback):
    """Torque of a law with a model (M, m g r, friction): the feedforward part, or computed torque."""
    if kind == 0:
        return feedback
    if kind == 3:
        # Dry friction by the sense that is wanted: by that of a measured speed it would chatter at rest.
        friction = moving_friction(model[2:], w, sign_of(v))
        return model[0] * (a + feedback) + model[1] * np.cos(q) + friction
    wanted = model[0] * a + model[1] * np.cos(u) + moving_friction(model[2:], v, sign_of(v))
    return wanted if kind == 1 else wanted + feedback


@compiled
def record(place, q, w, e, tau, p, i, d):
    """One tick into its place (7,)."""
    place[0], place[1], place[2], place[3] = q, w, e, tau
    place[4], place[5], place[6] = p, i, d


@compiled
def continuous_slope(arm, model, law, q, w, total, u, v, a):
    """Acceleration, error and torque of the loop without sampling; total is the integral of the error."""
    e = u - q
    feedback = law[1] * e + law[2] * total + law[3] * (v - w)
    tau = model_torque(model, law[0], q, w, u, v, a, feedback)
    return (tau - arm[1] * np.cos(q) - arm[4] * w) / arm[0], e, tau


@compiled
def run_continuous(arm, model, law, h, reference, start, out):
    """Runge-Kutta steps of order 4; the feedback is evaluated at every stage.

    Args:
        arm, model: (rows, 7) M, m g r, friction; the arm's friction viscous.
        law: (rows, 4) kind, kp, ki, kd.
        h: step [s].
        reference: (rows, 2 ticks - 1, 3) every half step.
        start: (rows, 2).
        out: (rows, ticks, 7) theta, speed, error, torque, and the P, I, D parts; NaN from where a run blows up.
    """
    for row in range(len(arm)):
        A, B, L, R = arm[row], model[row], law[row], reference[row]
        q, w, total = start[row, 0], start[row, 1], 0.0
        for k in range(out.shape[1]):
            u, v, a = R[2 * k, 0], R[2 * k, 1], R[2 * k, 2]
            a1, e1, tau = continuous_slope(A, B, L, q, w, total, u, v, a)
            record(out[row, k], q, w, e1, tau, L[1] * e1, L[2] * total, L[3] * (v - w))
            if not abs(w) < RUNAWAY:
                out[row, k:] = np.nan
                break
            if k + 1 == out.shape[1]:
                break
            u, v, a = R[2 * k + 1, 0], R[2 * k + 1, 1], R[2 * k + 1, 2]
            w2 = w + 0.5 * h * a1
            a2, e2, _ = continuous_slope(A, B, L, q + 0.5 * h * w, w2, total + 0.5 * h * e1, u, v, a)
            w3 = w + 0.5 * h * a2
            a3, e3, _ = continuous_slope(A, B, L, q + 0.5 * h * w2, w3, total + 0.5 * h * e2, u, v, a)
            u, v, a = R[2 * k + 2, 0], R[2 * k + 2, 1], R[2 * k + 2, 2]
            w4 = w + h * a3
            a4, e4, _ = continuous_slope(A, B, L, q + h * w3, w4, total + h * e3, u, v, a)
            q += h / 6.0 * (w + 2.0 * w2 + 2.0 * w3 + w4)
            total += h / 6.0 * (e1 + 2.0 * e2 + 2.0 * e3 + e4)
            w += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)


@compiled
def free_step(arm, q, w, tau, sign, h):
    """One Runge-Kutta step of the plant in motion of that sign."""
    a1 = (tau - arm[1] * np.cos(q) - moving_friction(arm[2:], w, sign)) / arm[0]
    w2 = w + 0.5 * h * a1
    a2 = (tau - arm[1] * np.cos(q + 0.5 * h * w) - moving_friction(arm[2:], w2, sign)) / arm[0]
    w3 = w + 0.5 * h * a2
    a3 = (tau - arm[1] * np.cos(q + 0.5 * h * w2) - moving_friction(arm[2:], w3, sign)) / arm[0]
    w4 = w + h * a3
    a4 = (tau - arm[1] * np.cos(q + h * w3) - moving_friction(arm[2:], w4, sign)) / arm[0]
    return q + h / 6.0 * (w + 2.0 * w2 + 2.0 * w3 + w4), w + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)


@compiled
def hold_period(arm, q, w, tau, h, substeps):
    """The plant over one period of constant torque, with stiction as the set-valued law that it is.

    Returns:
        Position and speed at the end; NaN if it stops and starts without end.
    """
    for _ in range(substeps):
        left, stops = h, 0
        while left > 0.0:
            # 1. At rest: what is applied must overcome the static friction, else the arm stays.
            load = tau - arm[1] * np.cos(q)
            if w == 0.0 and abs(load) <= arm[2]:
                return q, w
            sign = sign_of(w) if w != 0.0 else sign_of(load)
            q1, w1 = free_step(arm, q, w, tau, sign, left)
            # 2. No change of sense, or nothing dry that would notice: the step stands.
            if arm[2] == 0.0 or w1 * sign > 0.0:
                q, w, left = q1, w1, 0.0
                continue
            # 3. The arm stops within the step: halve to where it does, and ask again from rest.
            low, high = 0.0, 1.0
            for _ in range(HALVINGS):
                middle = 0.5 * (low + high)
                q1, w1 = free_step(arm, q, w, tau, sign, middle * left)
                if w1 * sign > 0.0:
                    low = middle
                else:
                    high = middle
            q, _ = free_step(arm, q, w, tau, sign, high * left)
            w, left, stops = 0.0, left * (1.0 - high), stops + 1
            if stops > MOST_STOPS:
                return np.nan, np.nan
    return q, w


@compiled
def run_sampled(arm, model, law, conditions, period, substeps, reference, start, out):
    """Loops in the order of the book's pseudo-code.

    1. Sense; the rate is differenced and filtered, or measured.
    2. The error's integral, then the torque of the law.
    3. Anti-windup where the torque is beyond its limit.
    4. Command, which acts after the delay, with the dither; the plant moves until the next period.

    Args:
        arm, model: (rows, 7) M, m g r, friction.
        law: (rows, 4) kind, kp, ki, kd.
        conditions: (rows, 9) torque limit, anti-windup (0 off, 1 hold, 2 back-calculation), tracking time, delay in
            periods, position quantum, filter coefficient, 1 for a tachometer, amplitude and frequency of a dither.
        period: of the loop [s].
        substeps: of the plant in each.
        reference: (rows, ticks, 3).
        start: (rows, 2).
        out: (rows, ticks, 7) as in `run_continuous`; the torque is the one that acts.
    """
    for row in range(len(arm)):
        A, B, L, C = arm[row], model[row], law[row], conditions[row]
        q, w = start[row, 0], start[row, 1]
        limit, delay = C[0], int(C[3])
        late = np.zeros(delay + 1)
        total, before, rate = 0.0, 0.0, 0.0
        scale = B[0] if L[0] == 3 else 1.0
        for k in range(out.shape[1]):
            u, v, a = reference[row, k, 0], reference[row, k, 1], reference[row, k, 2]
            # 1. Sense; the rate is differenced and filtered, or measured.
            seen = q if C[4] == 0.0 else C[4] * np.round(q / C[4])
            if C[6] > 0.0:
                rate = w
            elif k > 0:
                rate = C[5] * rate + (1.0 - C[5]) * (seen - before) / period
            before = seen
            # 2. The error's integral is updated before it is used.
            e = u - seen
            updated = total + e * period
            tau = model_torque(B, L[0], seen, rate, u, v, a, L[1] * e + L[2] * updated + L[3] * (v - rate))
            given = min(max(tau, -limit), limit)
            # 3. Anti-windup: nothing is added while it would drive the torque further beyond its limit, or what was
            #    cut off is led back.
            if C[1] == 1.0 and (tau - given) * e > 0.0:
                updated = total
                tau = model_torque(B, L[0], seen, rate, u, v, a, L[1] * e + L[2] * updated + L[3] * (v - rate))
                given = min(max(tau, -limit), limit)
            total = updated
            if C[1] == 2.0 and L[2] > 0.0:
                total += period * (given - tau) / (scale * L[2] * C[2])
            # 4. Command: it acts after the delay, with the dither.
            late[k % (delay + 1)] = given
            acting = late[(k - delay) % (delay + 1)] if k >= delay else 0.0
            acting += C[7] * np.sin(C[8] * k * period)
            record(out[row, k], q, w, u - q, acting, L[1] * e, L[2] * updated, L[3] * (v - rate))
            if not abs(w) < RUNAWAY:
                out[row, k:] = np.nan
                break
            q, w = hold_period(A, q, w, acting, period / substeps, substeps)
