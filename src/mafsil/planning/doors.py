"""Ways from cell to cell of a decomposed plane, through doors in the borders that two cells share."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, single
from mafsil.planning.outcome import Plan, PlanningStatus
from mafsil.planning.search import shortest_way

Account: TypeAlias = tuple[str, int, int, int]
"""Name of the planner; configurations, segments and nodes."""


@dataclass(frozen=True, eq=False, slots=True)
class Ends:
    """Both ends of a way through cells, and the account of the plan.

    Attributes:
        a, b: (2,) where it begins and ends [m].
        cells: those that hold a, and those that hold b.
        account: the planner, and how much it looked at.
        begun: when.
    """

    a: Floats
    b: Floats
    cells: tuple[Sequence[int], Sequence[int]]
    account: Account
    begun: float

    @classmethod
    def of(
        cls, start: ArrayLike, goal: ArrayLike, holding: Callable[[Floats], Sequence[int]], account: Account
    ) -> Ends:
        """Of a question.

        Args:
            start, goal: (2,) [m].
            holding: the cells that hold a point (2,).
            account: of the plan.

        Raises:
            InputError: a wrong shape, a number that is not finite.
        """
        begun = perf_counter()
        a, b = single("start", start, (2,)), single("goal", goal, (2,))
        return cls(a, b, (holding(a), holding(b)), account, begun)

    @property
    def blocked(self) -> tuple[PlanningStatus, Floats] | None:
        """The first end that no cell holds, and where it is."""
        if not self.cells[0]:
            return PlanningStatus.START_BLOCKED, self.a
        return None if self.cells[1] else (PlanningStatus.GOAL_BLOCKED, self.b)

    def plan(self, status: PlanningStatus, way: Floats | None = None) -> Plan:
        """How it ended, with the way (k, 2) if there is one."""
        return Plan(status, self.a[None] if way is None else way, *self.account, perf_counter() - self.begun)


def way_through(
    doors: Floats, of_cell: Sequence[Sequence[int]], ends: tuple[Sequence[int], Sequence[int]], a: Floats, b: Floats
) -> Floats | None:
    """The shortest way over the doors of convex cells; None if none leads from a to b.

    Args:
        doors: (d, 2) their places [m].
        of_cell: for each cell its doors.
        ends: the cells that hold a, and those that hold b.
        a, b: (2,) where the way begins and ends [m].

    Returns:
        (k, 2) from a to b [m].
    """
    start, goal = len(doors), len(doors) + 1
    here, there = (set[int]().union(*(of_cell[cell] for cell in cells)) for cells in ends)
    edges: list[set[int]] = [set() for _ in range(len(doors) + 2)]
    for of_one in of_cell:
        for door in of_one:
            edges[door] |= set(of_one) - {door}
    edges[start] |= here
    for door in there:
        edges[door].add(goal)
    if set(ends[0]) & set(ends[1]):
        edges[start].add(goal)
    nodes = np.concatenate([doors, a[None], b[None]])
    way = shortest_way(nodes, edges, start, {goal})
    return None if way is None else nodes[way]
