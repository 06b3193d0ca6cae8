"""Grids of many paths, compiled: even ones, finer ones where time is lost, and eight of them side by side in lanes."""

# pyright: reportMissingParameterType=false, reportUnknownVariableType=false, reportUnknownParameterType=false
# pyright: reportUnknownMemberType=false, reportUnknownArgumentType=false
from __future__ import annotations

from math import sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.kernels.loops.lanes import buffer, in_lanes, part, put, seen, where
from mafsil.kernels.loops.loop import compiled
from mafsil.trajectory.timing.path_rows_loops import FREE, larger
from mafsil.trajectory.tolerances import GIVEN

Indices = NDArray[np.int64]

LEAST_PARTS = 2
"""Intervals of each piece: one that begins and ends at rest has to speed up and slow down."""
MOST_PARTS = 8
"""Into which one interval is divided at once."""


@compiled
def places_needed(knots, intervals):
    """How many places `divide_grid` writes for a path with these knots."""
    length, count = knots[-1] - knots[0], 1
    for k in range(len(knots) - 1):
        count += max(LEAST_PARTS, round(intervals * (knots[k + 1] - knots[k]) / length)) if length > 0.0 else 1
    return count


@compiled
def divide_grid(knots, intervals, s, piece):
    """A grid that contains the knots, each piece divided evenly, in place.

    Args:
        knots: (pieces + 1,) of the path.
        intervals: how many for the whole path, at least; every piece gets LEAST_PARTS.
        s: (places,) path parameters.
        piece: (places - 1,) on which piece of the path each interval lies.
    """
    length, place = knots[-1] - knots[0], 0
    for k in range(len(knots) - 1):
        h = knots[k + 1] - knots[k]
        parts = max(LEAST_PARTS, round(intervals * h / length)) if length > 0.0 else 1
        for i in range(parts):
            s[place] = knots[k] + h * (i / parts)
            piece[place] = k
            place += 1
    s[place] = knots[-1]


@compiled
def parts_of(loss, goal, parts):
    """Into how many parts each interval is divided so that the losses of the parts become equal, in place.

    A loss shrinks with the square of the length, so sqrt(loss/level) parts bring it to a level, found by bisection.

    Args:
        loss: (intervals,) of each.
        goal: how many parts in all.
        parts: (intervals,) receives how many, at most MOST_PARTS each.

    Returns:
        How many parts in all.
    """
    floor, roof = 0.0, 0.0
    for i in range(len(loss)):
        roof = max(roof, sqrt(loss[i]))
    for _ in range(40):
        level, count = 0.5 * (floor + roof), 0.0
        for i in range(len(loss)):
            count += min(max(np.ceil(sqrt(loss[i]) / level), 1.0), MOST_PARTS) if level > 0.0 else MOST_PARTS
        if count > goal:
            floor = level
        else:
            roof = level
    total = 0
    for i in range(len(loss)):
        parts[i] = int(min(max(np.ceil(sqrt(loss[i]) / roof), 1.0), MOST_PARTS)) if roof > 0.0 else 1
        total += parts[i]
    return total


@compiled
def subdivide_grid(s, piece, parts, finer, under):
    """A grid whose intervals are divided, in place; arguments as in `divide_grid`, and how many parts each gets."""
    place = 0
    for i in range(len(piece)):
        for k in range(parts[i]):
            finer[place] = s[i] + (s[i + 1] - s[i]) * (k / parts[i])
            under[place] = piece[i]
            place += 1
    finer[place] = s[-1]


@compiled
def all_divided(knots: Floats, firsts: Indices, intervals: int, begins: Indices) -> tuple[Floats, Indices]:
    """A grid for each of many paths: path parameters, and the path piece under each interval.

    Args:
        knots: (pieces + paths,) of all paths; firsts: (paths + 1,) where each begins.
        intervals: of each path, at least.
        begins: (paths + 1,) receives where each grid begins.
    """
    begins[0] = 0
    for b in range(len(begins) - 1):
        f, g = firsts[b], firsts[b + 1]
        begins[b + 1] = begins[b] + places_needed(knots[f + b : g + b + 1], intervals)
    s, piece = np.empty(begins[-1]), np.zeros(begins[-1], np.int64)
    for b in range(len(begins) - 1):
        u, v, f, g = begins[b], begins[b + 1], firsts[b], firsts[b + 1]
        divide_grid(knots[f + b : g + b + 1], intervals, s[u:v], piece[u:v])
    return s, piece


@compiled
def all_subdivided(
    s: Floats, piece: Indices, begins: Indices, loss: Floats, goal: int, finer_begins: Indices
) -> tuple[Floats, Indices]:
    """Finer grids where time is lost; arguments as in `all_divided`, and about how many intervals each shall have."""
    parts = np.ones(len(s), np.int64)
    finer_begins[0] = 0
    for b in range(len(begins) - 1):
        u, v = begins[b], begins[b + 1]
        count = parts_of(loss[u : v - 1], max(goal, v - u - 1), parts[u : v - 1])
        finer_begins[b + 1] = finer_begins[b] + count + 1
    finer, under = np.empty(finer_begins[-1]), np.zeros(finer_begins[-1], np.int64)
    for b in range(len(begins) - 1):
        u, v, f, g = begins[b], begins[b + 1], finer_begins[b], finer_begins[b + 1]
        subdivide_grid(s[u:v], piece[u : v - 1], parts[u : v - 1], finer[f:g], under[f:g])
    return finer, under


@compiled
def end_squares(
    coefficients: Floats, knots: Floats, firsts: Indices, start: Floats, end: Floats
) -> tuple[Floats, Floats]:
    """Squares of the path velocities at both ends; -1 where rest is asked for and the path itself rests there.

    Args:
        coefficients: (pieces, degree + 1, n) of all paths.
        knots, firsts: as in `all_divided`.
        start, end: (paths,) path velocities.
    """
    degree, n = coefficients.shape[1] - 1, coefficients.shape[2]
    squares = start * start, end * end
    for b in range(len(start)):
        first, last = firsts[b], firsts[b + 1] - 1
        h = knots[last + b + 1] - knots[last + b]
        begin = finish = size = 0.0
        for j in range(n):
            slope = 0.0
            for k in range(degree, 0, -1):
                value = coefficients[last, k, j] * k * h ** (k - 1)
                slope, size = slope + value, max(size, abs(value))
            begin, finish = max(begin, abs(coefficients[first, 1, j])), max(finish, abs(slope))
        for velocity, slope, square in ((start, begin, squares[0]), (end, finish, squares[1])):
            if velocity[b] == 0.0 and slope <= GIVEN * size:
                square[b] = -1.0
    return squares


LANES = 8
"""Paths that are timed side by side."""


CAP, LOW, HIGH, X, LENGTH, LOSS = range(6)
"""Lanes of a place: squares of the path velocity; length and loss of the interval that begins there."""


PLACE = 6
"""Lanes of a place."""


STANDING = 1e150
"""Slowness of a joint whose velocity limit is zero."""


WHOLE, STRETCH = 800, 64
"""Intervals of which all rows are kept, and of a stretch of them where there are more."""


LINE = 3
"""Lanes of a row: slope, above and below, each beside those of the interval's other rows."""


class Grids(NamedTuple):
    """Paths of one degree and their grids, one after the other.

    Attributes:
        coefficients: (pieces, degree + 1, n) of all paths.
        knots: (pieces + paths,) of all paths; firsts: (paths + 1,) where each path's pieces begin.
        s: (places,) grids; piece: (places,) of the path under the interval that begins at each place.
        begins: (paths + 1,) where each grid begins.
    """

    coefficients: Floats
    knots: Floats
    firsts: NDArray[np.int64]
    s: Floats
    piece: NDArray[np.int64]
    begins: NDArray[np.int64]


class Asked(NamedTuple):
    """Limits.

    Attributes:
        velocity, acceleration: (paths, 2, n).
        start, end: (paths,) squares of the path velocity; negative where any will do.
        caps: (places,) the largest squares, from elsewhere.
        rows: (2, places - 1, k) alpha and beta of further rows, and bounds: (2, places - 1, k); of one path alone.
    """

    velocity: Floats
    acceleration: Floats
    start: Floats
    end: Floats
    caps: Floats
    rows: Floats
    bounds: Floats


class Found(NamedTuple):
    """What the passes find for all paths, written in place.

    Attributes:
        caps, low, high, x, loss: (places,) as in `timing_problem.Timings`.
        durations, stopped, excess: (paths,); the duration is infinite where the path velocity is zero on a whole
            interval.
    """

    caps: Floats
    low: Floats
    high: Floats
    x: Floats
    loss: Floats
    durations: Floats
    stopped: NDArray[np.int64]
    excess: Floats


class Eight(NamedTuple):
    """Eight paths in lanes.

    Attributes:
        first: of them; here: (8,) where each grid begins; last: (8,) how many intervals each has.
        most: intervals of the longest; stretch: intervals whose rows are kept.
        m, n: degree of du/ds and coordinates; rows: of an interval.
        lengths, start, end: one lane each, numbers of intervals and end velocities squared.
        slowness: 2 n lanes, one over the magnitudes of the velocity limits.
        bounds: 2 n lanes, limits of acceleration; smallness: n lanes, one over the larger of both.
        places: PLACE lanes a place.
        D, shares, lines: (m + 1) n, m + 1 and LINE rows lanes an interval of the stretch; D also of the one before it.
    """

    first: int
    here: NDArray[np.int64]
    last: NDArray[np.int64]
    most: int
    stretch: int
    m: int
    n: int
    rows: int
    lengths: Any
    start: Any
    end: Any
    slowness: Any
    bounds: Any
    smallness: Any
    places: Any
    D: Any
    shares: Any
    lines: Any


@compiled
def eight_of(grids, asked, first, memory):
    """Step 1: what stands in lanes.

    Args:
        grids, asked: of all paths.
        first: of the eight.
        memory: four arrays of `in_lanes`, for places, D, shares and lines.
    """
    count, n = len(asked.start), grids.coefficients.shape[2]
    here, last, ends = np.empty(LANES, np.int64), np.empty(LANES, np.int64), buffer(3)
    limits = in_lanes(5 * n)
    slow, bounds, small, most = seen(limits), part(seen(limits), 2 * n), part(seen(limits), 4 * n), 0
    for lane in range(LANES):
        b = min(first + lane, count - 1)
        here[lane], last[lane] = grids.begins[b], grids.begins[b + 1] - grids.begins[b] - 1
        most = max(most, last[lane])
        put(ends, 0, lane, float(last[lane]))
        put(ends, 1, lane, asked.start[b])
        put(ends, 2, lane, asked.end[b])
        for k in range(2):
            for j in range(n):
                speed = abs(asked.velocity[b, k, j])
                put(slow, k * n + j, lane, 1.0 / speed if speed > 0.0 else STANDING)
                put(bounds, k * n + j, lane, asked.acceleration[b, k, j])
    for j in range(n):
        size = larger(bounds[n + j], -bounds[j])
        small[j] = where(size > 0.0, 1.0 / where(size > 0.0, size, 1.0), FREE)
    places = seen(memory[0])
    for i in range(most + 1):
        for lane in range(LANES):
            put(places, PLACE * i + CAP, lane, asked.caps[here[lane] + min(i, last[lane])])
    m, lengths, start, end = grids.coefficients.shape[1] - 2, ends[0], ends[1], ends[2]
    rows, D, shares, lines = (m + 1) * n + asked.rows.shape[2], seen(memory[1]), seen(memory[2]), seen(memory[3])
    kept = stretch_of(most)
    return limits, Eight(
        first, here, last, most, kept, m, n, rows, lengths, start, end, slow, bounds, small, places, D, shares, lines
    )


@compiled
def stretch_of(most):
    """Of how many intervals rows are kept, if there are so many."""
    return most if most <= WHOLE else STRETCH
