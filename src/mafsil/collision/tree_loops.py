"""A tree of boxes around many convex pieces, compiled: built once, then asked what is near a ball.

Reference:
    C. Ericson, Real-Time Collision Detection, 2005, ch. 6.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.collision.support_loops import Pieces
from mafsil.kernels.loops.loop import compiled, inlined

LEAF = 4
"""Pieces in a leaf at most."""
DEPTH = 64
"""Nodes that wait while a tree is walked, at most: halves of halves end long before."""


class Surroundings(NamedTuple):
    """What stands still: convex pieces posed in one frame, with what finds the near ones.

    Attributes:
        pieces: posed in {s}; first the half spaces, then the others in the order of the tree's leaves.
        nodes: (m, 9) of the tree: lowest and highest coordinates (6) of what a node holds, index of its first child
            (the second follows it; -1 at a leaf), first row of `pieces` that it holds, number of rows; node 0 is the
            root. Empty without bounded pieces.
        boxes: (k, 6) middles and half extents of boxes around the pieces, along the axes of {s}; infinite for half
            spaces.
        planes: number of half spaces.
    """

    pieces: Pieces
    nodes: Floats
    boxes: Floats
    planes: int


@compiled
def _partition(order: NDArray[np.int64], keys: Floats, first: int, last: int, middle: int) -> None:
    """Rows of `order` so that those before `middle` have keys no larger than it, those behind no smaller (Hoare)."""
    while first < last:
        pivot = keys[order[(first + last) // 2]]
        i, j = first, last
        while i <= j:
            while keys[order[i]] < pivot:
                i += 1
            while keys[order[j]] > pivot:
                j -= 1
            if i <= j:
                order[i], order[j] = order[j], order[i]
                i += 1
                j -= 1
        if middle <= j:
            last = j
        elif middle >= i:
            first = i
        else:
            return


@compiled
def build_tree(boxes: Floats) -> tuple[Floats, NDArray[np.int64]]:
    """Nodes (m, 9) of the tree over boxes (k, 6), and the order of the boxes in its leaves.

    Each node is halved at the median of the centres along the longest extent of the centres.
    """
    k = len(boxes)
    nodes, order, keys = np.empty((2 * k, 9)), np.arange(k), np.empty(k)
    made, at = 0, 0
    if k > 0:
        nodes[0, 6], nodes[0, 7], nodes[0, 8], made = -1, 0, k, 1
    while at < made:
        node = nodes[at]
        first, length = int(node[7]), int(node[8])
        node[:3], node[3:6] = np.inf, -np.inf
        low, high = np.full(3, np.inf), np.full(3, -np.inf)
        for r in range(first, first + length):
            row = boxes[order[r]]
            for c in range(3):
                node[c], node[3 + c] = min(node[c], row[c]), max(node[3 + c], row[3 + c])
                centre = row[c] + row[3 + c]
                low[c], high[c] = min(low[c], centre), max(high[c], centre)
        if length > LEAF:
            axis = np.argmax(high - low)
            for r in range(first, first + length):
                keys[order[r]] = boxes[order[r], axis] + boxes[order[r], 3 + axis]
            half = length // 2
            _partition(order, keys, first, first + length - 1, first + half)
            node[6] = made
            nodes[made, 6], nodes[made, 7], nodes[made, 8] = -1, first, half
            nodes[made + 1, 6], nodes[made + 1, 7], nodes[made + 1, 8] = -1, first + half, length - half
            made += 2
        at += 1
    return nodes[:made].copy(), order


@inlined
def box_gap(box: Floats, x: float, y: float, z: float) -> float:
    """Signed distance of a point to a box (6,): inside minus the distance to the nearest side."""
    dx, dy, dz = max(box[0] - x, x - box[3]), max(box[1] - y, y - box[4]), max(box[2] - z, z - box[5])
    most = max(dx, dy, dz)
    if most <= 0.0:
        return most
    dx, dy, dz = max(0.0, dx), max(0.0, dy), max(0.0, dz)
    return np.sqrt(dx * dx + dy * dy + dz * dz)
