"""Why blends do not fit into their legs: which leg of which coordinate, and how much time or acceleration would do."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mafsil.arrays import Floats
from mafsil.trajectory.motion import BlendStatus
from mafsil.trajectory.splines.blend_plan import BlendProblem, Blends, blends, mean_acceleration

GRID, ROUNDS = 512, 5
"""A search looks at so many candidates at once, and so often between two of them: to the last digits."""
DECADES = 3
"""Candidates reach from the least one a factor of ten to this power upwards, then farther."""


@dataclass(frozen=True, slots=True)
class InfeasibleLeg:
    """The leg of one row of the batch that lacks most time.

    Attributes:
        row: index into the batch; () without.
        status: TOO_SHORT_TO_BLEND (an end leg cannot be travelled with that acceleration at all) or BLENDS_OVERLAP.
        leg: index; it leads from points[leg] to points[leg + 1].
        coordinate: index.
        duration: of the leg [s].
        acceleration: peak magnitude at the leg's first point (its last one of a last leg) [rad/s^2 | m/s^2].
        straight: duration of its straight part [s], negative; NaN if TOO_SHORT_TO_BLEND.
        duration_needed: of this leg, the others as they are [s]; NaN if none was found.
        acceleration_needed: at the end of the leg in which it rests, so that it can be travelled; NaN if
            BLENDS_OVERLAP.
        least_acceleration: the smallest peak that, used at all points, makes the row feasible: of this coordinate,
            or of all of them where they share their blend times. Found by search.
        stretch: the smallest factor of all durations that makes the whole row feasible. Found by search.
    """

    row: tuple[int, ...]
    status: BlendStatus
    leg: int
    coordinate: int
    duration: float
    acceleration: float
    straight: float
    duration_needed: float
    acceleration_needed: float
    least_acceleration: float
    stretch: float

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {name: getattr(self, name) for name in self.__slots__} | {"status": self.status.name.lower()}

    def explain(self, language: str | None = None) -> str:
        """What is lacking, and what would do."""
        details = {name: getattr(self, name) for name in self.__slots__ if name not in ("row", "status")}
        return self.status.sentence(language, end=self.leg + 1, overlap=-self.straight, **details)


def infeasible_legs(problem: BlendProblem, found: Blends, peak: float) -> tuple[InfeasibleLeg, ...]:
    """One for each row that is not feasible.

    Args:
        problem: with batch.
        found: its blends.
        peak: of the blends' acceleration over its mean.
    """
    bad = ~found.feasible(problem.durations).all(axis=(-1, -2))
    return tuple(
        _infeasible_leg(_row(problem, tuple(int(i) for i in row)), tuple(int(i) for i in row), peak)
        for row in np.argwhere(bad)
    )


def _row(problem: BlendProblem, row: tuple[int, ...]) -> BlendProblem:
    """One row of the batch."""
    return replace(problem, points=problem.points[row], down=problem.down[row], up=problem.up[row])


def _infeasible_leg(problem: BlendProblem, row: tuple[int, ...], peak: float) -> InfeasibleLeg:
    """The worst leg of a single problem.

    1. A leg that has no blend at all, the one that would need most acceleration; else the most negative straight time.
    2. What this leg needs alone.
    3. What acceleration everywhere, or how much more time everywhere, makes the row feasible.
    """
    # 1
    found = blends(problem)
    excess = _radicand_accelerations(problem) / _end_accelerations(problem)
    if excess.max() > 1.0 and np.isnan(found.straight).any():
        leg, coordinate = (int(i) for i in np.unravel_index(int(excess.argmax()), excess.shape))
        status, straight = BlendStatus.TOO_SHORT_TO_BLEND, float("nan")
    else:
        leg, coordinate = (int(i) for i in np.unravel_index(int(np.nanargmin(found.straight)), found.straight.shape))
        status, straight = BlendStatus.BLENDS_OVERLAP, float(found.straight[leg, coordinate])
    h, mine = float(problem.durations[leg]), _end_accelerations(problem)[leg, coordinate]
    # 2
    needed = duration_needed = float("nan")
    if status is BlendStatus.TOO_SHORT_TO_BLEND:
        needed = float(_radicand_accelerations(problem)[leg, coordinate])
        duration_needed = h * float(np.sqrt(needed / mine))
    else:
        duration_needed = h * _least(lambda factor: _with_leg(problem, leg, factor), leg)
    # 3
    alone = problem if problem.together else _coordinate(problem, coordinate)
    base = float(_radicand_accelerations(alone).max()) or 1e-3 * float(mine)
    least = base * _least(lambda factor: _equal(alone, base * factor))
    stretch = float(np.sqrt(_least(lambda factor: _stronger(problem, factor))))
    at_goal = leg == len(problem.durations) - 1 and leg > 0
    own = float(np.minimum(problem.down, problem.up)[leg + at_goal, coordinate]) * peak
    details = (h, own, straight, duration_needed, needed * peak, least * peak, stretch)
    return InfeasibleLeg(row, status, leg, coordinate, *details)


def _radicand_accelerations(problem: BlendProblem) -> Floats:
    """(m - 1, n) mean acceleration below which an end leg cannot be travelled: 2 |D|/d^2, alone 4 |D|/d^2; else 0."""
    way = np.abs(np.diff(problem.points, axis=-2))
    ends = np.zeros(len(problem.durations))
    ends[0] += 2.0
    ends[-1] += 2.0
    moving = way > 0.0
    squared = np.where(moving, problem.durations[:, None] ** 2, 1.0)
    return ends[:, None] * way / np.where(squared > 0.0, squared, np.nan)


def _end_accelerations(problem: BlendProblem) -> Floats:
    """(m - 1, n) what the legs have for that; interior legs any."""
    D = np.diff(problem.points, axis=-2)
    start = np.where(D < 0.0, problem.down[:-1], problem.up[:-1])
    goal = np.where(D > 0.0, problem.down[1:], problem.up[1:])
    if len(D) == 1:
        return mean_acceleration(start, goal)
    found = start.copy()
    found[-1] = goal[-1]
    return found


def _least(candidates: Callable[[Floats], BlendProblem], leg: int | None = None) -> float:
    """The smallest factor >= 1 whose candidate is feasible: the first of a grid, then of a finer one before it; or NaN.

    Args:
        candidates: (k,) factors -> a batch (k) of problems.
        leg: whose blends have to fit; all legs if None.
    """
    low, high = 1.0, 10.0**DECADES
    farther = 2
    for _ in range(ROUNDS + farther):
        grid = np.geomspace(low, high, GRID)
        problem = candidates(grid)
        fits = np.asarray(blends(problem).feasible(problem.durations).all(axis=-1), dtype=np.bool_)
        good = np.asarray(fits.all(axis=-1) if leg is None else fits[:, leg], dtype=np.bool_)
        first = int(good.argmax())
        if good[first]:
            low, high = float(grid[max(first - 1, 0)]), float(grid[first])
        elif farther:
            farther, low, high = farther - 1, high, high * 10.0**DECADES
        else:
            return float("nan")
    return high


def _with_leg(problem: BlendProblem, leg: int, factor: Floats) -> BlendProblem:
    """One leg longer by factors (k,)."""
    durations = np.tile(problem.durations, (len(factor), 1))
    durations[:, leg] *= factor
    return replace(_repeat(problem, len(factor)), durations=durations)


def _stronger(problem: BlendProblem, factor: Floats) -> BlendProblem:
    """All accelerations larger by factors (k,): as much as durations longer by their roots."""
    down, up = (factor[:, None, None] * side for side in (problem.down, problem.up))
    return replace(_repeat(problem, len(factor)), down=down, up=up)


def _equal(problem: BlendProblem, acceleration: Floats) -> BlendProblem:
    """One acceleration (k,) for all points and coordinates."""
    whole = _repeat(problem, len(acceleration))
    side = np.broadcast_to(acceleration[:, None, None], whole.points.shape)
    return replace(whole, down=side, up=side)


def _repeat(problem: BlendProblem, count: int) -> BlendProblem:
    """A batch of the same problem."""
    points, down, up = (np.broadcast_to(x, (count, *x.shape)) for x in (problem.points, problem.down, problem.up))
    return replace(problem, points=points, down=down, up=up)


def _coordinate(problem: BlendProblem, k: int) -> BlendProblem:
    """One coordinate alone."""
    points, down, up = (x[:, k : k + 1] for x in (problem.points, problem.down, problem.up))
    return replace(problem, points=points, down=down, up=up)
