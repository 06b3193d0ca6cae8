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
from mafsil.solvers.loops import compiled

LEAF = 4
"""Pieces in a leaf at most."""
DEPTH = 64
"""Nodes that wait while a tree is walked, at most: halves of halves end long before."""


class Tree(NamedTuple):
    """Boxes around pieces; node 0 is the root.

    Attributes:
        box: (m, 6) lowest and highest coordinates of what a node holds.
        left: (m,) index of the first child, the second follows it; -1 at a leaf.
        first, length: (m,) rows of `order` that a node holds: where they begin, how many they are.
        order: (k,) indices of pieces.
    """

    box: Floats
    left: NDArray[np.int64]
    first: NDArray[np.int64]
    length: NDArray[np.int64]
    order: NDArray[np.int64]


class Surroundings(NamedTuple):
    """What stands still: convex pieces posed in one frame, with what finds the near ones.

    Attributes:
        pieces: posed in {s}; `body` is the obstacle.
        tree: over the pieces that have bounds.
        planes: indices of the half spaces.
    """

    pieces: Pieces
    tree: Tree
    planes: NDArray[np.int64]


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
def build_tree(boxes: Floats) -> Tree:
    """The tree over boxes (k, 6): each node is halved at the median of the centres along its longest extent."""
    k = len(boxes)
    most = max(1, 2 * k)
    box, left = np.empty((most, 6)), np.full(most, -1)
    first, length = np.zeros(most, np.int64), np.zeros(most, np.int64)
    order, keys = np.arange(k), np.empty(k)
    length[0], made, at = k, 1, 0
    while at < made:
        box[at, :3], box[at, 3:] = np.inf, -np.inf
        low, high = np.full(3, np.inf), np.full(3, -np.inf)
        for r in range(first[at], first[at] + length[at]):
            row = boxes[order[r]]
            for c in range(3):
                box[at, c] = min(box[at, c], row[c])
                box[at, 3 + c] = max(box[at, 3 + c], row[3 + c])
                centre = row[c] + row[3 + c]
                low[c], high[c] = min(low[c], centre), max(high[c], centre)
        if length[at] > LEAF:
            axis = np.argmax(high - low)
            for r in range(first[at], first[at] + length[at]):
                keys[order[r]] = boxes[order[r], axis] + boxes[order[r], 3 + axis]
            half = length[at] // 2
            _partition(order, keys, first[at], first[at] + length[at] - 1, first[at] + half)
            left[at] = made
            first[made], length[made] = first[at], half
            first[made + 1], length[made + 1] = first[at] + half, length[at] - half
            made += 2
        at += 1
    return Tree(box[:made].copy(), left[:made].copy(), first[:made].copy(), length[:made].copy(), order)


@compiled
def box_gap(box: Floats, x: float, y: float, z: float) -> float:
    """Signed distance of a point to a box (6,): inside minus the distance to the nearest side."""
    dx, dy, dz = max(box[0] - x, x - box[3]), max(box[1] - y, y - box[4]), max(box[2] - z, z - box[5])
    most = max(dx, dy, dz)
    if most <= 0.0:
        return most
    dx, dy, dz = max(0.0, dx), max(0.0, dy), max(0.0, dz)
    return np.sqrt(dx * dx + dy * dy + dz * dz)
