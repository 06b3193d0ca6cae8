"""Paths down a field: a potential with random walks out of its minima, or a navigation function, which has none."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from itertools import pairwise, product
from math import prod
from time import perf_counter
from typing import Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, single, whole
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.messages import say
from mafsil.model.limits import snap_to_bounds
from mafsil.planning.outcome import Plan, PlanningStatus, Reason
from mafsil.planning.problem import Problem, require_few_cells

Cell: TypeAlias = tuple[int, ...]
"""Place on a grid, by the indices along its axes."""
MOST_WAVES = 200
"""Times that the wave spreads again where a motion between two cells is blocked."""
STILL = 1e-10
"""Force, as share of the attraction at the start, below which a point stands still."""
RESTS = 1e-3
"""The same, below which a place from which no step leads farther down counts as a minimum."""
ARRIVED = 1e-9
MOST_STEPS = 20_000
SHORT_WALK, LONG_WALK = 10, 60
"""Steps of a random walk between which it is drawn, times the failures before."""
BACK = 3
"""Every so many failures a walk begins farther back on the way."""
LEAST_CLEAR = 1e-3
"""Share of a step by which a proof that it is clear has to go on at least."""
REMEMBERED = 16
"""Points whose field is remembered."""
LOWER = 1e-6
"""Share of its potential by which a minimum has to lie lower than another one to be worth going on from."""


class Field(Protocol):
    """What is gone down."""

    @property
    def goal(self) -> Floats:
        """(n,) where it leads."""
        ...

    @property
    def kp(self) -> float:
        """How strong the attraction is."""
        ...

    @property
    def lower(self) -> Floats:
        """(n,) least coordinates."""
        ...

    @property
    def upper(self) -> Floats:
        """(n,) largest coordinates."""
        ...

    def at(self, x: Floats) -> tuple[float, Floats, float]:
        """U, the force (n,), and by how much x (n,) can change before anything could be met."""
        ...


@dataclass(frozen=True, eq=False, repr=False)
class FieldPath(Plan):
    """A path down a potential field.

    Attributes:
        minima: (m, n) the local minima that it came to, in order; all but the last were left where it went on.
    """

    minima: Floats = field(default_factory=lambda: np.zeros((0, 0)))

    def explain(self, language: str | None = None) -> str:
        """The status, the account, and how many minima it came to."""
        more = say("planning.minima", language=language, count=len(self.minima))
        return super().explain(language) + (f"\n{more}" if len(self.minima) else "")

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return super().to_dict() | {"minima": self.minima.tolist()}


def down_the_field(around: Field, start: Floats, step: float, escapes: int, seed: int) -> FieldPath:
    """From a point to the goal, or to a local minimum from which no walk leads on.

    1. Ends that cannot be; a start beyond a bound by rounding is led onto it.
    2. Down to a place where the point rests.
    3. A random walk from there, or from farther back, and down again: kept where that ends lower.

    Args:
        around: the field.
        start: (n,) [m | rad].
        step: longest step.
        escapes: random walks.
        seed: of these.
    """
    given, start = start, snap_to_bounds(start, around.lower, around.upper)
    way = [given] if (given != start).any() else []
    begun, rng, descent = perf_counter(), np.random.default_rng(seed), _Descent(around, start, step)

    def ended(status: PlanningStatus, rows: list[Floats], minima: list[Floats]) -> FieldPath:
        seconds = perf_counter() - begun
        places = np.array(minima).reshape(-1, len(start))
        return FieldPath(
            status, np.stack([*way, *rows]), "potential_field", descent.looks, 0, len(rows), seconds, minima=places
        )

    # 1
    blocked = descent.blocked_end()
    if blocked is not None:
        return ended(blocked, [start], [])
    # 2
    rows, minima, failures = descent.down(start), list[Floats](), 0
    for _ in range(escapes):
        if descent.is_goal(rows[-1]) or descent.spent:
            break
        # 3
        failures += 1
        minima += [rows[-1]] if failures == 1 else []
        base = rows
        if failures % BACK == 0:
            base = rows[: 1 + int(rng.integers(len(rows)))]
        walk = descent.random_walk(base[-1], rng, failures)
        new = [*base, *walk, *descent.down(walk[-1])[1:]] if walk else base
        if descent.is_goal(new[-1]) or descent.potential(new[-1]) < (1.0 - LOWER) * descent.potential(rows[-1]):
            rows, failures = new, 0
    if descent.is_goal(rows[-1]):
        return ended(PlanningStatus.FOUND, rows, minima)
    rests = descent.rests(rows[-1])
    minima += [rows[-1]] if failures == 0 and rests else []
    return ended(PlanningStatus.LOCAL_MINIMUM if rests else PlanningStatus.NOT_FOUND, rows, minima)


class _Descent:
    """Steps of one path.

    Args:
        around: the field.
        start: (n,) where it begins.
        step: longest step.
    """

    def __init__(self, around: Field, start: Floats, step: float) -> None:
        self.field, self.start, self.longest, self.looks = around, start, step, 0
        self._known: dict[bytes, tuple[float, Floats, float]] = {}
        self.size = max(around.kp * float(np.linalg.norm(around.goal - start)), LEAST_DIVISOR)

    @property
    def spent(self) -> bool:
        """Whether the budget of steps is used up."""
        return self.looks >= MOST_STEPS

    def blocked_end(self) -> PlanningStatus | None:
        """An end that lies outside the limits, or at which an obstacle has no distance left."""
        ends = (
            (self.start, PlanningStatus.START_OUTSIDE, PlanningStatus.START_BLOCKED),
            (self.field.goal, PlanningStatus.GOAL_OUTSIDE, PlanningStatus.GOAL_BLOCKED),
        )
        for end, outside, blocked in ends:
            if (end < self.field.lower).any() or (end > self.field.upper).any():
                return outside
            if not self.clear(end) > 0.0:
                return blocked
        return None

    def at(self, x: Floats) -> tuple[float, Floats, float]:
        """What the field is at a point; the last ones are asked for again and again."""
        key = x.tobytes()
        if key not in self._known:
            if len(self._known) >= REMEMBERED:
                self._known.clear()
            self._known[key] = self.field.at(x)
        return self._known[key]

    def clear(self, x: Floats) -> float:
        """By how much a point can change before anything could be met."""
        return self.at(x)[2]

    def potential(self, x: Floats) -> float:
        """U."""
        return self.at(x)[0]

    def is_goal(self, x: Floats) -> bool:
        """Whether a point is the goal."""
        return bool(np.linalg.norm(self.field.goal - x) <= ARRIVED * max(1.0, self.size / self.field.kp))

    def rests(self, x: Floats) -> bool:
        """Whether (nearly) no force is left at a point, but what presses it against the limits."""
        return float(np.linalg.norm(self._free_force(x, self.at(x)[1]))) <= RESTS * self.size

    def down(self, x: Floats) -> list[Floats]:
        """Points down the field from one, which is the first, to where it rests."""
        rows = [x]
        while not self.spent and not self.is_goal(x):
            found = self._lower_place(x)
            if found is None:
                break
            x = found
            rows.append(x)
        return rows

    def random_walk(self, x: Floats, rng: np.random.Generator, times: int) -> list[Floats]:
        """A random walk that meets nothing; the longer, the more there were before."""
        rows, limits = [x], (self.field.lower, self.field.upper)
        for _ in range(times * int(rng.integers(SHORT_WALK, LONG_WALK))):
            new = np.clip(rows[-1] + rng.normal(size=len(x)) * self.longest, *limits)
            if self._way_is_clear(rows[-1], new):
                rows.append(new)
        return rows[1:]

    def _free_force(self, x: Floats, F: Floats) -> Floats:
        """The force without what presses against the limits."""
        stopped = ((x <= self.field.lower) & (F < 0.0)) | ((x >= self.field.upper) & (F > 0.0))
        return np.where(stopped, 0.0, F)

    def _lower_place(self, x: Floats) -> Floats | None:
        """A point farther down along the force; None where none is lower."""
        self.looks += 1
        here, F, _ = self.at(x)
        F = self._free_force(x, F)
        size = float(np.linalg.norm(F))
        if not np.isfinite(size) or size <= STILL * self.size:
            return None
        length = min(self.longest, size / self.field.kp)
        while length > 1e-15 * max(1.0, float(np.abs(x).max())):
            new = np.clip(x + F * (length / size), self.field.lower, self.field.upper)
            if self.potential(new) < here and self._way_is_clear(x, new):
                return new
            length /= 2.0
        return None

    def _way_is_clear(self, a: Floats, b: Floats) -> bool:
        """Whether nothing is met on the straight way between two points: balls that are clear cover it."""
        length = float(np.linalg.norm(b - a))
        done = 0.0
        while done < length:
            forward = self.clear(a + (b - a) * (done / length))
            if not forward > LEAST_CLEAR * length:
                return False
            done += forward
        return self.clear(b) > 0.0


@dataclass(frozen=True, eq=False, slots=True)
class NavigationFunction:
    """Steps to the goal from every cell of a grid.

    Attributes:
        problem: what is free.
        axes: (n) arrays of the cells' middles along each coordinate.
        free: bools on the grid.
        steps: steps to the goal on the grid; -1 in cells that are blocked or cut off.
        goal: (n,) what it leads to.
    """

    problem: Problem
    axes: tuple[Floats, ...]
    free: NDArray[np.bool_]
    steps: NDArray[np.int64]
    goal: Floats

    def path(self, start: ArrayLike) -> Plan:
        """Down the steps from a cell at a configuration.

        1. From a cell whose middle the start sees, down the steps to the goal.
        2. Cells count as free by their middles, but each motion of the path is looked at. Where one is blocked the
           wave spreads again without it.

        To be cut off on this grid is not proven to be separated.

        Args:
            start: (n,).

        Raises:
            InputError: a wrong shape, a number that is not finite.
        """
        begun = perf_counter()
        q, cells, looked = single("start", start, self.goal.shape), int(self.free.size), self.problem.counts.segments

        def ended(status: PlanningStatus, path: Floats, reason: str = "") -> Plan:
            segments = self.problem.counts.segments - looked
            return Plan(status, path, "navigation_function", cells, segments, cells, perf_counter() - begun, reason)

        for status, end in ((PlanningStatus.START_BLOCKED, q), (PlanningStatus.GOAL_BLOCKED, self.goal)):
            if not self.problem.is_free(end)[0]:
                return ended(status, q[None])
        if np.array_equal(q, self.goal):
            return ended(PlanningStatus.FOUND, q[None])
        steps, blocked = self.steps, set[frozenset[Cell]]()
        seen = _seen_from(self.problem, self.axes, self.free, q)
        last = _seen_from(self.problem, self.axes, self.free, self.goal)[:1]
        for _ in range(MOST_WAVES):
            reached = [cell for cell in seen if steps[cell] >= 0]
            if not reached:
                break
            way = _down(steps, min(reached, key=lambda cell: steps[cell]), blocked)  # 1
            places = [np.array([axis[k] for axis, k in zip(self.axes, cell, strict=True)]) for cell in way]
            wrong = [
                frozenset(pair)
                for pair, (a, b) in zip(pairwise(way), pairwise(places), strict=True)
                if not self.problem.is_free_segment(a, b)
            ]
            if not wrong:
                return ended(PlanningStatus.FOUND, np.stack([q, *places, self.goal]))
            blocked |= set(wrong)  # 2
            steps = _wave(self.free, last, blocked)
        grid = " x ".join(map(str, steps.shape))
        return ended(PlanningStatus.NOT_FOUND, q[None], Reason(("planning.cut_off", {"grid": grid})))


def navigation_function(problem: Problem, goal: ArrayLike, cells: int | tuple[int, ...] = 64) -> NavigationFunction:
    """Distances from the goal by a wave that spreads through free cells of a grid.

    Memory: nine bytes a cell; in more than four coordinates grids become too large.

    Args:
        problem: what is free, by the middles of cells.
        goal: (n,).
        cells: along each coordinate.

    Raises:
        InputError: a wrong shape, a number that is not finite, no cells or too many.

    Reference: Barraquand and Latombe 1991 (NF1).
    """
    given = cells if isinstance(cells, tuple) else (cells,) * problem.n
    counts = tuple(whole("cells", count, least=1) for count in given)
    if len(counts) != problem.n:
        raise InputError("input.shape", name="cells", expected=(problem.n,), got=(len(counts),), hint="")
    require_few_cells(prod(counts))
    edges: list[Floats] = [
        np.linspace(low, high, count + 1) for low, high, count in zip(problem.lower, problem.upper, counts, strict=True)
    ]
    axes: tuple[Floats, ...] = tuple((edge[:-1] + edge[1:]) / 2.0 for edge in edges)
    target = single("goal", goal, (problem.n,))
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    free = problem.is_free(grid.reshape(-1, problem.n)).reshape(counts)
    begins = _seen_from(problem, axes, free, target)[:1] if problem.is_free(target)[0] else []
    return NavigationFunction(problem, axes, free, _wave(free, begins, set()), target)


def _seen_from(problem: Problem, axes: tuple[Floats, ...], free: NDArray[np.bool_], q: Floats) -> list[Cell]:
    """Free cells at a configuration, the nearest first, to whose middles the straight motion is free."""
    own = [int(np.abs(axis - x).argmin()) for axis, x in zip(axes, q, strict=True)]
    near = product(*(range(max(k - 1, 0), min(k + 2, len(axis))) for k, axis in zip(own, axes, strict=True)))
    middles = {cell: np.array([axis[k] for axis, k in zip(axes, cell, strict=True)]) for cell in near if free[cell]}
    ordered = sorted(middles, key=lambda cell: float(np.linalg.norm(middles[cell] - q)))
    return [cell for cell in ordered if problem.is_free_segment(q, middles[cell])]


def _wave(free: NDArray[np.bool_], begins: list[Cell], blocked: set[frozenset[Cell]]) -> NDArray[np.int64]:
    """Steps to the first cells from every free one, never between two that are blocked; -1 where there is no way."""
    steps = np.full(free.shape, -1)
    wave = deque(begins)
    for cell in begins:
        steps[cell] = 0
    while wave:
        cell = wave.popleft()
        for other in _around(cell, free.shape):
            if free[other] and steps[other] < 0 and not (blocked and frozenset((cell, other)) in blocked):
                steps[other] = steps[cell] + 1
                wave.append(other)
    return steps


def _down(steps: NDArray[np.int64], cell: Cell, blocked: set[frozenset[Cell]]) -> list[Cell]:
    """Cells from one that the wave has reached to where it began."""
    way = [cell]
    while steps[cell] > 0:
        cell = next(
            other
            for other in _around(cell, steps.shape)
            if steps[other] == steps[cell] - 1 and frozenset((cell, other)) not in blocked
        )
        way.append(cell)
    return way


def _around(cell: Cell, shape: tuple[int, ...]) -> list[Cell]:
    """Neighbours along one coordinate."""
    found: list[Cell] = []
    for axis, step in product(range(len(shape)), (-1, 1)):
        k = cell[axis] + step
        if 0 <= k < shape[axis]:
            found.append((*cell[:axis], k, *cell[axis + 1 :]))
    return found
