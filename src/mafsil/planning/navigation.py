"""A navigation function on a grid: distances from the goal through free cells. It has no local minimum but the goal."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from itertools import product
from time import perf_counter

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, single
from mafsil.messages import say
from mafsil.planning.outcome import Plan, PlanningStatus
from mafsil.planning.problem import Problem


@dataclass(frozen=True, eq=False, slots=True)
class NavigationFunction:
    """Steps to the goal from every cell of a grid.

    Attributes:
        axes: (n) arrays of the cells' middles along each coordinate.
        free: bools on the grid.
        steps: steps to the goal on the grid; -1 in cells that are blocked or cut off.
        goal: (n,) what it leads to.
    """

    axes: tuple[Floats, ...]
    free: NDArray[np.bool_]
    steps: NDArray[np.int64]
    goal: Floats

    def path(self, start: ArrayLike) -> Plan:
        """Down the steps from the cell of a configuration.

        Cells count as free by their middles; to be cut off on this grid is not proven to be separated.

        Args:
            start: (n,).

        Raises:
            InputError: a wrong shape, a number that is not finite.
        """
        begun = perf_counter()
        q = single("start", start, self.goal.shape)
        cell, cells = _cell(self.axes, q), int(self.free.size)
        account = ("navigation_function", cells, 0, cells)
        if not self.free[cell] or self.steps[cell] < 0:
            cut_off = self.free[cell]
            status = PlanningStatus.NOT_FOUND if cut_off else PlanningStatus.START_BLOCKED
            grid = " x ".join(map(str, self.free.shape))
            reason = say("planning.cut_off", grid=grid) if cut_off else ""
            return Plan(status, q[None], *account, perf_counter() - begun, reason)
        rows = [q]
        while self.steps[cell] > 0:
            cell = min(
                _around(cell, self.free.shape), key=lambda c: self.steps[c] if self.steps[c] >= 0 else self.steps.size
            )
            rows.append(np.array([axis[k] for axis, k in zip(self.axes, cell, strict=True)]))
        rows[-1] = self.goal
        return Plan(PlanningStatus.FOUND, np.stack(rows), *account, perf_counter() - begun)


def navigation_function(problem: Problem, goal: ArrayLike, cells: int | tuple[int, ...] = 64) -> NavigationFunction:
    """Distances from the goal by a wave that spreads through free cells of a grid.

    Memory: nine bytes a cell; in more than four coordinates grids become too large.

    Args:
        problem: what is free, by the middles of cells.
        goal: (n,).
        cells: along each coordinate.

    Reference: Barraquand and Latombe 1991 (NF1).
    """
    counts = (cells,) * problem.n if isinstance(cells, int) else cells
    edges: list[Floats] = [
        np.linspace(low, high, count + 1) for low, high, count in zip(problem.lower, problem.upper, counts, strict=True)
    ]
    axes: tuple[Floats, ...] = tuple((edge[:-1] + edge[1:]) / 2.0 for edge in edges)
    target = single("goal", goal, (problem.n,))
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    free = problem.is_free(grid.reshape(-1, problem.n)).reshape(counts)
    steps = np.full(counts, -1)
    first = _cell(axes, target)
    if free[first]:
        steps[first] = 0
        wave = deque([first])
        while wave:
            cell = wave.popleft()
            for other in _around(cell, free.shape):
                if free[other] and steps[other] < 0:
                    steps[other] = steps[cell] + 1
                    wave.append(other)
    return NavigationFunction(axes, free, steps, target)


def _cell(axes: tuple[Floats, ...], q: Floats) -> tuple[int, ...]:
    """The cell in which a configuration is."""
    return tuple(int(np.abs(axis - x).argmin()) for axis, x in zip(axes, q, strict=True))


def _around(cell: tuple[int, ...], shape: tuple[int, ...]) -> list[tuple[int, ...]]:
    """Neighbours along one coordinate."""
    found: list[tuple[int, ...]] = []
    for axis, step in product(range(len(shape)), (-1, 1)):
        k = cell[axis] + step
        if 0 <= k < shape[axis]:
            found.append((*cell[:axis], k, *cell[axis + 1 :]))
    return found
