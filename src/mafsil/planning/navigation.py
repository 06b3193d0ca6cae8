"""A navigation function on a grid: distances from the goal through free cells. It has no local minimum but the goal."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from itertools import pairwise, product
from math import prod
from time import perf_counter
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, single, whole
from mafsil.errors import InputError
from mafsil.planning.outcome import Plan, PlanningStatus, Reason
from mafsil.planning.problem import Problem, require_few_cells

Cell: TypeAlias = tuple[int, ...]
"""Place on a grid, by the indices along its axes."""
MOST_WAVES = 200
"""Times that the wave spreads again where a motion between two cells is blocked."""


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
