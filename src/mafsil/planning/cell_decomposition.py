"""Free space of the plane in trapezoids, exactly: a vertical line through every corner, as far as nothing is met."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, single
from mafsil.planning.outcome import Plan, PlanningStatus
from mafsil.planning.polygons import PolygonWorld
from mafsil.planning.quadtree import Ends, way_through

_Key: TypeAlias = tuple[int, int]
"""The edges below and above a cell; -1 is the border."""


@dataclass(frozen=True, eq=False, slots=True)
class CellDecomposition:
    """Trapezoids that fill the free space of a rectangle and nothing else.

    Attributes:
        world: that was divided.
        cells: (k, 4, 2) corners, counter-clockwise from the lower left one; two of them are one where a cell is a
            triangle [m].
        neighbours: (d, 2) indices of cells that share a piece of a vertical border, or a point.
        doors: (d, 2) the middles of what they share [m].
    """

    world: PolygonWorld
    cells: Floats
    neighbours: NDArray[np.int64]
    doors: Floats

    def path(self, start: ArrayLike, goal: ArrayLike) -> Plan:
        """The shortest way over the middles of common borders; there is none only where there is no path at all.

        Obstacles are open: where two touch in one point a path may pass.

        Args:
            start, goal: (2,) [m].

        Raises:
            InputError: a wrong shape, a number that is not finite.
        """
        account = ("cell_decomposition", len(self.cells), len(self.doors), len(self.cells))
        ends = Ends.of(start, goal, self.holding, account)
        if ends.blocked is not None:
            return ends.plan(ends.blocked[0])
        of_cell: list[list[int]] = [[] for _ in self.cells]
        for door, pair in enumerate(self.neighbours):
            for cell in map(int, pair):
                of_cell[cell].append(door)
        way = way_through(self.doors, of_cell, ends.cells, ends.a, ends.b)
        return ends.plan(PlanningStatus.SEPARATED if way is None else PlanningStatus.FOUND, way)

    def holding(self, point: ArrayLike) -> list[int]:
        """Cells that hold a point (2,), their borders included; none where it is blocked or outside."""
        (x, y), slack = single("point", point, (2,)), self.world.slack
        x_0, x_1 = self.cells[:, 0, 0], self.cells[:, 1, 0]
        share = np.clip((x - x_0) / (x_1 - x_0), 0.0, 1.0)
        low, high = (
            (1.0 - share) * self.cells[:, left, 1] + share * self.cells[:, right, 1] for left, right in ((0, 1), (3, 2))
        )
        across = (x_0 - slack <= x) & (x <= x_1 + slack)
        return np.flatnonzero(across & (low - slack <= y) & (y <= high + slack)).tolist()


def cell_decomposition(world: PolygonWorld) -> CellDecomposition:
    """Divide the free space of a rectangle into trapezoids.

    1. Slabs between the abscissas of all corners and crossings of edges: no edge begins, ends or crosses inside.
    2. In a slab, what lies between two edges that follow each other upwards is free as a whole or not at all.
    3. Cells of neighbouring slabs between the same two edges are one.
    4. Cells to both sides of a vertical line are neighbours where they share a piece or a point of it.

    Args:
        world: obstacles, which may overlap and stand over the border.

    Reference: Latombe, Robot Motion Planning, 1991, ch. 5; de Berg et al., Computational Geometry, sec. 6.1 and 13.2.
    """
    edges = _Edges.of(world)
    x = _abscissas(world, edges)
    # 1. and 2.
    cells, spans, last = list[Floats](), list[list[int]](), dict[_Key, int]()
    for slab in range(len(x) - 1):
        here = dict[_Key, int]()
        for key, corners in _free_in_slab(world, edges, float(x[slab]), float(x[slab + 1])):
            if key in last:  # 3.
                here[key] = last[key]
                cells[last[key]][1:3] = corners[1:3]
                spans[last[key]][1] = slab + 1
            else:
                here[key] = len(cells)
                cells.append(corners)
                spans.append([slab, slab + 1])
        last = here
    corners = np.array(cells).reshape(-1, 4, 2)
    pairs, doors = _share(corners, np.array(spans, np.int64).reshape(-1, 2), len(x), world.slack)  # 4.
    return CellDecomposition(world, corners, pairs, doors)


class _Edges(NamedTuple):
    """Edges of all polygons.

    Attributes:
        left, right: (e, 2) their ends, in the order of their abscissas [m].
    """

    left: Floats
    right: Floats

    @classmethod
    def of(cls, world: PolygonWorld) -> _Edges:
        """Those of a world."""
        a = np.concatenate([np.zeros((0, 2)), *world.polygons])
        b = np.concatenate([np.zeros((0, 2)), *(np.roll(corners, -1, axis=0) for corners in world.polygons)])
        back = (a[:, 0] > b[:, 0])[:, None]
        return cls(np.where(back, b, a), np.where(back, a, b))

    def at(self, which: NDArray[np.int64], x: float) -> Floats:
        """(k,) ordinates at an abscissa of some edges that are not vertical."""
        a, b = self.left[which], self.right[which]
        share = np.clip((x - a[:, 0]) / (b[:, 0] - a[:, 0]), 0.0, 1.0)
        return a[:, 1] + share * (b[:, 1] - a[:, 1])


def _abscissas(world: PolygonWorld, edges: _Edges) -> Floats:
    """Where edges begin, end or cross each other or the border, from the left border to the right one."""
    low, high = world.lower, world.upper
    border = np.array([[low, [high[0], low[1]]], [[low[0], high[1]], high]])
    a, b = np.concatenate([edges.left, border[:, 0]]), np.concatenate([edges.right, border[:, 1]])
    way, found = b - a, [a[:, 0], b[:, 0]]
    for i in range(len(a) - 1):
        across = way[i, 0] * way[i + 1 :, 1] - way[i, 1] * way[i + 1 :, 0]
        between = a[i + 1 :] - a[i]
        safe = np.where(across == 0.0, 1.0, across)
        s = (between[:, 0] * way[i + 1 :, 1] - between[:, 1] * way[i + 1 :, 0]) / safe
        t = (between[:, 0] * way[i, 1] - between[:, 1] * way[i, 0]) / safe
        meet = (across != 0.0) & (s > 0.0) & (s < 1.0) & (t > -1e-12) & (t < 1.0 + 1e-12)
        found.append(a[i, 0] + s[meet] * way[i, 0])
    x = np.unique(np.concatenate(found))
    x = x[(x > low[0] + world.slack) & (x < high[0] - world.slack)]
    x = x[np.diff(x, prepend=-np.inf) > world.slack]
    return np.concatenate([low[:1], x, high[:1]])


def _free_in_slab(world: PolygonWorld, edges: _Edges, left: float, right: float) -> list[tuple[_Key, Floats]]:
    """Free trapezoids (4, 2) of a slab from below, each with its lower and its upper edge, -1 being a border."""
    low, high, slack = float(world.lower[1]), float(world.upper[1]), world.slack
    through = (edges.left[:, 0] <= left + slack) & (edges.right[:, 0] >= right - slack)
    which = np.flatnonzero(through & (edges.right[:, 0] - edges.left[:, 0] > slack))
    ends = np.stack([edges.at(which, left), edges.at(which, right)], axis=1)
    middle = ends.mean(axis=1)
    inner = np.flatnonzero((middle > low) & (middle < high))
    inner = inner[np.argsort(middle[inner], kind="stable")]
    ordinates = np.clip(np.concatenate([[[low, low]], ends[inner], [[high, high]]]), low, high)
    names = [-1, *which[inner].tolist(), -1]
    below, above = ordinates[:-1], ordinates[1:]
    corners = np.empty((len(below), 4, 2))
    corners[:, (0, 3), 0], corners[:, (1, 2), 0] = left, right
    corners[:, :2, 1], corners[:, 2, 1], corners[:, 3, 1] = below, above[:, 1], above[:, 0]
    free = ((above - below).max(axis=1) > slack) & world.free(corners.mean(axis=1))
    return [((names[k], names[k + 1]), corners[k]) for k in np.flatnonzero(free)]


def _share(cells: Floats, spans: NDArray[np.int64], lines: int, slack: float) -> tuple[NDArray[np.int64], Floats]:
    """Pairs of cells that share a piece or a point of a vertical line, and the middle of that.

    Args:
        cells: (k, 4, 2) corners [m].
        spans: (k, 2) the lines at which cells begin and end.
        lines: how many there are.
        slack: what counts as a point [m].
    """
    pairs, doors = list[tuple[int, int]](), list[Floats]()
    for line in range(lines):
        begins, ends = np.flatnonzero(spans[:, 0] == line), np.flatnonzero(spans[:, 1] == line)
        on_line = np.concatenate([begins, ends])
        sides = np.concatenate([cells[begins][:, (0, 3)], cells[ends][:, (1, 2)]])
        for i in range(len(on_line)):
            low = np.maximum(sides[i, 0, 1], sides[i + 1 :, 0, 1])
            high = np.minimum(sides[i, 1, 1], sides[i + 1 :, 1, 1])
            for j in np.flatnonzero(high - low >= -slack).tolist():
                pairs.append((int(on_line[i]), int(on_line[i + 1 + j])))
                doors.append(np.array([sides[i, 0, 0], (low[j] + high[j]) / 2.0]))
    return np.array(pairs, np.int64).reshape(-1, 2), np.array(doors).reshape(-1, 2)
