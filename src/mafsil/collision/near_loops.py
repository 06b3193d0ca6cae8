"""What of the surroundings is nearest to a convex piece, compiled: the tree is walked, the nearer child first.

1. The ball around the piece against a node's box bounds the distance from below: further than the best, it is left.
2. In a leaf the balls are compared, then the pieces themselves (`separation`), which give up past the best.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.collision.pair_loops import ROW, WORKSPACE, separation
from mafsil.collision.support_loops import Pieces, product, relative
from mafsil.collision.tree_loops import DEPTH, Surroundings, box_gap
from mafsil.kernels.loops.loop import compiled


@compiled
def nearest(
    A: Pieces, i: int, T: Floats, around: Surroundings, cutoff: float,
    waiting: NDArray[np.int64], W: Floats, row: Floats, out: Floats,
) -> int:  # fmt: skip
    """The piece of the surroundings nearest to piece i of A, if nearer than the cutoff; else -1.

    Args:
        T: (3, 4) pose of A's body in the frame of the surroundings.
        cutoff: distances beyond it do not matter.
        waiting: (DEPTH,) nodes to walk.
        W, row: WORKSPACE and (ROW + 2, 4) to work in.
        out: (ROW,) separation from the piece found; as it was if there is none.
    """
    B, nodes = around.pieces, around.nodes
    P, best, found = row[:3], cutoff, -1
    posed = False
    x = T[0, 0] * A.rows[i, 8] + T[0, 1] * A.rows[i, 9] + T[0, 2] * A.rows[i, 10] + T[0, 3]
    y = T[1, 0] * A.rows[i, 8] + T[1, 1] * A.rows[i, 9] + T[1, 2] * A.rows[i, 10] + T[1, 3]
    z = T[2, 0] * A.rows[i, 8] + T[2, 1] * A.rows[i, 9] + T[2, 2] * A.rows[i, 10] + T[2, 3]
    radius = A.rows[i, 11]
    for j in range(around.planes):
        F = B.T[j]
        height = F[0, 2] * (x - F[0, 3]) + F[1, 2] * (y - F[1, 3]) + F[2, 2] * (z - F[2, 3])
        if height - radius > best:
            continue
        if not posed:
            product(T, A.T[i], P)
            posed = True
        if separation(A, i, P, B, j, F, best, True, W, out) <= best:
            best, found = min(best, out[0]), j
    if len(nodes) == 0:
        return found
    waiting[0], count = 0, 1
    while count > 0:
        count -= 1
        node = waiting[count]
        if box_gap(nodes[node], x, y, z) - radius > best:  # 1
            continue
        left = int(nodes[node, 6])
        if left >= 0:
            near, far = left, left + 1
            if box_gap(nodes[far], x, y, z) < box_gap(nodes[near], x, y, z):
                near, far = far, near
            waiting[count], waiting[count + 1] = far, near
            count += 2
            continue
        first = around.planes + int(nodes[node, 7])
        for j in range(first, first + int(nodes[node, 8])):  # 2
            dx, dy, dz = B.rows[j, 8] - x, B.rows[j, 9] - y, B.rows[j, 10] - z
            reach = best + radius + B.rows[j, 11]
            if reach < 0.0 or dx * dx + dy * dy + dz * dz > reach * reach:
                continue
            if not posed:
                product(T, A.T[i], P)
                posed = True
            if separation(A, i, P, B, j, B.T[j], best, True, W, out) <= best:
                best, found = min(best, out[0]), j
    return found


@compiled
def nearest_of_all(A: Pieces, T_a: Floats, around: Surroundings, T_b: Floats, out: Floats) -> None:
    """Separation of all pieces of A from the surroundings, for many poses of both.

    Args:
        T_a, T_b: (m, 4, 4) poses of A's body and of the surroundings.
        out: (m, ROW) the nearest pair's separation, in the frame that the poses are in.
    """
    W, row, waiting = np.empty(WORKSPACE), np.zeros((4, 4)), np.empty(DEPTH, np.int64)
    T, one = np.empty((3, 4)), np.empty(ROW)
    for r in range(len(T_a)):
        relative(T_b[r], T_a[r], T)
        best = np.inf
        for i in range(len(A.rows)):
            if nearest(A, i, T, around, best, waiting, W, row, one) >= 0 and one[0] < best:
                best = one[0]
                out[r, 0] = one[0]
                for k in range(3):
                    for part in range(1, ROW, 3):
                        out[r, part + k] = T_b[r, k, 3] if part < 7 else 0.0
                        for c in range(3):
                            out[r, part + k] += T_b[r, k, c] * one[part + c]
