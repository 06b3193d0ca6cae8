"""Independent loops that are as short as can be: what a loop asks is plainest where it passes few joints.

Reference: J. Horton, A polynomial-time algorithm to find the shortest cycle basis of a graph, SIAM J. Computing 1987.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mafsil.mobility.linkages.linkage import Linkage

MOST_CANDIDATES = 200_000
"""Bodies times joints beyond which the loops of a breadth first walk have to do."""
Joints = frozenset[int]


def shortest_loops(linkage: Linkage) -> list[NDArray[np.intp]]:
    """Indices of the joints of each independent loop, the shortest loops that are independent.

    1. Candidates: for each body and each joint the ways of a breadth first walk from the body to both ends of it.
    2. The shortest first, each is kept that is no sum modulo 2 of those before, until there are enough.

    Args:
        linkage: any.
    """
    walked = [np.flatnonzero(row) for row in linkage.cycles]
    if linkage.loops < 2 or len(linkage.bodies) * len(linkage.joints) > MOST_CANDIDATES:
        return walked
    kept, reduced = list[Joints](), dict[int, Joints]()
    for loop in sorted(_candidates(linkage), key=lambda one: (len(one), sorted(one))):
        rest = loop
        while rest and (first := min(rest)) in reduced:
            rest = rest ^ reduced[first]
        if rest:
            reduced[min(rest)] = rest
            kept.append(loop)
        if len(kept) == linkage.loops:
            break
    return [np.array(sorted(loop), dtype=np.intp) for loop in kept]


def _candidates(linkage: Linkage) -> set[Joints]:
    """Step 1."""
    ends: list[tuple[int, int]] = [(int(a), int(b)) for a, b in linkage.ends]
    beside: list[list[tuple[int, int]]] = [[] for _ in linkage.bodies]
    for k, (a, b) in enumerate(ends):
        beside[a].append((k, b))
        beside[b].append((k, a))
    found = set[Joints]()
    for body in range(len(linkage.bodies)):
        ways = _ways(beside, body)
        for k, (a, b) in enumerate(ends):
            if a in ways and b in ways and not ways[a] & ways[b] and k not in ways[a] | ways[b]:
                found.add(ways[a] | ways[b] | {k})
    return found


def _ways(beside: list[list[tuple[int, int]]], start: int) -> dict[int, Joints]:
    """Joints on the way from one body to each that it reaches."""
    ways, waiting = {start: frozenset[int]()}, [start]
    for body in waiting:
        for k, other in beside[body]:
            if other not in ways:
                ways[other] = ways[body] | {k}
                waiting.append(other)
    return ways
