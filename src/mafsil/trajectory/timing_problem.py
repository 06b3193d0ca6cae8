"""Paths with their limits, flattened for the compiled passes: what is asked of a time-optimal timing, and what came."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.lazy_module import lazily
from mafsil.trajectory.motion_limits import MotionLimits
from mafsil.trajectory.path import JointPath

if TYPE_CHECKING:
    import mafsil.trajectory.path_timing_loops as path_timing_loops
else:
    path_timing_loops = lazily("mafsil.trajectory.path_timing_loops")

FREE = 1e300
"""Squared path velocity where nothing limits it."""
STANDING = 1e150
"""Slowness of a joint whose velocity limit is zero."""
ROUNDS = (100, 250, 600)
"""Intervals of the grids one after the other, each finer where the one before loses time."""
AT_REST = 1e-9
"""Slope at an end of a path, as share of its largest control value, at which the joints rest at any path velocity."""


@dataclass(frozen=True, eq=False, slots=True)
class TimingProblem:
    """Paths of equally many coordinates, the limits of each, and the path velocities at their ends.

    Attributes:
        paths: one or many.
        velocity, acceleration: (paths, 2, n) lower and upper limits of each path.
        start, end: (paths,) path velocities.
        intervals: of each grid; None for grids that become finer where time is lost.
    """

    paths: Sequence[JointPath]
    velocity: Floats
    acceleration: Floats
    start: Floats
    end: Floats
    intervals: int | None

    def of(self, b: int) -> TimingProblem:
        """The problem of one of the paths."""
        one = slice(b, b + 1)
        velocity, acceleration = self.velocity[one], self.acceleration[one]
        return TimingProblem(self.paths[one], velocity, acceleration, self.start[one], self.end[one], self.intervals)


@dataclass(frozen=True, eq=False, slots=True)
class Timing:
    """What the passes found for one path.

    Attributes:
        s: (places,) grid of the path parameter.
        piece: (places - 1,) the path's piece under each interval.
        caps: (places,) the largest squares of the path velocity that velocities allow.
        low, high: (places,) the squares from which the end can be reached.
        x: (places,) the squares of the time-optimal path velocity.
        duration: [s].
        stopped: -1, or the number of the place that stops the passes.
        excess: the largest excess over a limit, as share of it.
    """

    s: Floats
    piece: NDArray[np.int64]
    caps: Floats
    low: Floats
    high: Floats
    x: Floats
    duration: float
    stopped: int
    excess: float


@dataclass(frozen=True, eq=False, slots=True)
class FlatPaths:
    """The polynomials of many paths in one array.

    Attributes:
        coefficients: (pieces, degree + 1, 8 w) of all paths, of one degree, with empty coordinates at the end.
        knots: (pieces + paths,) of all paths.
        firsts: (paths + 1,) where each path's pieces begin.
    """

    coefficients: Floats
    knots: Floats
    firsts: NDArray[np.int64]


@dataclass(frozen=True, eq=False, slots=True)
class Timings:
    """What the passes found for many paths, in flat arrays; indexed by the path."""

    begins: NDArray[np.int64]
    s: Floats
    piece: NDArray[np.int64]
    caps: Floats
    low: Floats
    high: Floats
    x: Floats
    loss: Floats
    durations: Floats
    stopped: NDArray[np.int64]
    excess: Floats

    def __getitem__(self, b: int) -> Timing:
        u, v = int(self.begins[b]), int(self.begins[b + 1])
        return Timing(
            self.s[u:v],
            self.piece[u : v - 1],
            self.caps[u:v],
            self.low[u:v],
            self.high[u:v],
            self.x[u:v],
            float(self.durations[b]),
            int(self.stopped[b]),
            float(self.excess[b]),
        )


def flattened(paths: Sequence[JointPath]) -> FlatPaths:
    """The polynomials of paths one after the other."""
    rows = [path.curve.coefficients for path in paths]
    counts = np.array([len(row) for row in rows])
    firsts = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    knots = np.concatenate([path.curve.knots for path in paths])
    n, degree = paths[0].n, max(2, *(row.shape[1] for row in rows)) - 1
    flat = np.zeros((firsts[-1], degree + 1, n + -n % 8))
    if all(row.shape[1] == degree + 1 for row in rows):
        flat[..., :n] = np.concatenate(rows) if len(rows) > 1 else rows[0]
    else:
        for first, row in zip(firsts, rows, strict=False):
            flat[first : first + len(row), : row.shape[1], :n] = row
    return FlatPaths(flat, knots, firsts)


def solved(problem: TimingProblem) -> Timings:
    """Both passes over all paths.

    1. Even grids; or coarse ones, divided where their time is lost, as often as ROUNDS says.
    2. Limits as slowness; the squares of the path velocities at the ends, free where the joints rest at any of them.
    """
    flat, loops = flattened(problem.paths), path_timing_loops
    count = len(problem.paths)
    rounds = ROUNDS if problem.intervals is None else (problem.intervals,)
    # 2.
    slowness, acceleration = in_eights(slowness_of(problem.velocity)), bounds_in_eights(problem.acceleration)
    start, end = _squares(flat, problem)
    # 1.
    begins = np.empty(count + 1, np.int64)
    s, piece = loops.all_divided(flat.knots, flat.firsts, rounds[0], begins)
    found = _timed(flat, s, piece, begins, slowness, acceleration, start, end)
    for goal in rounds[1:]:
        finer = np.empty_like(begins)
        loss = np.where(np.isfinite(found.loss), found.loss, 0.0)
        s, piece = loops.all_subdivided(found.s, found.piece, found.begins, loss, goal, finer)
        found = _timed(flat, s, piece, finer, slowness, acceleration, start, end)
    return found


def slowness_of(velocity: Floats) -> Floats:
    """One over the magnitudes of velocity limits: 0 where there is none, large where it is zero."""
    size = np.abs(velocity)
    return np.divide(1.0, size, out=np.full(size.shape, STANDING), where=size > 0.0)


def bounds_in_eights(acceleration: Floats) -> Floats:
    """Lower and upper limits (..., 2, 8 w); those of empty coordinates are infinite."""
    missing = -acceleration.shape[-1] % 8
    endless = np.broadcast_to(np.array([[-np.inf], [np.inf]]), (*acceleration.shape[:-1], missing))
    return np.concatenate([acceleration, endless], axis=-1)


def limits_of_each(limits: MotionLimits, count: int) -> tuple[Floats, Floats]:
    """(count, 2, n) limits of velocity and of acceleration."""
    shape = (count, *limits.velocity.shape)
    return np.broadcast_to(limits.velocity, shape), np.broadcast_to(limits.acceleration, shape).copy()


def _timed(
    flat: FlatPaths,
    s: Floats,
    piece: NDArray[np.int64],
    begins: NDArray[np.int64],
    slowness: Floats,
    acceleration: Floats,
    start: Floats,
    end: Floats,
) -> Timings:
    caps, durations = np.full(len(s), FREE), np.empty(len(start))
    low, high, x, loss = np.zeros((4, len(s)))
    stopped, excess = path_timing_loops.all_timed(  # pyright: ignore[reportUnknownMemberType]
        flat.coefficients,
        flat.knots,
        flat.firsts,
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
    )
    return Timings(begins, s, piece, caps, low, high, x, loss, durations, stopped, excess)


def _squares(flat: FlatPaths, problem: TimingProblem) -> tuple[Floats, Floats]:
    """Squares of the path velocities at both ends; -1 where rest is asked for and the path itself rests there."""
    first, last = flat.firsts[:-1], flat.firsts[1:] - 1
    powers = np.arange(1.0, flat.coefficients.shape[1])
    h = (flat.knots[1:] - flat.knots[:-1])[last + np.arange(len(last))]
    begin = flat.coefficients[first, 1]
    rows = flat.coefficients[last, 1:] * powers[:, None] * h[:, None, None] ** (powers[:, None] - 1)
    finish, size = rows.sum(axis=1), np.abs(rows).max(axis=(1, 2))
    squares: list[Floats] = []
    for velocity, slope in ((problem.start, begin), (problem.end, finish)):
        resting = (velocity == 0.0) & (np.abs(slope).max(axis=1) <= AT_REST * size)
        squares.append(np.where(resting, -1.0, velocity**2))
    return squares[0], squares[1]


def in_eights(rows: Floats, empty: float = 0.0) -> Floats:
    """The last axis made a multiple of eight long, for loops that take eight numbers at once."""
    missing = -rows.shape[-1] % 8
    out = np.full((*rows.shape[:-1], rows.shape[-1] + missing), empty)
    out[..., : rows.shape[-1]] = rows
    return out
