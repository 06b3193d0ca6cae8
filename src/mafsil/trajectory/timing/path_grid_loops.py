"""Grids of many paths, compiled: even ones, and finer ones where time is lost."""

# pyright: reportMissingParameterType=false, reportUnknownVariableType=false, reportUnknownParameterType=false
# pyright: reportUnknownMemberType=false, reportUnknownArgumentType=false
from __future__ import annotations

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.kernels.loops.loop import compiled
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
