"""Time-optimal timing of many paths, compiled: rows of every interval, both passes, and the proof of what came out.

Imported only where a path is timed: numba is loaded with it.
"""

# pyright: reportMissingParameterType=false, reportUnknownVariableType=false, reportUnknownParameterType=false
# pyright: reportUnknownMemberType=false, reportUnknownArgumentType=false
from __future__ import annotations

from math import sqrt

import numpy as np

from mafsil.solvers.loops import compiled
from mafsil.trajectory.path_rows_loops import (
    acceleration_rows,
    as_lines,
    largest_square,
    slope_controls,
    used_of,
    velocity_caps,
    velocity_shares,
    weights_of,
)
from mafsil.trajectory.reachability_loops import passes
from mafsil.trajectory.tolerances import CORNER

MOST_PARTS = 8
"""Into which one interval is divided at once."""


@compiled
def places_needed(knots, intervals):
    """How many places `divided` writes for a path with these knots."""
    length, count = knots[-1] - knots[0], 1
    for k in range(len(knots) - 1):
        count += max(1, round(intervals * (knots[k + 1] - knots[k]) / length)) if length > 0.0 else 1
    return count


@compiled
def divided(knots, intervals, s, piece):
    """A grid that contains the knots, each piece divided evenly, in place.

    Args:
        knots: (pieces + 1,) of the path.
        intervals: how many for the whole path, at least; every piece gets one.
        s: (places,) path parameters.
        piece: (places - 1,) on which piece of the path each interval lies.
    """
    length, place = knots[-1] - knots[0], 0
    for k in range(len(knots) - 1):
        h = knots[k + 1] - knots[k]
        parts = max(1, round(intervals * h / length)) if length > 0.0 else 1
        for i in range(parts):
            s[place] = knots[k] + h * (i / parts)
            piece[place] = k
            place += 1
    s[place] = knots[-1]


@compiled
def timed(
    coefficients,
    knots,
    s,
    piece,
    slowness,
    acceleration,
    start,
    end,
    caps,
    rows,
    lows,
    highs,
    low,
    high,
    x,
    loss,
    duration,
    work,
    shares,
):
    """The time-optimal velocities along one path and how far they exceed the limits, in place.

    1. Per interval the rows of acceleration and the caps of velocity, each valid everywhere inside; a corner is a stop.
    2. The rows that the caller adds.
    3. Rows as lines; both passes.
    4. The duration, and the largest excess of a Bernstein coefficient over its limit: a bound of every excess.

    Args:
        coefficients: (pieces, degree + 1, n) of the path; n is a multiple of eight, with empty coordinates at the end.
        knots: (pieces + 1,).
        s: (places,) grid; piece: (places - 1,) of the path under each interval.
        slowness: (2, n) one over the magnitudes of the velocity limits; acceleration: (2, n).
        start, end: squares of the path velocity; negative where any will do.
        caps: (places,) the largest squares, from elsewhere; lowered here by the limits of velocity.
        rows: (2, places - 1, k) further alpha and beta, k a multiple of eight; lows, highs: (places - 1, k).
        low, high, x: (places,) receive the sets and the squares of the path velocity.
        loss: (places,) receives for each interval the time that the unused share of the limits at its ends may cost.
        duration: (1,) receives the duration; infinite where the path velocity is zero on a whole interval.
        work, shares: (7, places - 1 or more, (m + 1) n + k) and (places - 1 or more, m + 1, n), written over; m is
            the degree of du/ds.

    Returns:
        -1 or the number of the place that stops the passes; the largest relative excess.
    """
    N, n, m = len(piece), coefficients.shape[2], coefficients.shape[1] - 2
    own, added = (m + 1) * n, rows.shape[2]
    powers, squares = weights_of(m)
    alpha, beta, least, greatest, slope, above, below = (
        work[0, :N],
        work[1, :N],
        work[2, :N],
        work[3, :N],
        work[4, :N],
        work[5, :N],
        work[6, :N],
    )
    D, largest, ending, before, resting = np.empty((m + 1, n)), np.empty(N), np.empty(n), 1.0, True
    # 1.
    for i in range(N):
        h = s[i + 1] - s[i]
        slope_controls(coefficients[piece[i]], s[i] - knots[piece[i]], h, powers, D)
        acceleration_rows(D, h, acceleration, alpha[i], beta[i], least[i], greatest[i])
        largest[i], begin, finish = velocity_shares(D, slowness, shares[i])
        begin, finish = velocity_caps(shares[i], largest[i], begin, finish, h, squares)
        caps[i] = min(caps[i], begin)
        if i and piece[i] != piece[i - 1] and turned(ending, before, D, h):
            caps[i] = 0.0
        ending[:], before = D[m], h
        caps[i + 1] = min(caps[i + 1], finish)
        # 2.
        for k in range(added):
            alpha[i, own + k], beta[i, own + k] = rows[0, i, k], rows[1, i, k]
            least[i, own + k], greatest[i, own + k] = lows[i, k], highs[i, k]
            resting &= lows[i, k] <= 0.0 <= highs[i, k]
    if largest.max() == 0.0 and not np.abs(alpha).any():
        low[:], high[:], x[:], loss[:], duration[0] = 0.0, 0.0, 0.0, 0.0, 0.0
        return -1, 0.0
    # 3.
    for i in range(N):
        most = as_lines(alpha[i], beta[i], least[i], greatest[i], caps[i + 1], slope[i], above[i], below[i])
        caps[i] = min(caps[i], most)
    stopped = passes(slope, above, below, caps, start, end, resting, low, high, x)
    duration[0] = np.inf
    if stopped >= 0:
        return stopped, np.inf
    # 4.
    total = excess = 0.0
    for i in range(N):
        h = s[i + 1] - s[i]
        passing = 2.0 * h / (sqrt(x[i]) + sqrt(x[i + 1]))
        total += passing
        used, over = used_of(alpha[i], beta[i], least[i], greatest[i], shares[i], h, x[i], x[i + 1], added)
        loss[i], excess = passing * max(1.0 - used, 0.0), max(excess, over)
        if largest[i] * largest[i] * max(x[i], x[i + 1]) > h * h:
            reached = largest_square(shares[i], x[i] / h / h, x[i + 1] / h / h, squares)
            excess = max(excess, sqrt(reached) - 1.0)
    duration[0] = total
    return stopped, excess


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
def subdivided(s, piece, parts, finer, under):
    """A grid whose intervals are divided, in place; arguments as in `divided`, and how many parts each gets."""
    place = 0
    for i in range(len(piece)):
        for k in range(parts[i]):
            finer[place] = s[i] + (s[i + 1] - s[i]) * (k / parts[i])
            under[place] = piece[i]
            place += 1
    finer[place] = s[-1]


@compiled
def turned(ending, before, D, h):
    """Whether the direction of the path jumps where one interval ends and the next begins.

    Args:
        ending: (n) change of the coordinates at the end of the interval, over its parameter 0 .. 1.
        before: length of that interval.
        D: (degree, n) Bernstein coefficients of the change over the next interval.
        h: length of the next interval.
    """
    size = jump = 0.0
    for j in range(len(ending)):
        last, first = ending[j] / before, D[0, j] / h
        size = max(size, abs(first), abs(last))
        jump = max(jump, abs(first - last))
    return jump > CORNER * size


@compiled
def all_timed(
    coefficients,
    knots,
    firsts,
    s,
    piece,
    begins,
    slowness,
    acceleration,
    start,
    end,
    caps,
    low,
    high,
    x,
    loss,
    durations,
):
    """`timed` for paths one after the other; of each the place that stops it, and the excess.

    Args:
        coefficients: (pieces, degree + 1, n) of all paths; firsts: (paths + 1,) where each begins.
        knots: (pieces + paths,) of all paths.
        s, caps, low, high, x, loss: (places,) of all paths; begins: (paths + 1,) where each begins.
        piece: (places,) of the path under the interval that begins at each place.
        slowness, acceleration: (paths, 2, n); start, end: (paths,).
        durations: (paths,) receives the durations.
    """
    count = len(durations)
    stopped, excess = np.empty(count, np.int64), np.empty(count)
    none, nowhere = np.empty((2, 1, 0)), np.empty((1, 0))
    most, (degree, n) = np.diff(begins).max(), coefficients.shape[1:]
    work, shares = np.empty((7, most, (degree - 1) * n)), np.empty((most, degree - 1, n))
    for b in range(count):
        u, v, f, g = begins[b], begins[b + 1], firsts[b], firsts[b + 1]
        stopped[b], excess[b] = timed(
            coefficients[f:g],
            knots[f + b : g + b + 1],
            s[u:v],
            piece[u : v - 1],
            slowness[b],
            acceleration[b],
            start[b],
            end[b],
            caps[u:v],
            none,
            nowhere,
            nowhere,
            low[u:v],
            high[u:v],
            x[u:v],
            loss[u:v],
            durations[b : b + 1],
            work,
            shares,
        )
    return stopped, excess


@compiled
def all_divided(knots, firsts, intervals, begins):
    """A grid for each of many paths: path parameters, and the path piece under each interval.

    Args:
        knots, firsts: as in `all_timed`.
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
        divided(knots[f + b : g + b + 1], intervals, s[u:v], piece[u:v])
    return s, piece


@compiled
def all_subdivided(s, piece, begins, loss, goal, finer_begins):
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
        subdivided(s[u:v], piece[u : v - 1], parts[u : v - 1], finer[f:g], under[f:g])
    return finer, under
