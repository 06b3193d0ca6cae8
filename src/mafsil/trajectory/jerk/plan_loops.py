"""Several coordinates: together, each for itself, or along a straight line; batches of problems in one call.

1. Targets are looked at first: each must lie within its limits and not have come from outside.
2. Along a line there is one problem; singly there are n that have nothing to do with each other.
3. Together: the first duration that every coordinate can have, a multiple of the cycle if there is one. It begins with
   the least one asked for and grows with each coordinate that cannot have it to that coordinate's next
   (`next_duration`), until all have their motion (`motion_of`). The durations that a coordinate can have are at most
   three ranges, so the search ends.
"""

from __future__ import annotations

from math import ceil, inf, isfinite, sqrt

from mafsil.arrays import Floats
from mafsil.kernels.loops.loop import compiled
from mafsil.trajectory.jerk.coordinate_loops import (
    PIECES,
    beyond_gap,
    is_endless,
    motion_of,
    next_duration,
    shortest_change,
    task_of,
)
from mafsil.trajectory.tolerances import ROUNDING

PLANNED, TARGET_OUTSIDE, FROZEN, UNREACHABLE, NO_COMMON, BEYOND_NUMBERS, NOT_FINITE = range(7)
"""How planning ended; the order is that of `status.STATUSES`, which the last is not one of."""
TIME, PHASE, SINGLY = range(3)
"""Synchronisation; the order is that of `motion.SYNCHRONISATIONS`."""
RANGES = 4
"""One more than the ranges of durations that a coordinate can have."""


@compiled
def is_outside(states: Floats, limits: Floats, i: int) -> bool:
    """Whether a target is not within its limits, or cannot have been reached from within them.

    Args:
        states: (n, 6) position, velocity and acceleration of the start and of the goal of each coordinate.
        limits: (n, 6) bounds of velocity, of acceleration and of jerk, lower and upper.
        i: the coordinate.
    """
    v, a = states[i, 4], states[i, 5]
    if a == 0.0:
        return v != 0.0 and not _keep(v, limits[i, 0], limits[i, 1])
    before = v - 0.5 * a * a / (limits[i, 5] if a > 0.0 else limits[i, 4])
    return not (
        _keep(v, limits[i, 0], limits[i, 1])
        and _keep(a, limits[i, 2], limits[i, 3])
        and _keep(before, limits[i, 0], limits[i, 1])
    )


@compiled
def can_pass(v: float, a: float, limits: Floats) -> bool:
    """Whether a state can be reached from within the limits and left within them.

    Args:
        v, a: velocity and acceleration.
        limits: (6,).
    """
    if not (limits[0] <= v <= limits[1] and limits[2] <= a <= limits[3]):
        return False
    drop, rise = 0.5 * a * a / limits[5], -0.5 * a * a / limits[4]
    return a == 0.0 or (v - drop >= limits[0] and v + rise <= limits[1])


@compiled
def _keep(x: float, low: float, high: float) -> bool:
    over = x - high if high < inf else -1.0
    under = low - x if low > -inf else -1.0
    return over <= ROUNDING * abs(high) and under <= ROUNDING * abs(low)


@compiled
def is_frozen(limits: Floats, i: int) -> bool:
    """No acceleration or no jerk in one direction: its velocity can only stay."""
    return limits[i, 2] == 0.0 or limits[i, 3] == 0.0 or limits[i, 4] == 0.0 or limits[i, 5] == 0.0


@compiled
def stays(states: Floats, i: int, free: bool) -> bool:
    """Whether a frozen coordinate need not change its velocity; arguments as of `is_outside`, `free` without a goal."""
    v = states[i, 1]
    if states[i, 2] != 0.0 or states[i, 5] != 0.0 or v != states[i, 4]:
        return False
    D = states[i, 3] - states[i, 0]
    return free or D == 0.0 or (v != 0.0 and D / v > 0.0)


@compiled
def next_of(states: Floats, limits: Floats, i: int, free: bool, T: float) -> float:
    """The least duration of at least T that a coordinate can have, braking included; infinite if there is none.

    Args:
        states: (n, 6).
        limits: (n, 6).
        i: the coordinate.
        free: whether the displacement does not matter.
        T: [s].
    """
    if is_frozen(limits, i):
        D, v = states[i, 3] - states[i, 0], states[i, 1]
        if free or (v == 0.0 and D == 0.0):
            return T
        return D / v if T <= D / v * (1.0 + ROUNDING) else inf
    w = task_of(states, limits, i)
    lead = w.t1 + w.t2
    if free:
        return beyond_gap(w, max(T - lead, shortest_change(w))) + lead
    return next_duration(w, max(T - lead, 0.0)) + lead


@compiled
def shortest_of(states: Floats, limits: Floats, i: int) -> tuple[float, float]:
    """The least duration that a coordinate can have, braking included, and one if it can have every longer one, too.

    Args:
        states: (n, 6).
        limits: (n, 6).
        i: the coordinate.
    """
    if is_frozen(limits, i):
        return next_of(states, limits, i, False, 0.0), 0.0
    w = task_of(states, limits, i)
    T = next_duration(w, 0.0)
    return T + w.t1 + w.t2, 1.0 if T < inf and is_endless(w, T) else 0.0


@compiled
def _write(
    states: Floats,
    limits: Floats,
    i: int,
    free: bool,
    T: float,
    sure: bool,
    scratch: Floats,
    times: Floats,
    jerks: Floats,
) -> int:
    """The pieces of one coordinate; their number is 0 if it cannot have this duration, of which it may be sure."""
    if is_frozen(limits, i):
        times[i, 0], jerks[i, 0] = T, 0.0
        D = states[i, 3] - states[i, 0]
        return 1 if free or abs(states[i, 1] * T - D) <= ROUNDING * abs(D) else 0
    w = task_of(states, limits, i)
    return motion_of(w, T - w.t1 - w.t2, free, sure, scratch, times, jerks, i)


@compiled
def _rounded_up(T: float, cycle: float) -> float:
    return ceil(T / cycle * (1.0 - 1e-15)) * cycle if cycle > 0.0 and T < inf else T


@compiled
def _in_time(
    states: Floats,
    limits: Floats,
    i: int,
    free: bool,
    T: float,
    cycle: float,
    scratch: Floats,
    times: Floats,
    jerks: Floats,
) -> tuple[float, int]:
    """The least duration of at least T that is a multiple of the cycle, and the number of pieces of its motion."""
    pieces = 0
    for _ in range(RANGES):
        T = next_of(states, limits, i, free, T)
        if not T < inf:
            return inf, 0
        T = _rounded_up(T, cycle)
        pieces = _write(states, limits, i, free, T, cycle == 0.0, scratch, times, jerks)
        if pieces > 0:
            return T, pieces
    return inf, 0


@compiled
def _line(states: Floats, limits: Floats, x: Floats, bounds: Floats) -> bool:
    """The problem of s in p0 + s (pf - p0), if all states lie on that line.

    Args:
        states: (n, 6) p0, v0, a0, pf, vf, af of each coordinate.
        limits: (n, 6).
        x, bounds: (1, 6) states and limits of s, written here.
    """
    n = len(states)
    # 1. The farthest coordinate says how states are measured along the line.
    m = 0
    for i in range(n):
        if abs(states[i, 3] - states[i, 0]) > abs(states[m, 3] - states[m, 0]):
            m = i
    D = states[m, 3] - states[m, 0]
    if D == 0.0:
        return False
    x[0, 0], x[0, 3] = 0.0, 1.0
    for k in (1, 2, 4, 5):
        x[0, k] = states[m, k] / D
        for i in range(n):
            if abs(states[i, k] - x[0, k] * (states[i, 3] - states[i, 0])) > ROUNDING * abs(states[m, k]):
                return False
    # 2. The tightest limits of all coordinates.
    for k in range(6):
        bounds[0, k] = inf if k % 2 else -inf
    for i in range(n):
        d = states[i, 3] - states[i, 0]
        if d != 0.0:
            for k in (0, 2, 4):
                low, high = (limits[i, k], limits[i, k + 1]) if d > 0.0 else (limits[i, k + 1], limits[i, k])
                bounds[0, k] = max(bounds[0, k], low / d)
                bounds[0, k + 1] = min(bounds[0, k + 1], high / d)
    return True


@compiled
def _along_line(
    states: Floats,
    limits: Floats,
    minimum: float,
    cycle: float,
    scratch: Floats,
    count: Floats,
    times: Floats,
    jerks: Floats,
) -> float:
    """All coordinates along the line; its duration, or -1 if the states do not lie on it or it cannot be kept."""
    x, bounds = scratch[4:5, :6], scratch[5:6, :6]
    if not _line(states, limits, x, bounds) or is_frozen(bounds, 0) or is_outside(x, bounds, 0):
        return -1.0
    T, pieces = _in_time(x, bounds, 0, False, minimum, cycle, scratch, times, jerks)
    if not T < inf:
        return -1.0
    for i in range(len(states) - 1, -1, -1):
        count[i] = pieces
        d = states[i, 3] - states[i, 0]
        for m in range(pieces):
            times[i, m], jerks[i, m] = times[0, m], jerks[0, m] * d
    return T


@compiled
def plan(
    states: Floats,
    limits: Floats,
    free: bool,
    mode: int,
    minimum: float,
    cycle: float,
    scratch: Floats,
    count: Floats,
    times: Floats,
    jerks: Floats,
) -> tuple[int, int, int, float]:
    """One problem of n coordinates; nothing is allocated.

    Args:
        states: (n, 6) p0, v0, a0, pf, vf, af of each coordinate.
        limits: (n, 6) lower and upper velocity, acceleration and jerk.
        free: whether displacements do not matter.
        mode: TIME, PHASE or SINGLY.
        minimum: least duration [s].
        cycle: durations are multiples of it [s]; any if zero.
        scratch: (6, 7) to work in.
        count: (n,) numbers of pieces, written here.
        times, jerks: (n, 15) pieces, written here.

    Returns:
        How it ended, the coordinate that rules the duration or forbids it, the mode that was used, and the duration.
    """
    n = len(states)
    # 1. Numbers, and targets.
    for i in range(n):
        total = states[i, 0] + states[i, 1] + states[i, 2] + states[i, 3] + states[i, 4] + states[i, 5]
        if not isfinite(total):
            return NOT_FINITE, i, mode, inf
        if is_frozen(limits, i):
            if not stays(states, i, free):
                return FROZEN, i, mode, inf
        elif is_outside(states, limits, i):
            return TARGET_OUTSIDE, i, mode, inf
    # 2. Along a line, or each for itself.
    if mode == PHASE and not free:
        T = _along_line(states, limits, minimum, cycle, scratch, count, times, jerks)
        if T >= 0.0:
            return PLANNED, _farthest(states, limits), PHASE, T
    if mode == SINGLY:
        ruling, T = _singly(states, limits, free, minimum, cycle, scratch, count, times, jerks)
        return (PLANNED if T < inf else _refusal(states, limits, ruling, free)), ruling, SINGLY, T
    # 3. The first common duration: it grows with each coordinate that cannot have it, until all can.
    T = _rounded_up(minimum, cycle)
    i = ruling = _farthest(states, limits)
    having = 0
    for _ in range(RANGES * n * n + n):
        pieces = 0
        if T > 0.0 or having > 0:
            pieces = _write(states, limits, i, free, T, False, scratch, times, jerks)
        if pieces > 0:
            having += 1
        else:
            T, pieces = _in_time(states, limits, i, free, T, cycle, scratch, times, jerks)
            if not T < inf:
                return _refusal(states, limits, i, free), i, TIME, inf
            ruling, having = i, 1
        count[i] = pieces
        if having == n:
            return PLANNED, ruling, TIME, T
        i = (i + 1) % n
    return NO_COMMON, ruling, TIME, inf


@compiled
def _refusal(states: Floats, limits: Floats, i: int, free: bool) -> int:
    """Why a coordinate has no duration: none at all, none that the others or the request have, or no numbers for it."""
    alone = next_of(states, limits, i, free, 0.0)
    if alone < inf:
        return NO_COMMON
    return UNREACHABLE if alone == inf else BEYOND_NUMBERS


@compiled
def _farthest(states: Floats, limits: Floats) -> int:
    """The coordinate that will probably need most time: a good one to begin with."""
    best, m = -1.0, 0
    for i in range(len(states)):
        D = abs(states[i, 3] - states[i, 0])
        need = D / limits[i, 1] + sqrt(D / limits[i, 3]) if limits[i, 1] > 0.0 and limits[i, 3] > 0.0 else 0.0
        if need > best:
            best, m = need, i
    return m


@compiled
def _singly(
    states: Floats,
    limits: Floats,
    free: bool,
    minimum: float,
    cycle: float,
    scratch: Floats,
    count: Floats,
    times: Floats,
    jerks: Floats,
) -> tuple[int, float]:
    """Each coordinate in its own time, then going on with its last velocity: the coordinate that takes longest."""
    n = len(states)
    ruling, longest = 0, 0.0
    for i in range(n):
        T, pieces = _in_time(states, limits, i, free, minimum, cycle, scratch, times, jerks)
        if not T < inf:
            return i, inf
        count[i] = pieces
        if T > longest:
            ruling, longest = i, T
    for i in range(n):
        pieces, own = int(count[i]), 0.0
        for m in range(pieces):
            own += times[i, m]
        if own < longest and pieces < PIECES:
            times[i, pieces], jerks[i, pieces] = longest - own, 0.0
            count[i] = pieces + 1
    return ruling, longest
