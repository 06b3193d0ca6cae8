"""Ways from cell to cell of a decomposed plane, through doors in the borders that two cells share."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mafsil.arrays import Floats
from mafsil.planning.search import shortest_way


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
