"""Free space of the plane in squares of many sizes: free, full, or divided further.

Ways from cell to cell of a decomposed plane, through doors in the borders that two cells share.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, single, whole
from mafsil.planning.outcome import Plan, PlanningStatus
from mafsil.planning.polygons import PolygonWorld, distances_to_segments
from mafsil.planning.search import shortest_way

Account: TypeAlias = tuple[str, int, int, int]
"""Name of the planner; configurations, segments and nodes."""


@dataclass(frozen=True, eq=False, slots=True)
class Quadtree:
    """Cells of a rectangle.

    Attributes:
        world: that was divided.
        free, full, mixed: (k, 2, 2) lower and upper corners of the cells of each kind; mixed ones are as small as
            they may be.
        depth: how often cells were divided at most.
    """

    world: PolygonWorld
    free: Floats
    full: Floats
    mixed: Floats
    depth: int

    def path(self, start: ArrayLike, goal: ArrayLike) -> Plan:
        """A way from cell to cell, through the middles of their common borders.

        1. Start and goal in free cells; where one is in a mixed cell nothing is decided at this depth.
        2. The shortest way through the borders of neighbouring free cells.
        3. If there is none: separated if not even mixed cells would join them, nor corners at which cells touch, for
           obstacles are open; else not found at this depth.

        Args:
            start, goal: (2,) [m].

        Raises:
            InputError: a wrong shape, a number that is not finite.
        """
        # 1.
        account = ("quadtree", len(self.free) + len(self.full) + len(self.mixed), 0, len(self.free))
        ends = Ends.of(start, goal, lambda point: _cells_of(self.free, point)[:1], account)
        if ends.blocked is not None:
            status, point = ends.blocked
            return ends.plan(PlanningStatus.NOT_FOUND if _cells_of(self.mixed, point) else status)
        # 2.
        doors, of_cell = _doors(self.free)
        way = way_through(doors, of_cell, ends.cells, ends.a, ends.b)
        if way is not None:
            return ends.plan(PlanningStatus.FOUND, way)
        # 3.
        joined, (first, second) = np.concatenate([self.free, self.mixed]), ends.cells
        is_open = _is_connected(joined, first[0], second[0])
        return ends.plan(PlanningStatus.NOT_FOUND if is_open else PlanningStatus.SEPARATED)


def quadtree(world: PolygonWorld, depth: int = 6) -> Quadtree:
    """Divide a rectangle into free and full cells; mixed ones into four, down to a depth.

    Args:
        world: obstacles.
        depth: how often cells are divided at most.

    Reference: Samet, The Design and Analysis of Spatial Data Structures; LaValle, Planning Algorithms, sec. 6.
    """
    deepest = whole("depth", depth, least=0)
    kinds: dict[str, list[Floats]] = {"free": [], "full": [], "mixed": []}
    waiting = [(np.stack([world.lower, world.upper]), 0)]
    while waiting:
        cell, level = waiting.pop()
        kind = _kind(world, cell)
        if kind != "mixed" or level == deepest:
            kinds[kind].append(cell)
            continue
        middle = cell.mean(axis=0)
        for x in (0, 1):
            for y in (0, 1):
                low = np.array([(cell[0], middle)[x][0], (cell[0], middle)[y][1]])
                high = np.array([(middle, cell[1])[x][0], (middle, cell[1])[y][1]])
                waiting.append((np.stack([low, high]), level + 1))
    cells = {name: np.array(rows).reshape(-1, 2, 2) for name, rows in kinds.items()}
    return Quadtree(world, cells["free"], cells["full"], cells["mixed"], deepest)


def _kind(world: PolygonWorld, cell: Floats) -> str:
    """Free, full or mixed: no edge of an obstacle passes through the interior of the first two."""
    middle, half = cell.mean(axis=0), (cell[1] - cell[0]) / 2.0
    for corners in world.polygons:
        a, b = corners, np.roll(corners, -1, axis=0)
        if (distances_to_segments(middle[None], a, b).min() < float(np.linalg.norm(half))) and _crosses(a, b, cell):
            return "mixed"
    return "free" if world.free(middle)[0] else "full"


def _crosses(a: Floats, b: Floats, cell: Floats) -> bool:
    """Whether one of the segments passes through the open cell: clipped by its four sides (Liang and Barsky)."""
    way = b - a
    enter, leave = np.zeros(len(a)), np.ones(len(a))
    outside = np.zeros(len(a), dtype=bool)
    for axis in (0, 1):
        still = way[:, axis] == 0.0
        low, high = cell[0, axis] - a[:, axis], cell[1, axis] - a[:, axis]
        outside |= still & ((low >= 0.0) | (high <= 0.0))
        step = np.where(still, 1.0, way[:, axis])
        first, last = np.minimum(low / step, high / step), np.maximum(low / step, high / step)
        enter = np.where(still, enter, np.maximum(enter, first))
        leave = np.where(still, leave, np.minimum(leave, last))
    return bool((~outside & (leave - enter > 1e-12)).any())


def _cells_of(cells: Floats, point: Floats) -> list[int]:
    """The cells that hold a point, their borders included."""
    return np.flatnonzero(((cells[:, 0] <= point) & (point <= cells[:, 1])).all(axis=1)).tolist()


def _meeting(cells: Floats, k: int) -> list[int]:
    """Cells after k that share at least a point with it."""
    low, high = np.maximum(cells[k, 0], cells[k + 1 :, 0]), np.minimum(cells[k, 1], cells[k + 1 :, 1])
    return (np.flatnonzero((high >= low).all(axis=1)) + k + 1).tolist()


def _touching(cells: Floats, k: int) -> tuple[list[int], Floats]:
    """Cells after k that share more than a point with it, and the middles of the common borders."""
    low, high = np.maximum(cells[k, 0], cells[k + 1 :, 0]), np.minimum(cells[k, 1], cells[k + 1 :, 1])
    size = high - low
    rows = np.flatnonzero((np.abs(size).min(axis=1) <= 0.0) & (size.max(axis=1) > 0.0) & (size.min(axis=1) >= 0.0))
    return (rows + k + 1).tolist(), (low[rows] + high[rows]) / 2.0


def _doors(cells: Floats) -> tuple[Floats, list[list[int]]]:
    """Middles of the borders between cells, and those of each cell."""
    doors: list[Floats] = []
    of_cell: list[list[int]] = [[] for _ in cells]
    for k in range(len(cells)):
        others, middles = _touching(cells, k)
        for other, middle in zip(others, middles, strict=True):
            of_cell[k].append(len(doors))
            of_cell[other].append(len(doors))
            doors.append(middle)
    return np.array(doors).reshape(-1, 2), of_cell


def _is_connected(cells: Floats, start: int, end: int) -> bool:
    """Whether cells lead from one to another, through corners too."""
    pairs: list[set[int]] = [set() for _ in cells]
    for k in range(len(cells)):
        for other in _meeting(cells, k):
            pairs[k].add(other)
            pairs[other].add(k)
    seen, stack = {start}, [start]
    while stack:
        for other in pairs[stack.pop()] - seen:
            seen.add(other)
            stack.append(other)
    return end in seen


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
