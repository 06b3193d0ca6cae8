"""States at via points that make the motion through all of them short.

Every motion through via points passes each of them with some velocity and acceleration; between two of them it is best
the shortest one. So the total is a function of these states, and it is searched by compass steps:

1. It begins with the best of a few speeds along the chords, rest at every via point being one of them.
2. A step changes the velocity, the acceleration, or both, of one coordinate at one via point, or the speed of all
   coordinates there; it is taken if the two segments beside it become shorter. A segment takes as long as its slowest
   coordinate; the mean of all enters with a small weight, so that the others make room.
3. When no step helps, steps become smaller. First a segment's duration is taken to be its slowest coordinate's; then
   the search goes on with common durations, which not every coordinate can have, from what was found and from the best
   beginning. The best states of all are kept.
"""

from __future__ import annotations

from math import inf

import numpy as np

from mafsil.arrays import Floats
from mafsil.kernels.loops.loop import compiled
from mafsil.trajectory.jerk.plan_loops import PLANNED, TIME, can_pass, next_of, plan
from mafsil.trajectory.tolerances import ROUNDING

SIZES = (0.3, 0.1, 0.03, 0.01, 0.003, 0.001)
"""Sizes of steps, as parts of the limits."""
SWEEPS = 8
"""Most times that all steps of one size are tried."""
ROUNDS = 2
"""Most times that all sizes are gone through."""
MEAN = 1e-3
"""Weight of the mean duration of a segment's coordinates beside that of the slowest."""
GAIN = 2e-6
"""Least part of the total that a step must save."""


@compiled
def _ends(points: Floats, at: Floats, k: int, i: int, x: Floats) -> None:
    """The states of coordinate i at point k and at the next, into x (n, 6)."""
    x[i, 0], x[i, 1], x[i, 2] = points[k, i], at[k, i, 0], at[k, i, 1]
    x[i, 3], x[i, 4], x[i, 5] = points[k + 1, i], at[k + 1, i, 0], at[k + 1, i, 1]


@compiled
def _duration(points: Floats, at: Floats, k: int, i: int, limits: Floats, x: Floats) -> float:
    """Shortest duration of coordinate i from point k to the next."""
    _ends(points, at, k, i, x)
    return next_of(x, limits, i, False, 0.0)


@compiled
def _cost(each: Floats) -> float:
    """A segment's duration, and a little of the mean of its coordinates."""
    total, longest = 0.0, 0.0
    for T in each:
        total += T
        longest = max(longest, T)
    return longest + MEAN * total / len(each)


@compiled
def _segment(points: Floats, at: Floats, k: int, limits: Floats, each: Floats, common: bool, x: Floats) -> float:
    """The cost of a segment whose coordinates' shortest durations are `each`; on request of their common duration."""
    cost = _cost(each)
    if not common or not cost < inf:
        return cost
    longest = each.max()
    T = longest
    n = len(each)
    i = fitting = 0
    for _ in range(8 * n):
        if T > each[i]:
            _ends(points, at, k, i, x)
            later = next_of(x, limits, i, False, T)
            if later > T * (1.0 + ROUNDING):
                T, fitting = later, 0
        fitting += 1
        if fitting >= n or not T < inf:
            break
        i = (i + 1) % n
    return cost + (T - longest)


@compiled
def _fill(points: Floats, at: Floats, limits: Floats, each: Floats, costs: Floats, common: bool, x: Floats) -> float:
    """All durations of all coordinates (segments, n), and the costs (segments,); the sum of these."""
    for k in range(len(each)):
        for i in range(each.shape[1]):
            each[k, i] = _duration(points, at, k, i, limits, x)
        costs[k] = _segment(points, at, k, limits, each[k], common, x)
    return costs.sum()


@compiled
def true_total(points: Floats, at: Floats, limits: Floats, work: Floats, pieces: Floats, count: Floats) -> float:
    """The sum of the common durations of all segments; infinite if one has none.

    Args:
        points: (m, n).
        at: (m, n, 2) velocity and acceleration at each.
        limits: (n, 6).
        work: (n, 6).
        pieces: (m - 1, 2, n, 15) durations and jerks, written here.
        count: (m - 1, n) numbers of pieces, written here.
    """
    scratch = np.empty((6, 7))
    total = 0.0
    for k in range(len(points) - 1):
        for i in range(points.shape[1]):
            _ends(points, at, k, i, work)
        status, _, _, T = plan(work, limits, False, TIME, 0.0, 0.0, scratch, count[k], pieces[k, 0], pieces[k, 1])
        if status != PLANNED:
            return inf
        total += T
    return total


@compiled
def _chords(points: Floats, limits: Floats, each: Floats, given: Floats, speed: float, at: Floats) -> None:
    """Velocities along the chords: of the slower one beside a via point, none where the direction turns."""
    for k in range(1, len(points) - 1):
        before, after = each[k - 1].max(), each[k].max()
        for i in range(points.shape[1]):
            at[k, i, 1] = 0.0
            if given[k, i] == given[k, i]:
                at[k, i, 0] = given[k, i]
                continue
            a = (points[k, i] - points[k - 1, i]) / before if before > 0.0 else 0.0
            b = (points[k + 1, i] - points[k, i]) / after if after > 0.0 else 0.0
            v = speed * (a if abs(a) < abs(b) else b) if a * b > 0.0 else 0.0
            at[k, i, 0] = min(max(v, limits[i, 0]), limits[i, 1])


@compiled
def _beside(
    points: Floats, at: Floats, limits: Floats, each: Floats, costs: Floats, common: bool, k: int, x: Floats
) -> bool:
    """Whether the costs of the segments beside via point k have become less; then they are kept."""
    before = _segment(points, at, k - 1, limits, each[k - 1], common, x)
    after = _segment(points, at, k, limits, each[k], common, x)
    if before + after < (costs[k - 1] + costs[k]) * (1.0 - GAIN):
        costs[k - 1], costs[k] = before, after
        return True
    return False


@compiled
def _try(
    points: Floats,
    at: Floats,
    limits: Floats,
    each: Floats,
    costs: Floats,
    common: bool,
    k: int,
    i: int,
    v: float,
    a: float,
    x: Floats,
) -> bool:
    """Take the state (v, a) of coordinate i at via point k if that saves time."""
    if not can_pass(v, a, limits[i]):
        return False
    old_v, old_a, old_in, old_out = at[k, i, 0], at[k, i, 1], each[k - 1, i], each[k, i]
    at[k, i, 0], at[k, i, 1] = v, a
    each[k - 1, i] = _duration(points, at, k - 1, i, limits, x)
    each[k, i] = _duration(points, at, k, i, limits, x)
    if _beside(points, at, limits, each, costs, common, k, x):
        return True
    at[k, i, 0], at[k, i, 1], each[k - 1, i], each[k, i] = old_v, old_a, old_in, old_out
    return False


@compiled
def _scale(at: Floats, given: Floats, limits: Floats, k: int, factor: float) -> bool:
    """The free velocities of a via point times a factor, its accelerations times the square; whether they can be."""
    fits = True
    for i in range(at.shape[1]):
        if given[k, i] != given[k, i]:
            at[k, i, 0] *= factor
        at[k, i, 1] *= factor * factor
        fits &= can_pass(at[k, i, 0], at[k, i, 1], limits[i])
    return fits


@compiled
def _try_all(
    points: Floats,
    at: Floats,
    limits: Floats,
    each: Floats,
    costs: Floats,
    common: bool,
    given: Floats,
    k: int,
    factor: float,
    x: Floats,
) -> bool:
    """Scale all velocities of via point k if that saves time."""
    taken = False
    if _scale(at, given, limits, k, factor):
        for i in range(points.shape[1]):
            each[k - 1, i] = _duration(points, at, k - 1, i, limits, x)
            each[k, i] = _duration(points, at, k, i, limits, x)
        taken = _beside(points, at, limits, each, costs, common, k, x)
    if not taken:
        _scale(at, given, limits, k, 1.0 / factor)
        for i in range(points.shape[1]):
            each[k - 1, i] = _duration(points, at, k - 1, i, limits, x)
            each[k, i] = _duration(points, at, k, i, limits, x)
    return taken


@compiled
def _sweep(
    points: Floats,
    at: Floats,
    limits: Floats,
    each: Floats,
    costs: Floats,
    common: bool,
    given: Floats,
    scale: Floats,
    size: float,
    x: Floats,
) -> bool:
    """Try every step of one size once; whether one was taken."""
    found = False
    for k in range(1, len(points) - 1):
        for i in range(points.shape[1]):
            dv, da = size * scale[i, 0], size * scale[i, 1]
            for move in range(8):
                sv, sa = _direction(move)
                if sv != 0.0 and given[k, i] == given[k, i]:
                    continue
                for _ in range(SWEEPS):
                    v, a = at[k, i, 0] + sv * dv, at[k, i, 1] + sa * da
                    if not _try(points, at, limits, each, costs, common, k, i, v, a, x):
                        break
                    found = True
        found |= _try_all(points, at, limits, each, costs, common, given, k, 1.0 + size, x)
        found |= _try_all(points, at, limits, each, costs, common, given, k, 1.0 / (1.0 + size), x)
    return found


@compiled
def _search(
    points: Floats, at: Floats, limits: Floats, common: bool, given: Floats, scale: Floats, rounds: int, x: Floats
) -> None:
    """Steps of each size until none helps, and all over again as long as that saves something."""
    m, n = points.shape
    each, costs = np.empty((m - 1, n)), np.empty(m - 1)
    total = _fill(points, at, limits, each, costs, common, x)
    for _ in range(rounds):
        for size in SIZES:
            for _ in range(SWEEPS):
                if not _sweep(points, at, limits, each, costs, common, given, scale, size, x):
                    break
        now = costs.sum()
        if now > total * (1.0 - 1e-4):
            break
        total = now


@compiled
def _direction(move: int) -> tuple[float, float]:
    """The eight directions of a compass."""
    if move < 4:
        sign = 1.0 if move % 2 == 0 else -1.0
        return (sign, 0.0) if move < 2 else (0.0, sign)
    return (1.0 if move % 2 == 0 else -1.0), (1.0 if move < 6 else -1.0)


@compiled
def through(
    points: Floats, limits: Floats, given: Floats, at: Floats, pieces: Floats, count: Floats
) -> tuple[float, float]:
    """States at the via points, and the pieces of all segments.

    Args:
        points: (m, n) start, via points, goal.
        limits: (n, 6).
        given: (m, n) velocities at the via points, NaN where they are free.
        at: (m, n, 2) velocity and acceleration at the start and the goal; those at the via points are written here.
        pieces: (m - 1, 2, n, 15) durations and jerks, written here.
        count: (m - 1, n) numbers of pieces, written here.

    Returns:
        The total duration, and the one with rest at every via point whose velocity is free; infinite if there is none.
    """
    m, n = points.shape
    each, costs, work = np.empty((m - 1, n)), np.empty(m - 1), np.empty((n, 6))
    scale, resting = np.empty((n, 2)), np.empty((m - 1, n))
    _scales(points, limits, scale)
    # 1. The beginning: rest at the via points, or the best speed along the chords.
    _chords(points, limits, np.ones((m - 1, n)), given, 0.0, at)
    stops = true_total(points, at, limits, work, pieces, count)
    least, best, lowest = stops, at.copy(), _fill(points, at, limits, resting, costs, False, work)
    first = at.copy()
    for turn in range(1, 9):
        _chords(points, limits, resting, given, 0.25 * turn, at)
        if _can_all(at, limits):
            cost = _fill(points, at, limits, each, costs, False, work)
            if cost < lowest:
                lowest = cost
                first[:] = at
            total = true_total(points, at, limits, work, pieces, count)
            if total < least:
                least = total
                best[:] = at
    # 2. The search without and with common durations, from the beginning; then from the best of them.
    beginning = best.copy()
    at[:] = first
    for turn in range(3):
        if turn == 2:
            at[:] = beginning
        _search(points, at, limits, turn > 0, given, scale, ROUNDS, work)
        total = true_total(points, at, limits, work, pieces, count)
        if total < least:
            least = total
            best[:] = at
    at[:] = best
    return true_total(points, at, limits, work, pieces, count), stops


@compiled
def _scales(points: Floats, limits: Floats, scale: Floats) -> None:
    """The velocity and acceleration (n, 2) that each coordinate can have on its longest way."""
    for i in range(points.shape[1]):
        steep, far = min(limits[i, 5], -limits[i, 4]), 0.0
        for k in range(len(points) - 1):
            far = max(far, abs(points[k + 1, i] - points[k, i]))
        scale[i, 0] = min(max(limits[i, 1], -limits[i, 0]), (far * far * steep) ** (1.0 / 3.0))
        scale[i, 1] = min(limits[i, 3], -limits[i, 2], (far * steep * steep) ** (1.0 / 3.0))


@compiled
def _can_all(at: Floats, limits: Floats) -> bool:
    """Whether all states at via points can be passed."""
    fits = True
    for k in range(1, len(at) - 1):
        for i in range(at.shape[1]):
            fits &= can_pass(at[k, i, 0], at[k, i, 1], limits[i])
    return fits


@compiled
def through_rows(
    points: Floats, limits: Floats, given: Floats, at: Floats, pieces: Floats, count: Floats, totals: Floats
) -> None:
    """Many motions through via points, each as `through`.

    Args:
        points, given, at, pieces, count: as there, with a first axis of rows.
        limits: (n, 6).
        totals: (rows, 2) what it returns, written here.
    """
    for row in range(len(points)):
        least, stops = through(points[row], limits, given[row], at[row], pieces[row], count[row])
        totals[row, 0], totals[row, 1] = least, stops
