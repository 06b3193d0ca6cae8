"""Timing under limits that are no polynomials of the path parameter: imposed, measured between, tightened, repeated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.mechanics.friction import SMOOTHING
from mafsil.trajectory.path import JointPath, PathPoint
from mafsil.trajectory.timing.sampled_limits import SampledLimit
from mafsil.trajectory.timing.timing_problem import (
    FurtherRows,
    Grid,
    Timing,
    TimingProblem,
    flatten_paths,
    solve_timing,
    time_on_grids,
)

PLACES = (0.0, 0.5, 1.0)
"""Of an interval, at which limits are imposed."""
BETWEEN = (0.0, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0)
"""Of an interval, at which they are measured."""
INTERVALS = 300
"""Of the grid, if none are given."""
LEVELS = np.array([-6.0, -4.0, -3.0, -2.0, -1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0])
"""Rates of a joint, in units of SMOOTHING, at which its friction is measured: it changes its sign between them."""
NEAR = 0.02
"""Share of a limit from it at which the peak between two places is looked for."""
GOLDEN, SECTIONS = (5.0**0.5 - 1.0) / 2.0, 18
"""Ratio of the golden section, and how often: a bracket shrinks to 2e-4 of itself, the peak is known to its square."""
MOST_ROUNDS, MORE_ROUNDS = 14, 40
"""From the fastest motion; from slower ones, which grow from round to round."""
FASTEST, SLOWEST, SLOWER = 1e8, 1e-8, 8.0
"""Squares of the path velocity about which friction is linearised where faster ones fail, and the step between them."""
ALLOWED = 1e-6
"""Excess, as share of a limit, that is left."""
MARGIN = 2e-4
"""Share of a sampled limit that is left free from the start: what measuring at places may miss between them."""
SETTLED = 1e-5
"""Relative change of the duration below which friction is linearised well enough."""
GROWTH = 1.3
"""By how much the square of the path velocity may grow from round to round: friction is bounded up to there."""


def timed_within(problem: TimingProblem, sampled: Sequence[SampledLimit]) -> Timing:
    """The timing of one path under sampled limits besides those of velocity and acceleration.

    1. The timing under velocity and acceleration alone: no other is faster anywhere.
    2. The sampled limits at PLACES of each interval, friction linearised about the last timing; passes.
    3. The motion measured BETWEEN; where it exceeds a limit, that interval's limit is lowered by the excess.
    4. Again from 2, until nothing exceeds and the duration settles.
    5. Where that fails it begins anew about slower motions: friction that is linearised about a velocity that the
       efforts do not allow leaves no room at rest. Only what fails about the slowest, too, is answered by failure.
    """
    # 1.
    first = replace(problem, intervals=problem.intervals or INTERVALS)
    fastest = solve_timing(first)[0]
    if fastest.stopped >= 0 or fastest.duration == 0.0:
        return fastest
    failed = _rounds(first, fastest, fastest, sampled)
    if _is_timed(failed):
        return failed
    # 5.
    square = min(float(fastest.x.max()), FASTEST)
    while square > SLOWEST:
        slower = replace(fastest, x=np.minimum(fastest.x, square))
        found = _rounds(first, fastest, slower, sampled)
        if _is_timed(found):
            return found
        square /= SLOWER
    return failed


def _is_timed(timing: Timing) -> bool:
    """Whether a timing leads to the end within all limits."""
    return timing.stopped < 0 and np.isfinite(timing.duration) and timing.excess <= ALLOWED


def _rounds(first: TimingProblem, fastest: Timing, about: Timing, sampled: Sequence[SampledLimit]) -> Timing:
    """2. to 4., with friction linearised about a timing at first."""
    path, timing = first.paths[0], about
    slack, duration = [np.full(1, MARGIN)] * len(sampled), np.inf
    best: Timing | None = None
    rounds = MOST_ROUNDS if about is fastest else MORE_ROUNDS
    for count in range(1, rounds + 1):
        # 2.
        rows = _rows(path, timing, fastest, sampled, slack)
        most = fastest.x * (1.0 + 1e-9)
        if count > 1 or about is not fastest:
            most = np.minimum(most, GROWTH * timing.x + 1e-12 * timing.x.max())
        timing = _passes(first, timing, FurtherRows(most, *rows))
        if timing.stopped >= 0 or not np.isfinite(timing.duration):
            return best or timing
        # 3.
        excess = _excess(path, timing, sampled)
        worst = max(float(part.max()) for part in excess)
        timing = replace(timing, excess=max(timing.excess, worst))
        slack = [old + np.maximum(part, 0.0) * 1.1 for old, part in zip(slack, excess, strict=True)]
        # 4.
        if worst <= ALLOWED and (best is None or timing.duration < best.duration):
            best = timing
        if worst <= ALLOWED and abs(timing.duration - duration) <= SETTLED * timing.duration:
            break
        duration = timing.duration
    return best or timing


def _inside(path: JointPath, timing: Timing, r: float | Floats, k: NDArray[np.int64] | None = None) -> PathPoint:
    """The path at shares r of intervals k, or of all, their ends seen from inside."""
    begin, end = (timing.s[:-1], timing.s[1:]) if k is None else (timing.s[k], timing.s[k + 1])
    return path.at(np.clip(begin + r * (end - begin), begin, np.nextafter(end, 0.0)))


def _rows(
    path: JointPath, timing: Timing, fastest: Timing, sampled: Sequence[SampledLimit], slack: list[Floats]
) -> tuple[Floats, Floats]:
    """Rows (2, intervals, k) of alpha and beta, and their bounds (2, intervals, k).

    x is linear: A u + B x = (B (1 - r) - A/(2 h)) x_i + (B r + A/(2 h)) x_{i+1}.
    """
    double = 2.0 * np.diff(timing.s)[:, None]
    alphas: list[Floats] = []
    betas: list[Floats] = []
    lows: list[Floats] = []
    highs: list[Floats] = []
    ends = np.stack([_inside(path, timing, r).slope for r in (0.0, 1.0)])
    for r in PLACES:
        here = _inside(path, timing, r)
        about = (1.0 - r) * timing.x[:-1] + r * timing.x[1:]
        most = np.minimum(GROWTH * about, (1.0 - r) * fastest.x[:-1] + r * fastest.x[1:])
        for limit, less in zip(sampled, slack, strict=True):
            rows = limit.rows(here, about, most, ends)
            alphas.append(rows.B * (1.0 - r) - rows.A / double)
            betas.append(rows.B * r + rows.A / double)
            lower = less * np.where(less > 0.0, limit.scale(), 0.0)
            # What has no bound has nothing to be lowered.
            lows.append(rows.low + np.where(np.isfinite(rows.low), lower, 0.0))
            highs.append(rows.high - np.where(np.isfinite(rows.high), lower, 0.0))
    return (
        np.stack([np.concatenate(alphas, axis=1), np.concatenate(betas, axis=1)]),
        np.stack([np.concatenate(lows, axis=1), np.concatenate(highs, axis=1)]),
    )


def _excess(path: JointPath, timing: Timing, sampled: Sequence[SampledLimit]) -> list[Floats]:
    """Of each limit (intervals, k) the largest excess in each interval.

    1. At the places BETWEEN, and where a joint is nearly at rest: friction changes its sign there within SMOOTHING.
    2. Where that comes NEAR to a limit, the peak between the two places beside it, by golden sections.
    """
    # 1.
    N, u = len(timing.piece), np.diff(timing.x) / (2.0 * np.diff(timing.s))
    slow, shares = _nearly_at_rest(path, timing)
    k = np.concatenate([np.repeat(np.arange(N), len(BETWEEN)), slow])
    r = np.concatenate([np.tile(BETWEEN, N), shares])
    order = np.lexsort((r, k))
    k, r = k[order], r[order]
    first = np.searchsorted(k, np.arange(N))
    found: list[Floats] = []
    for limit in sampled:
        values = _measure(path, timing, limit, k, r, u)
        worst: Floats = np.maximum.reduceat(values, first, axis=0)
        # 2.
        place, column = np.nonzero((values == worst[k]) & (values > -NEAR))
        before = np.where(place > first[k[place]], r[np.maximum(place - 1, 0)], r[place])
        last = np.append(first[1:], len(k))[k[place]] - 1
        after = np.where(place < last, r[np.minimum(place + 1, len(r) - 1)], r[place])
        peaks = _peaks(path, timing, limit, k[place], column, before, after, u)
        np.maximum.at(worst, (k[place], column), peaks)
        found.append(worst)
    return found


def _peaks(
    path: JointPath,
    timing: Timing,
    limit: SampledLimit,
    k: NDArray[np.int64],
    column: NDArray[np.int64],
    low: Floats,
    high: Floats,
    u: Floats,
) -> Floats:
    """The largest excess of one column each between shares low and high of the intervals k."""

    def excess(r: Floats) -> Floats:
        return np.take_along_axis(_measure(path, timing, limit, k, r, u), column[:, None], axis=1)[:, 0]

    best = np.full(len(k), -np.inf)
    left, right = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    for _ in range(SECTIONS):
        at_left, at_right = excess(left), excess(right)
        best = np.maximum(best, np.maximum(at_left, at_right))
        rising = at_left < at_right
        low, high = np.where(rising, left, low), np.where(rising, high, right)
        left, right = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    return best


def _measure(
    path: JointPath, timing: Timing, limit: SampledLimit, k: NDArray[np.int64], r: Floats, u: Floats
) -> Floats:
    """The excess (places, columns) at shares r of the intervals k."""
    here = _inside(path, timing, r, k)
    return limit.excess(here, (1.0 - r) * timing.x[k] + r * timing.x[k + 1], u[k])


def _nearly_at_rest(path: JointPath, timing: Timing) -> tuple[NDArray[np.int64], Floats]:
    """Intervals and shares of them at which a joint's rate passes one of LEVELS.

    Between two places a rate is nearly linear where the joint turns, and its square where the motion begins or ends:
    both guesses are looked at.
    """
    places = np.array(BETWEEN)
    rates = np.stack(
        [
            _inside(path, timing, r).slope * np.sqrt((1.0 - r) * timing.x[:-1] + r * timing.x[1:])[:, None]
            for r in BETWEEN
        ]
    )
    found: list[NDArray[np.int64]] = []
    shares: list[Floats] = []
    for values, levels in (
        (rates, LEVELS * SMOOTHING),
        (rates * np.abs(rates), LEVELS * np.abs(LEVELS) * SMOOTHING**2),
    ):
        before, after = values[:-1, :, :, None] - levels, values[1:, :, :, None] - levels
        part, k, j, level = np.nonzero((before * after <= 0.0) & (before != after))
        first, last = before[part, k, j, level], after[part, k, j, level]
        shares.append(places[part] + (places[part + 1] - places[part]) * first / (first - last))
        found.append(k)
    return np.concatenate(found), np.concatenate(shares)


def _passes(problem: TimingProblem, timing: Timing, further: FurtherRows) -> Timing:
    """Both passes with further rows, on the same grid."""
    # A grid has a piece under each place; the last one's does not count.
    grid = Grid(timing.s, np.append(timing.piece, 0), np.array([0, len(timing.s)]))
    start, end = (
        np.where((timing.x[k] > 0.0) & (v == 0.0), -1.0, v**2) for k, v in ((0, problem.start), (-1, problem.end))
    )
    limits = problem.velocity, problem.acceleration
    return time_on_grids(flatten_paths(problem.paths), grid, limits, (start, end), further)[0]
