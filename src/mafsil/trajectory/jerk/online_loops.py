"""Jerk-limited plans as they are used, compiled: batches in one call, values at times, and the state of each cycle."""

from __future__ import annotations

from math import inf, isfinite

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.kernels.loops.loop import compiled
from mafsil.trajectory.jerk.coordinate_loops import PIECES
from mafsil.trajectory.jerk.plan_loops import PLANNED, TIME, is_frozen, is_outside, next_of, plan, stays
from mafsil.trajectory.jerk.rest_loops import at_rest, plan_rest, rest_curves

CANCELLED = 1e-15
"""Share of the largest acceleration so far below which one is zero: what jerks leave there is rounding, which a long
wait would multiply by the square of its duration."""
ROUNDED_TIME = 4e-16
"""Share of a time by which it may be off: so near to the end of a piece is its end."""
ELAPSED, DURATION, CYCLE, PLANS, FREE, STATUS, RULING = range(7)
"""Places of the clock's numbers."""


@compiled
def step(
    now: Floats,
    asked: Floats,
    free: bool,
    mode: int,
    clock: Floats,
    last: Floats,
    states: Floats,
    limits: Floats,
    scratch: Floats,
    count: Floats,
    pieces: Floats,
) -> int:
    """Move on by one cycle.

    1. Numbers that are not finite: nothing is done.
    2. A new goal, or a state that is not what the plan made of it, asks for a new plan.
    3. The state after one cycle; after its end the motion goes on with the goal's velocity.

    Args:
        now: (n, 3) position, velocity and acceleration; the next ones are written here.
        asked: (n, 2) position and velocity of the goal.
        free: whether the goal's position does not matter.
        mode: synchronisation, as in `plan`.
        clock: (7,) time since the plan, its duration, the cycle, number of plans, whether the plan's goal has no
            position, how the last planning ended and which coordinate that is due to.
        last: (n, 3) what `now` was when the last cycle ended.
        states: (2, n, 6) the problem of the present plan, and one to try.
        limits: (n, 6).
        scratch: (6, 7) to work in.
        count: (2, n) numbers of pieces, of the present plan and of one to try.
        pieces: (2, 2, n, 15) their durations and jerks.

    Returns:
        How planning ended; after a refusal the present plan goes on. -1 if a number is not finite: nothing is done.
    """
    # 1.
    n = len(now)
    for i in range(n):
        if not isfinite(asked[i, 0] + asked[i, 1] + now[i, 0] + now[i, 1] + now[i, 2]):
            return -1
    # 2.
    changed = clock[PLANS] == 0.0 or (clock[FREE] != 0.0) != free
    for i in range(n):
        changed |= asked[i, 1] != states[1, i, 4] or (not free and asked[i, 0] != states[1, i, 3])
        changed |= now[i, 0] != last[i, 0] or now[i, 1] != last[i, 1] or now[i, 2] != last[i, 2]
    if changed:
        _replan(now, asked, free, mode, clock, states, limits, scratch, count, pieces)
    # 3.
    clock[ELAPSED] += clock[CYCLE]
    for i in range(n):
        now[i, 0], now[i, 1], now[i, 2] = _state_at(states[0, i], count[0, i], pieces[0, :, i], clock[ELAPSED])
        last[i, 0], last[i, 1], last[i, 2] = now[i, 0], now[i, 1], now[i, 2]
    return int(clock[STATUS])


@compiled
def _replan(
    now: Floats,
    asked: Floats,
    free: bool,
    mode: int,
    clock: Floats,
    states: Floats,
    limits: Floats,
    scratch: Floats,
    count: Floats,
    pieces: Floats,
) -> None:
    """Try a plan from the present state, and take it if there is one; without any, rest where the state is."""
    n = len(now)
    for i in range(n):
        states[1, i, 0], states[1, i, 1], states[1, i, 2] = now[i, 0], now[i, 1], now[i, 2]
        states[1, i, 3], states[1, i, 4], states[1, i, 5] = asked[i, 0], asked[i, 1], 0.0
    status, ruling, _, duration = plan(
        states[1], limits, free, mode, 0.0, 0.0, scratch, count[1], pieces[1, 0], pieces[1, 1]
    )
    clock[STATUS], clock[RULING] = status, ruling
    if status == PLANNED:
        clock[ELAPSED], clock[DURATION], clock[FREE] = 0.0, duration, 1.0 if free else 0.0
        clock[PLANS] += 1.0
        states[0], count[0], pieces[0] = states[1], count[1], pieces[1]


@compiled
def _state_at(x: Floats, count: float, pieces: Floats, t: float) -> tuple[float, float, float]:
    """A coordinate's state at a time of its plan."""
    p, v, a = x[0], x[1], x[2]
    for k in range(int(count)):
        if t < pieces[0, k]:
            return advance(p, v, a, pieces[1, k], t)
        p, v, a = advance(p, v, a, pieces[1, k], pieces[0, k])
        t -= pieces[0, k]
    return p + t * v, v, a


@compiled
def advance(p: float, v: float, a: float, j: float, t: float) -> tuple[float, float, float]:
    """The state after a time of constant jerk.

    Args:
        p, v, a: position, velocity, acceleration before.
        j: jerk.
        t: time [s].
    """
    return p + t * (v + t * (0.5 * a + t * j * (1.0 / 6.0))), v + t * (a + 0.5 * t * j), a + t * j


@compiled
def sample_rows(
    first: Floats, count: Floats, times: Floats, jerks: Floats, t: Floats, u: Floats, v: Floats, a: Floats, j: Floats
) -> None:
    """States of many coordinates at the same times, or at times of their own.

    Args:
        first: (rows, n, 6) of which p0, v0, a0 are used.
        count, times, jerks: (rows, n), (rows, n, pieces), (rows, n, pieces).
        t: (k, rows) times, not below zero, ascending in k for speed; beyond the last piece its end is held.
        u, v, a, j: (k, rows, n) written here.
    """
    for row in range(first.shape[0]):
        for i in range(first.shape[1]):
            pieces = int(count[row, i])
            piece, begin, most = 0, 0.0, 0.0
            p0, v0, a0 = first[row, i, 0], first[row, i, 1], first[row, i, 2]
            for k in range(len(t)):
                moment = t[k, row]
                if moment < begin:
                    piece, begin, most = 0, 0.0, 0.0
                    p0, v0, a0 = first[row, i, 0], first[row, i, 1], first[row, i, 2]
                while piece < pieces - 1 and moment >= begin + times[row, i, piece]:
                    most = max(most, abs(a0))
                    p0, v0, a0 = advance(p0, v0, a0, jerks[row, i, piece], times[row, i, piece])
                    if abs(a0) <= CANCELLED * most:
                        a0 = 0.0
                    begin += times[row, i, piece]
                    piece += 1
                local, jerk = moment - begin, 0.0
                if pieces > 0:
                    jerk = jerks[row, i, piece]
                    if local >= times[row, i, piece] - ROUNDED_TIME * moment:
                        local = times[row, i, piece]
                u[k, row, i], v[k, row, i], a[k, row, i] = advance(p0, v0, a0, jerk, local)
                j[k, row, i] = jerk


@compiled
def largest_rows(first: Floats, count: Floats, times: Floats, jerks: Floats, largest: Floats) -> None:
    """The largest sizes of position, velocity and acceleration where pieces begin and end.

    Args:
        first: (rows, n, 6) of which p0, v0, a0 are used.
        count, times, jerks: (rows, n), (rows, n, pieces), (rows, n, pieces).
        largest: (rows, n, 3) written here.
    """
    for row in range(first.shape[0]):
        for i in range(first.shape[1]):
            p, v, a = first[row, i, 0], first[row, i, 1], first[row, i, 2]
            most_p, most_v, most_a = abs(p), abs(v), abs(a)
            for piece in range(int(count[row, i])):
                p, v, a = advance(p, v, a, jerks[row, i, piece], times[row, i, piece])
                if abs(a) <= CANCELLED * most_a:
                    a = 0.0
                most_p, most_v, most_a = max(most_p, abs(p)), max(most_v, abs(v)), max(most_a, abs(a))
            largest[row, i, 0], largest[row, i, 1], largest[row, i, 2] = most_p, most_v, most_a


@compiled
def evaluate(
    knots: Floats, coefficients: Floats, t: float, piece: int, u_out: Floats, v_out: Floats, a_out: Floats
) -> int:
    """Position, velocity and acceleration at a time; the index of its piece, -1 at rest outside.

    1. The next piece when one has ended (half-open: its start belongs to it); a time that goes back starts anew.
    2. Horner's rule with the local time t - T_k, which is never reset to zero.
    3. Before the start and after the end: hold the position, rates zero.

    Args:
        knots: (pieces + 1,) [s].
        coefficients: (pieces, degree + 1, n) ascending.
        t: [s].
        piece: where to look first, that of the tick before.
        u_out, v_out, a_out: (n,) written.
    """
    pieces, terms, n = coefficients.shape
    # 1
    if piece < 0 or piece >= pieces or t < knots[piece]:
        piece = 0
    while piece < pieces - 1 and t >= knots[piece + 1]:
        piece += 1
    # 2
    end = knots[pieces]
    local = min(max(t, 0.0), end) - knots[piece]
    for i in range(n):
        u = v = a = 0.0
        for k in range(terms - 1, -1, -1):
            a = a * local + 2.0 * v
            v = v * local + u
            u = u * local + coefficients[piece, k, i]
        u_out[i], v_out[i], a_out[i] = u, v, a
    # 3
    if t < 0.0 or t > end:
        for i in range(n):
            v_out[i] = 0.0
            a_out[i] = 0.0
        return -1
    return piece


@compiled
def sample_pieces(rows: Floats, piece: NDArray[np.int64], local: Floats, u: Floats, v: Floats, a: Floats) -> None:
    """Position, velocity and acceleration at many times, by Horner's rule for each.

    Args:
        rows: (pieces, degree + 1, 3, n) ascending coefficients of the motion and of its two derivatives.
        piece, local: (k,) index of the piece of each time, and the time since it began [s].
        u, v, a: (k, n) written here.
    """
    for k in range(len(local)):
        p, t = piece[k], local[k]
        for i in range(rows.shape[3]):
            x = dx = ddx = 0.0
            for power in range(rows.shape[1] - 1, -1, -1):
                x = x * t + rows[p, power, 0, i]
                dx = dx * t + rows[p, power, 1, i]
                ddx = ddx * t + rows[p, power, 2, i]
            u[k, i], v[k, i], a[k, i] = x, dx, ddx


@compiled
def own_durations(states: Floats, limits: Floats, free: bool, own: Floats) -> None:
    """The shortest duration of each coordinate, as if it were alone; infinite if it has none.

    Args:
        states: (rows, n, 6).
        limits: (n, 6).
        free: whether displacements do not matter.
        own: (rows, n) written here.
    """
    for row in range(states.shape[0]):
        for i in range(states.shape[1]):
            possible = stays(states[row], i, free) if is_frozen(limits, i) else not is_outside(states[row], limits, i)
            own[row, i] = next_of(states[row], limits, i, free, 0.0) if possible else inf


@compiled
def are_usual(limits: Floats, outcome: Floats, low: float, high: float) -> bool:
    """Whether limits and durations are of a size at which no square or cube of them under- or overflows.

    Args:
        limits: (n, 6); jerks are the last two.
        outcome: (m, 4) of `plan_rows`; the duration is the last.
        low, high: the sizes.
    """
    most = 0.0
    for i in range(len(limits)):
        most = max(most, limits[i, 4], limits[i, 5])
    usual = low < most < high
    for row in range(len(outcome)):
        T = outcome[row, 3]
        usual &= (low < T < high) or T == np.inf
    return usual


@compiled
def plan_rows(
    states: Floats,
    limits: Floats,
    free: bool,
    mode: int,
    minimum: float,
    cycle: float,
    outcome: Floats,
    count: Floats,
    times: Floats,
    jerks: Floats,
) -> None:
    """Many problems of the same limits.

    1. The constants of motions from rest to rest, once for all.
    2. A problem from rest to rest by these, where they are enough.
    3. Any other by `plan`.

    Args:
        states: (rows, n, 6).
        limits: (n, 6).
        free, mode, minimum, cycle: as in `plan`.
        outcome: (rows, 4) status, coordinate, mode and duration, written here.
        count, times, jerks: (rows, n), (rows, n, 15), (rows, n, 15), written here.
    """
    # 1.
    scratch = np.zeros((6, 7))
    able, curves = rest_curves(limits)
    able &= mode == TIME and not free
    for row in range(len(states)):
        # 2.
        if able and at_rest(states[row]):
            T, ruling = plan_rest(states[row], curves, minimum, cycle, count[row], times[row], jerks[row])
            if T < inf:
                outcome[row, 0], outcome[row, 1], outcome[row, 2], outcome[row, 3] = PLANNED, ruling, TIME, T
                continue
        # 3.
        status, ruling, used, T = plan(
            states[row],
            limits,
            free,
            mode,
            minimum,
            cycle,
            scratch,
            count[row],
            times[row],
            jerks[row],
        )
        outcome[row, 0], outcome[row, 1], outcome[row, 2], outcome[row, 3] = status, ruling, used, T


@compiled
def plan_one(
    start: Floats, v0: Floats, a0: Floats, goal: Floats, vf: Floats, af: Floats, limits: Floats, low: float, high: float
) -> tuple[float, float, float, float, Floats, Floats, Floats, Floats]:
    """One problem as programs ask it, all coordinates together: a call, and nothing beside it.

    Args:
        start, v0, a0, goal, vf, af: (n,) both states.
        limits: (n, 6).
        low, high: as in `are_usual`.

    Returns:
        How it ended, the coordinate and the duration as from `plan`; one if sizes are usual, else zero; and, of one
        row, states and the arrays of `plan_rows`.
    """
    n = len(start)
    states, outcome, count = np.empty((1, n, 6)), np.empty((1, 4)), np.zeros((1, n))
    times, jerks = np.empty((1, n, PIECES)), np.empty((1, n, PIECES))
    for i in range(n):
        states[0, i, 0], states[0, i, 1], states[0, i, 2] = start[i], v0[i], a0[i]
        states[0, i, 3], states[0, i, 4], states[0, i, 5] = goal[i], vf[i], af[i]
    plan_rows(states, limits, False, TIME, 0.0, 0.0, outcome, count, times, jerks)
    usual = 1.0 if are_usual(limits, outcome, low, high) else 0.0
    return outcome[0, 0], outcome[0, 1], outcome[0, 3], usual, states, count, times, jerks
