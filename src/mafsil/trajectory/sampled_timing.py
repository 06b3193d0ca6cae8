"""Timing under limits that are no polynomials of the path parameter: imposed, measured between, tightened, repeated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.lazy_module import lazily
from mafsil.mechanics.friction import SMOOTHING
from mafsil.trajectory.path import JointPath, PathPoint
from mafsil.trajectory.sampled_limits import SampledLimit
from mafsil.trajectory.timing_problem import (
    Timing,
    TimingProblem,
    bounds_in_eights,
    flattened,
    in_eights,
    slowness_of,
    solved,
)

if TYPE_CHECKING:
    import mafsil.trajectory.path_timing_loops as path_timing_loops
else:
    path_timing_loops = lazily("mafsil.trajectory.path_timing_loops")

PLACES = (0.0, 0.5, 1.0)
"""Of an interval, at which limits are imposed."""
BETWEEN = (0.0, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0)
"""Of an interval, at which they are measured."""
INTERVALS = 300
"""Of the grid, if none are given."""
AROUND = (-6.0, -3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 6.0)
"""Where about a joint's turn friction is measured, in widths of its change of sign."""
MOST_ROUNDS = 14
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
    """
    # 1.
    first = replace(problem, intervals=problem.intervals or INTERVALS)
    timing = fastest = solved(first)[0]
    path = problem.paths[0]
    if timing.stopped >= 0 or timing.duration == 0.0:
        return timing
    slack, duration = [np.full(1, MARGIN)] * len(sampled), np.inf
    best: Timing | None = None
    for count in range(1, MOST_ROUNDS + 1):
        # 2.
        rows = _rows(path, timing, fastest, sampled, slack)
        most = np.minimum(
            fastest.x * (1.0 + 1e-9), np.inf if count == 1 else GROWTH * timing.x + 1e-12 * timing.x.max()
        )
        timing = _passes(first, timing, most, *rows)
        if timing.stopped >= 0 or not np.isfinite(timing.duration):
            return timing
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
) -> tuple[Floats, Floats, Floats]:
    """Rows (2, intervals, k) of alpha and beta, and their bounds (intervals, k).

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
        np.concatenate(lows, axis=1),
        np.concatenate(highs, axis=1),
    )


def _excess(path: JointPath, timing: Timing, sampled: Sequence[SampledLimit]) -> list[Floats]:
    """Of each limit (intervals, k) the largest excess in each interval.

    1. At the places BETWEEN; where one in the middle is the largest, the peak of the parabola through three.
    2. About the places where a joint turns, for friction changes its sign there within SMOOTHING.
    """
    N, u = len(timing.piece), np.diff(timing.x) / (2.0 * np.diff(timing.s))
    found: list[Floats] = []
    turns, shares = _turns(path, timing)
    for limit in sampled:
        # 1.
        parts = [_measured(path, timing, limit, np.arange(N), np.full(N, r), u) for r in BETWEEN]
        values = np.array(parts)
        before, peak, after = values[:-2], values[1:-1], values[2:]
        bend = 2.0 * peak - before - after
        inner = (peak >= before) & (peak >= after) & (bend > 0.0)
        rise = np.divide((after - before) ** 2, 8.0 * bend, out=np.zeros_like(bend), where=inner)
        worst = np.maximum(values.max(axis=0), (peak + rise).max(axis=0))
        # 2.
        if len(turns):
            np.maximum.at(worst, turns, _measured(path, timing, limit, turns, shares, u))
        found.append(worst)
    return found


def _measured(
    path: JointPath, timing: Timing, limit: SampledLimit, k: NDArray[np.int64], r: Floats, u: Floats
) -> Floats:
    """The excess (places, columns) at shares r of the intervals k."""
    here = _inside(path, timing, r, k)
    return limit.excess(here, (1.0 - r) * timing.x[k] + r * timing.x[k + 1], u[k])


def _turns(path: JointPath, timing: Timing) -> tuple[NDArray[np.int64], Floats]:
    """Intervals in which a joint turns, and shares of them before and after it does."""
    begin, end = (_inside(path, timing, r).slope for r in (0.0, 1.0))
    k, j = np.nonzero(begin * end < 0.0)
    where = begin[k, j] / (begin[k, j] - end[k, j])
    speed = np.abs(end - begin)[k, j] * np.sqrt(np.maximum(timing.x[k], timing.x[k + 1]))
    width = np.minimum(SMOOTHING / np.maximum(speed, 1e-300), 0.1)
    shares = np.clip(where[:, None] + width[:, None] * np.array(AROUND), 0.0, 1.0)
    return np.repeat(k, len(AROUND)), shares.ravel()


def _passes(problem: TimingProblem, timing: Timing, most: Floats, rows: Floats, lows: Floats, highs: Floats) -> Timing:
    """Both passes with further rows, on the same grid."""
    flat = flattened(problem.paths)
    caps, duration = most.copy(), np.empty(1)
    _, degree, n = flat.coefficients.shape
    low, high, x, loss = np.zeros((4, len(timing.s)))
    start, end = (
        -1.0 if timing.x[k] > 0.0 and v[0] == 0.0 else v[0] ** 2 for k, v in ((0, problem.start), (-1, problem.end))
    )
    stopped, excess = path_timing_loops.timed(  # pyright: ignore[reportUnknownMemberType]
        flat.coefficients,
        flat.knots,
        timing.s,
        timing.piece,
        in_eights(slowness_of(problem.velocity)[0]),
        bounds_in_eights(problem.acceleration[0]),
        float(start),
        float(end),
        caps,
        in_eights(rows),
        in_eights(lows, -np.inf),
        in_eights(highs, np.inf),
        low,
        high,
        x,
        loss,
        duration,
        np.empty((7, len(timing.piece), (degree - 1) * n + rows.shape[2] + -rows.shape[2] % 8)),
        np.empty((len(timing.piece), degree - 1, n)),
    )
    return Timing(timing.s, timing.piece, caps, low, high, x, float(duration[0]), int(stopped), float(excess))
