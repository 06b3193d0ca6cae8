"""The shortest way of a point among polygons: the visibility graph, exact."""

from __future__ import annotations

from time import perf_counter

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import single
from mafsil.planning.outcome import Plan, PlanningStatus
from mafsil.planning.polygons import PolygonWorld
from mafsil.planning.search import shortest_way


def visibility_path(world: PolygonWorld, start: ArrayLike, goal: ArrayLike) -> Plan:
    """The shortest way from point to point: it bends only at corners of obstacles.

    1. Corners inside the rectangle and in no other obstacle, with start and goal; edges between those in sight.
    2. The shortest way by A*. If there is none, start and goal are separated: everything was looked at.

    Args:
        world: obstacles.
        start, goal: (2,) [m].

    Raises:
        InputError: a wrong shape, a number that is not finite.

    Reference: Lozano-Perez and Wesley, An algorithm for planning collision-free paths, 1979.
    """
    begun = perf_counter()
    a, b = single("start", start, (2,)), single("goal", goal, (2,))
    for status, point in ((PlanningStatus.START_BLOCKED, a), (PlanningStatus.GOAL_BLOCKED, b)):
        outside = (point < world.lower).any() or (point > world.upper).any()
        if outside or not world.free(point)[0]:
            return Plan(status, a[None], "visibility_graph", 1, 0, 0, perf_counter() - begun)
    # 1.
    corners = np.concatenate([np.zeros((0, 2)), *world.polygons])
    within = ((corners >= world.lower) & (corners <= world.upper)).all(axis=1)
    nodes = (
        np.concatenate([a[None], b[None], corners[within & world.free(corners)]]) if len(corners) else np.stack([a, b])
    )
    edges: list[set[int]] = [set() for _ in nodes]
    for i in range(len(nodes)):
        for j in range(i + 1, len(nodes)):
            if world.free_segment(nodes[i], nodes[j]):
                edges[i].add(j)
                edges[j].add(i)
    # 2.
    way = shortest_way(nodes, edges, 0, {1})
    seconds, looks = perf_counter() - begun, len(nodes) * (len(nodes) - 1) // 2
    if way is None:
        return Plan(PlanningStatus.SEPARATED, a[None], "visibility_graph", len(nodes), looks, len(nodes), seconds)
    return Plan(PlanningStatus.FOUND, nodes[way], "visibility_graph", len(nodes), looks, len(nodes), seconds)
