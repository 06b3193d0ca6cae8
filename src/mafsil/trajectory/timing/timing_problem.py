"""Paths with their limits, flattened for the compiled passes: what is asked of a time-optimal timing, and what came.

A first motion along a path whose jerk is finite: the fastest one without limits of jerk, smoothed in time.

Its path velocity is a quadratic spline with coefficients that are never negative, so it only moves forwards; at both
ends velocity and acceleration are zero.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mafsil import threads
from mafsil.arrays import Floats
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.lazy_module import lazily
from mafsil.trajectory.motion_limits import MotionLimits
from mafsil.trajectory.path import JointPath
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial

if TYPE_CHECKING:
    import mafsil.trajectory.timing.lane_timing_loops as lane_timing_loops
    import mafsil.trajectory.timing.path_grid_loops as path_grid_loops
else:
    lane_timing_loops = lazily("mafsil.trajectory.timing.lane_timing_loops")
    path_grid_loops = lazily("mafsil.trajectory.timing.path_grid_loops")


FREE = 1e300
"""Squared path velocity where nothing limits it."""
ROUNDS = (100, 250, 600)
"""Intervals of the grids one after the other, each finer where the one before loses time."""
PART = 32
"""Paths that one thread times at a time, a multiple of the lanes."""


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
        coefficients: (pieces, degree + 1, n) of all paths, of one degree.
        knots: (pieces + paths,) of all paths.
        firsts: (paths + 1,) where each path's pieces begin.
    """

    coefficients: Floats
    knots: Floats
    firsts: NDArray[np.int64]


@dataclass(frozen=True, eq=False, slots=True)
class Grid:
    """Grids of many paths, one after the other.

    Attributes:
        s: (places,) path parameters.
        piece: (places,) of the path under the interval that begins at each place.
        begins: (paths + 1,) where each grid begins.
    """

    s: Floats
    piece: NDArray[np.int64]
    begins: NDArray[np.int64]


@dataclass(frozen=True, eq=False, slots=True)
class FurtherRows:
    """What is asked of one path besides limits of velocity and acceleration.

    Attributes:
        caps: (places,) the largest squares of the path velocity.
        rows: (2, intervals, k) alpha and beta of rows  low <= alpha x_i + beta x_{i+1} <= high.
        bounds: (2, intervals, k) low and high.
    """

    caps: Floats
    rows: Floats
    bounds: Floats


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


def flatten_paths(paths: Sequence[JointPath]) -> FlatPaths:
    """The polynomials of paths one after the other."""
    if len(paths) == 1 and paths[0].curve.degree >= 1:
        curve = paths[0].curve
        # Copies, for loops are compiled anew for arrays that may not be written.
        return FlatPaths(curve.coefficients.copy(), curve.knots.copy(), np.array([0, len(curve.coefficients)]))
    rows = [path.curve.coefficients for path in paths]
    counts = np.array([len(row) for row in rows])
    firsts = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    knots = np.concatenate([path.curve.knots for path in paths])
    n, degree = paths[0].n, max(2, *(row.shape[1] for row in rows)) - 1
    flat = np.zeros((firsts[-1], degree + 1, n))
    if all(row.shape[1] == degree + 1 for row in rows):
        np.concatenate(rows, out=flat)
    else:
        for first, row in zip(firsts, rows, strict=False):
            flat[first : first + len(row), : row.shape[1]] = row
    return FlatPaths(flat, knots, firsts)


def solve_timing(problem: TimingProblem) -> Timings:
    """Both passes over all paths, on even grids; or on coarse ones, divided where time is lost, as ROUNDS says."""
    flat, limits = flatten_paths(problem.paths), (problem.velocity, problem.acceleration)
    ends = path_grid_loops.end_squares(flat.coefficients, flat.knots, flat.firsts, problem.start, problem.end)
    first, *goals = ROUNDS if problem.intervals is None else (problem.intervals,)
    begins = np.empty(len(problem.paths) + 1, np.int64)
    s, piece = path_grid_loops.all_divided(flat.knots, flat.firsts, first, begins)
    # A grid that has as many intervals as are wanted would come out of a round as it went in.
    goals = [goal for goal in goals if goal >= np.diff(begins).min()]
    found = time_on_grids(flat, Grid(s, piece, begins), limits, ends, finer=bool(goals))
    for round_, goal in enumerate(goals, 1):
        begins = np.empty_like(begins)
        loss = np.where(np.isfinite(found.loss), found.loss, 0.0)
        s, piece = path_grid_loops.all_subdivided(found.s, found.piece, found.begins, loss, goal, begins)
        found = time_on_grids(flat, Grid(s, piece, begins), limits, ends, finer=round_ < len(goals))
    return found


def limits_of_each(limits: MotionLimits, count: int) -> tuple[Floats, Floats]:
    """(count, 2, n) limits of velocity and of acceleration."""
    if count == 1:
        return limits.velocity[None].copy(), limits.acceleration[None].copy()
    return np.tile(limits.velocity, (count, 1, 1)), np.tile(limits.acceleration, (count, 1, 1))


def time_on_grids(
    flat: FlatPaths,
    grid: Grid,
    limits: tuple[Floats, Floats],
    ends: tuple[Floats, Floats],
    further: FurtherRows | None = None,
    *,
    finer: bool = False,
) -> Timings:
    """Both passes on given grids, eight paths at a time; the work is divided among threads.

    Args:
        flat: the paths.
        grid: of all of them.
        limits: of velocity and of acceleration, (paths, 2, n).
        ends: squares of the path velocity at start and end, (paths,), negative where any will do.
        further: more rows, of one path alone.
        finer: whether a finer grid is to come, for which losses are needed.
    """
    paths, places = len(ends[0]), len(grid.s)
    given = further or FurtherRows(np.full(places, FREE), np.empty((2, places, 0)), np.empty((2, places, 0)))
    caps, (low, high, x, loss) = given.caps.copy(), np.zeros((4, places))
    durations, stopped, excess = np.empty(paths), np.empty(paths, np.int64), np.empty(paths)
    grids = path_grid_loops.Grids(flat.coefficients, flat.knots, flat.firsts, grid.s, grid.piece, grid.begins)
    asked = path_grid_loops.Asked(*limits, *ends, given.caps, given.rows, given.bounds)
    found = path_grid_loops.Found(caps, low, high, x, loss, durations, stopped, excess)

    def part(k: int) -> None:
        lane_timing_loops.lanes_timed(grids, asked, k * PART, min((k + 1) * PART, paths), finer, found)

    threads.run(part, -(-paths // PART), threads.available())
    return Timings(grid.begins, grid.s, grid.piece, *found)


SHARES = (0.0, 0.5, 1.0)
"""Of each piece, where what is imposed is looked at."""


def smooth_timing(timing: Timing, width: float, pieces: int) -> PiecewisePolynomial:
    """s(tau) of a timing from rest to rest whose path velocity is averaged over a window; it takes as much longer.

    1. Knots, half of them evenly in time, half by the variation of the averaged acceleration: close in its ramps.
    2. The average at the abscissae of the spline's coefficients: differences of the position over the window.
    3. The spline with these coefficients, zero at both ends with its slope; its integral, scaled to the whole path.

    Args:
        timing: without limits of jerk.
        width: of the window [s].
        pieces: of the result.
    """
    # 1.
    moments = _moments(timing)
    total = float(moments[-1]) + width
    bends = np.union1d(moments, moments + width)
    acceleration = (_velocity(timing, moments, bends) - _velocity(timing, moments, bends - width)) / width
    variation = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(acceleration)))])
    measure = bends / total + variation / max(float(variation[-1]), LEAST_DIVISOR)
    even = np.linspace(0.0, float(measure[-1]), pieces + 1)
    knots: Floats = np.asarray(np.interp(even, measure, bends), dtype=np.float64)
    # 2.
    padded = np.concatenate([[0.0, 0.0], knots, [total, total]])
    abscissae = (padded[1:-2] + padded[2:-1]) / 2.0
    speeds = (_position(timing, moments, abscissae) - _position(timing, moments, abscissae - width)) / width
    speeds[:2] = speeds[-2:] = 0.0
    # 3.
    local = np.stack([speeds[:-2], speeds[1:-1], speeds[2:]], axis=1)
    begin = np.einsum("kid,ki->dk", quadratic_basis(knots)[::3], local)
    h = np.diff(knots)
    places = np.concatenate([[0.0], np.cumsum(begin[0] * h + begin[1] * h**2 / 2.0 + begin[2] * h**3 / 6.0)])
    rows = np.stack([places[:-1], begin[0], begin[1] / 2.0, begin[2] / 6.0], axis=1)
    return PiecewisePolynomial.from_pieces(h, (rows * float(timing.s[-1]) / places[-1])[..., None])


def quadratic_basis(knots: Floats) -> Floats:
    """Value, slope and second derivative of the three quadratic basis splines that count on each piece.

    Returns:
        (3 pieces, 3, 3), at begin, middle and end of each piece, by basis spline and derivative.

    Args:
        knots: (pieces + 1,) increasing.

    Reference: de Boor, A Practical Guide to Splines, ch. IX.
    """
    padded = np.concatenate([[knots[0]] * 2, knots, [knots[-1]] * 2])
    k = np.arange(2, len(knots) + 1)
    h, before, after = padded[k + 1] - padded[k], padded[k + 1] - padded[k - 1], padded[k + 2] - padded[k]
    found = np.zeros((len(h), 3, 3, 3))
    for place, share in enumerate(SHARES):
        falls, rises = (1.0 - share) * h, share * h
        left = np.stack([falls**2, -2.0 * falls, np.full_like(h, 2.0)], axis=-1) / (h * before)[:, None]
        right = np.stack([rises**2, 2.0 * rises, np.full_like(h, 2.0)], axis=-1) / (h * after)[:, None]
        found[:, place, 0], found[:, place, 2] = left, right
        found[:, place, 1] = np.array([1.0, 0.0, 0.0]) - left - right
    return found.reshape(-1, 3, 3)


def _moments(timing: Timing) -> Floats:
    """(places,) the times at the places of the grid [s]."""
    rate = np.sqrt(timing.x)
    return np.concatenate([[0.0], np.cumsum(2.0 * np.diff(timing.s) / (rate[:-1] + rate[1:]))])


def _position(timing: Timing, moments: Floats, t: Floats) -> Floats:
    """s at times, at rest before and after."""
    h, rate = np.diff(timing.s), np.sqrt(timing.x)
    k = np.clip(np.searchsorted(moments, t, side="right") - 1, 0, len(h) - 1)
    local = np.clip(t, 0.0, moments[-1]) - moments[k]
    return timing.s[k] + rate[k] * local + (timing.x[k + 1] - timing.x[k]) / (4.0 * h[k]) * local**2


def _velocity(timing: Timing, moments: Floats, t: Floats) -> Floats:
    """ds/dt at times: linear between the moments."""
    return np.asarray(np.interp(t, moments, np.sqrt(timing.x)), dtype=np.float64)
