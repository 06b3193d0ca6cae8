"""States at via points that make the motion through all of them short.

Every motion through via points passes each of them with some velocity and acceleration; between two of them it is best
the shortest one. So the total is a function of these states, and it is searched by compass steps:

1. It begins with the best of a few speeds along the chords, and if there are few points also with rest at all of them.
2. A step changes the velocity, the acceleration, or both, of one coordinate at one via point, or the speed of all
   coordinates there; it is taken if the two segments beside it become shorter. A segment takes the first duration that
   all its coordinates can have; the mean of their shortest enters with a small weight, so that the others make room.
3. Only coordinates that are nearly the slowest of a segment are stepped, and only at via points beside which something
   has changed since no step helped there. When no step helps anywhere, steps become smaller.

A step feels its two segments alone. So long ways are searched in stretches, on all threads, with the states between
them held; then around these joints. The work is proportional to the number of points.
"""

from __future__ import annotations

from math import inf
from typing import NamedTuple

import numpy as np

from mafsil.arrays import Floats
from mafsil.kernels.loops.loop import compiled
from mafsil.trajectory.jerk.plan_loops import PLANNED, TIME, can_pass, next_of, plan, shortest_of
from mafsil.trajectory.tolerances import ROUNDING

SIZES = (0.2, 0.05, 0.012, 0.003)
"""Sizes of steps, as parts of the limits."""
SWEEPS = 8
"""Most times that all steps of one size are tried."""
NEAR = 0.02
"""A coordinate is stepped if it takes as long as the slowest but for this part, or the step's size if that is more."""
MEAN = 1e-3
"""Weight of the mean duration of a segment's coordinates beside that of the slowest."""
GAIN = 2e-6
"""Least part of two segments' time that a step must save."""


class Way(NamedTuple):
    """A way through points, and what is known of its segments.

    Attributes:
        points: (m, n) start, via points, goal.
        limits: (n, 6).
        given: (m, n) velocities at the via points, NaN where they are free.
        at: (m, n, 2) velocity and acceleration at each point.
        own: (m - 1, n) shortest duration of each coordinate in each segment.
        endless: (m - 1, n) one where it can have every longer duration as well, else zero.
        costs: (m - 1,) cost of each segment.
        x: (n, 6) to work in.
    """

    points: Floats
    limits: Floats
    given: Floats
    at: Floats
    own: Floats
    endless: Floats
    costs: Floats
    x: Floats


@compiled
def _way(points: Floats, limits: Floats, given: Floats, at: Floats) -> Way:
    m, n = points.shape
    own, endless = np.zeros((m - 1, n)), np.zeros((m - 1, n))
    return Way(points, limits, given, at, own, endless, np.zeros(m - 1), np.empty((n, 6)))


@compiled
def _ends(w: Way, k: int, i: int) -> None:
    """The states of coordinate i at point k and at the next, into x."""
    w.x[i, 0], w.x[i, 1], w.x[i, 2] = w.points[k, i], w.at[k, i, 0], w.at[k, i, 1]
    w.x[i, 3], w.x[i, 4], w.x[i, 5] = w.points[k + 1, i], w.at[k + 1, i, 0], w.at[k + 1, i, 1]


@compiled
def _measure(w: Way, k: int, i: int) -> None:
    """The shortest duration of coordinate i from point k to the next."""
    _ends(w, k, i)
    w.own[k, i], w.endless[k, i] = shortest_of(w.x, w.limits, i)


@compiled
def _least(own: Floats) -> float:
    """What a segment costs at least: the slowest coordinate, and a little of the mean."""
    total, longest = 0.0, 0.0
    for T in own:
        total += T
        longest = max(longest, T)
    return longest + MEAN * total / len(own)


@compiled
def _cost(w: Way, k: int) -> float:
    """A segment's cost: the first duration that all coordinates can have, and a little of the mean."""
    own, n = w.own[k], len(w.limits)
    least = _least(own)
    if not least < inf:
        return inf
    T = longest = own.max()
    i = having = 0
    for _ in range(8 * n):
        if T > own[i] and w.endless[k, i] == 0.0:
            _ends(w, k, i)
            later = next_of(w.x, w.limits, i, False, T)
            if later > T * (1.0 + ROUNDING):
                T, having = later, 0
        having += 1
        if having >= n or not T < inf:
            break
        i = (i + 1) % n
    return least + (T - longest)


@compiled
def _fill(w: Way) -> None:
    """The durations and costs of all segments."""
    for k in range(len(w.own)):
        for i in range(w.own.shape[1]):
            _measure(w, k, i)
        w.costs[k] = _cost(w, k)


@compiled
def _can_help(w: Way, k: int) -> bool:
    """Whether the segments beside via point k may have become shorter, by their coordinates' own durations."""
    return _least(w.own[k - 1]) + _least(w.own[k]) < (w.costs[k - 1] + w.costs[k]) * (1.0 - GAIN)


@compiled
def _helps(w: Way, k: int) -> bool:
    """Whether the segments beside via point k have become shorter; then their costs are kept."""
    if not _can_help(w, k):
        return False
    before, after = _cost(w, k - 1), _cost(w, k)
    if before + after < (w.costs[k - 1] + w.costs[k]) * (1.0 - GAIN):
        w.costs[k - 1], w.costs[k] = before, after
        return True
    return False


@compiled
def _try(w: Way, k: int, i: int, v: float, a: float) -> bool:
    """Take the state (v, a) of coordinate i at via point k if that saves time."""
    if not can_pass(v, a, w.limits[i]):
        return False
    at, own, endless = w.at[k, i], w.own[k - 1 : k + 1, i], w.endless[k - 1 : k + 1, i]
    v_old, a_old, own_in, own_out, endless_in, endless_out = at[0], at[1], own[0], own[1], endless[0], endless[1]
    at[0], at[1] = v, a
    _measure(w, k - 1, i)
    own[1] = 0.0
    if _can_help(w, k):
        _measure(w, k, i)
        if _helps(w, k):
            return True
    at[0], at[1], own[0], own[1], endless[0], endless[1] = v_old, a_old, own_in, own_out, endless_in, endless_out
    return False


@compiled
def _try_all(w: Way, k: int, factor: float) -> bool:
    """Take free velocities of via point k times a factor, its accelerations times the square, if that saves time."""
    at, own, endless = w.at[k].copy(), w.own[k - 1 : k + 1].copy(), w.endless[k - 1 : k + 1].copy()
    fits = True
    for i in range(len(w.limits)):
        if w.given[k, i] != w.given[k, i]:
            w.at[k, i, 0] *= factor
        w.at[k, i, 1] *= factor * factor
        fits &= can_pass(w.at[k, i, 0], w.at[k, i, 1], w.limits[i])
    for segment in range(k - 1, k + 1):
        if fits:
            for i in range(len(w.limits)):
                _measure(w, segment, i)
            fits = segment == k or _least(w.own[k - 1]) < w.costs[k - 1] + w.costs[k]
    if fits and _helps(w, k):
        return True
    w.at[k], w.own[k - 1 : k + 1], w.endless[k - 1 : k + 1] = at, own, endless
    return False


@compiled
def _is_slow(w: Way, k: int, i: int, part: float) -> bool:
    """Whether coordinate i takes this part of the slowest one's time or more, in a segment beside via point k."""
    return w.own[k - 1, i] >= part * w.own[k - 1].max() or w.own[k, i] >= part * w.own[k].max()


@compiled
def _step(w: Way, k: int, scale: Floats, size: float) -> bool:
    """Try every step of one size at via point k; whether one was taken."""
    taken = False
    for i in range(len(w.limits)):
        if not _is_slow(w, k, i, 1.0 - max(size, NEAR)):
            continue
        for move in range(8):
            dv, da = _direction(move)
            if dv != 0.0 and w.given[k, i] == w.given[k, i]:
                continue
            for _ in range(SWEEPS):
                v, a = w.at[k, i, 0] + dv * size * scale[i, 0], w.at[k, i, 1] + da * size * scale[i, 1]
                if not _try(w, k, i, v, a):
                    break
                taken = True
    taken |= _try_all(w, k, 1.0 + size)
    taken |= _try_all(w, k, 1.0 / (1.0 + size))
    return taken


@compiled
def _direction(move: int) -> tuple[float, float]:
    """The eight directions of a compass."""
    if move < 4:
        sign = 1.0 if move % 2 == 0 else -1.0
        return (sign, 0.0) if move < 2 else (0.0, sign)
    return (1.0 if move % 2 == 0 else -1.0), (1.0 if move < 6 else -1.0)


@compiled
def _scales(w: Way, scale: Floats) -> None:
    """The velocity and acceleration (n, 2) that each coordinate can have on its longest way."""
    points, limits = w.points, w.limits
    for i in range(points.shape[1]):
        steep, far = min(limits[i, 5], -limits[i, 4]), 0.0
        for k in range(len(points) - 1):
            far = max(far, abs(points[k + 1, i] - points[k, i]))
        scale[i, 0] = min(max(limits[i, 1], -limits[i, 0]), (far * far * steep) ** (1.0 / 3.0))
        scale[i, 1] = min(limits[i, 3], -limits[i, 2], (far * steep * steep) ** (1.0 / 3.0))


@compiled
def _search(w: Way) -> None:
    """Better states at all points but the ends: steps of each size until none helps."""
    m, n = w.points.shape
    scale = np.empty((n, 2))
    _scales(w, scale)
    _fill(w)
    for size in SIZES:
        fresh = np.ones(m)
        for _ in range(SWEEPS):
            taken = False
            for k in range(1, m - 1):
                if fresh[k] > 0.0:
                    fresh[k] = 0.0
                    if _step(w, k, scale, size):
                        fresh[k - 1 : k + 2] = 1.0
                        taken = True
            if not taken:
                break


@compiled
def search_rows(points: Floats, limits: Floats, given: Floats, at: Floats, first: int, last: int) -> None:
    """Better states on a stretch of many ways, from each of their beginnings.

    Args:
        points, limits, given, at: as those of `begin_rows`; all but the first states of each row are searched on.
        first, last: points of the stretch's ends, whose states stay.
    """
    for row in range(len(points)):
        there, free = points[row, first : last + 1], given[row, first : last + 1]
        for turn in range(1, at.shape[1]):
            _search(_way(there, limits, free, at[row, turn, first : last + 1]))


@compiled
def _total(w: Way, pieces: Floats, count: Floats) -> float:
    """The sum of the common durations of all segments, infinite if one has none; their pieces are written."""
    scratch = np.empty((6, 7))
    total = 0.0
    for k in range(len(w.own)):
        for i in range(len(w.limits)):
            _ends(w, k, i)
        status, _, _, T = plan(w.x, w.limits, False, TIME, 0.0, 0.0, scratch, count[k], pieces[k, 0], pieces[k, 1])
        if status != PLANNED:
            return inf
        total += T
    return total


@compiled
def _chords(w: Way, own: Floats, speed: float) -> bool:
    """Velocities along the chords: of the slower one beside a via point, none where the direction turns.

    Args:
        w: the way; velocities are written.
        own: durations of its segments from rest to rest.
        speed: factor.

    Returns:
        Whether all of them can be passed.
    """
    points, fits = w.points, True
    for k in range(1, len(points) - 1):
        before, after = own[k - 1].max(), own[k].max()
        for i in range(points.shape[1]):
            a = (points[k, i] - points[k - 1, i]) / before if before > 0.0 else 0.0
            b = (points[k + 1, i] - points[k, i]) / after if after > 0.0 else 0.0
            v = speed * (a if abs(a) < abs(b) else b) if a * b > 0.0 else 0.0
            v = min(max(v, w.limits[i, 0]), w.limits[i, 1])
            w.at[k, i, 0], w.at[k, i, 1] = w.given[k, i] if w.given[k, i] == w.given[k, i] else v, 0.0
            fits &= can_pass(w.at[k, i, 0], 0.0, w.limits[i])
    return fits


@compiled
def begin_rows(
    points: Floats, limits: Floats, given: Floats, at: Floats, pieces: Floats, count: Floats, totals: Floats
) -> None:
    """States at the via points of many ways to begin with: rest, or a speed along the chords.

    Args:
        points: (rows, m, n) start, via points, goal.
        limits: (n, 6).
        given: (rows, m, n) velocities at the via points, NaN where they are free.
        at: (rows, 1 + beginnings, m, n, 2) velocity and acceleration; those at start and goal are given, those at the
            via points written here: twice those with the least total, then rest.
        pieces: (rows, m - 1, 2, n, 15) durations and jerks, to work in.
        count: (rows, m - 1, n) numbers of pieces, to work in.
        totals: (rows, 2) of which the last is written: the duration with rest at every free via point.
    """
    for row in range(len(points)):
        w = _way(points[row], limits, given[row], at[row, 0].copy())
        _chords(w, w.own, 0.0)
        _fill(w)
        least = totals[row, 1] = _total(w, pieces[row], count[row])
        for turn in range(at.shape[1]):
            at[row, turn] = w.at
        resting = w.own.copy()
        for turn in range(1, 9):
            if _chords(w, resting, 0.25 * turn):
                total = _total(w, pieces[row], count[row])
                if total < least:
                    least = total
                    at[row, 0], at[row, 1] = w.at, w.at


@compiled
def end_rows(
    points: Floats, limits: Floats, given: Floats, at: Floats, pieces: Floats, count: Floats, totals: Floats
) -> None:
    """The shortest of what was found from all beginnings, or the first beginning: its states become the first.

    Args:
        points, limits, given, at, pieces, count, totals: as in `begin_rows`; the first of `totals` is written.
    """
    for row in range(len(points)):
        totals[row, 0], best = inf, 0
        for turn in range(at.shape[1]):
            w = _way(points[row], limits, given[row], at[row, turn])
            total = _total(w, pieces[row], count[row])
            if total < totals[row, 0]:
                totals[row, 0], best = total, turn
        at[row, 0] = at[row, best]
        _total(_way(points[row], limits, given[row], at[row, 0]), pieces[row], count[row])
