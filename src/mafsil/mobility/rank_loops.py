"""Mobility by rank of many configurations of one linkage, compiled.

For each row of coordinates, free of units:

1. Bodies along the walk from the ground; every joint as a product of exponentials, its screws where they are now.
2. Rows of the loops: six for each, the screws of the joints that the loop passes, with their senses.
3. Rank: the longest row left is taken as the next direction and removed from the others (Gram and Schmidt with
   pivots), until what is left is below the tolerance against the first. Rows within two digits of the tolerance are in
   doubt and left to singular values.
"""

from __future__ import annotations

from math import cos, sin, sqrt

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.kernels.loops.loop import compiled, reordered

DOUBTFUL = 100.0


@compiled
def moved_by(T: Floats, S: Floats, u: float) -> None:
    """T <- T exp([S] u), T (12,) as rotation by rows and place, S (6,) with |omega| one or zero."""
    wx, wy, wz = S[0], S[1], S[2]
    if wx == 0.0 and wy == 0.0 and wz == 0.0:
        px, py, pz = u * S[3], u * S[4], u * S[5]
        for i in range(3):
            T[9 + i] += T[3 * i] * px + T[3 * i + 1] * py + T[3 * i + 2] * pz
        return
    s, h = sin(u), sin(u / 2)
    c1 = 2 * h * h
    cvx, cvy, cvz = wy * S[5] - wz * S[4], wz * S[3] - wx * S[5], wx * S[4] - wy * S[3]
    along = wx * S[3] + wy * S[4] + wz * S[5]
    # (I u + (1 - cos) [w] + (u - sin) [w]^2) v, with [w]^2 v = w (w . v) - v
    px = s * S[3] + c1 * cvx + (u - s) * along * wx
    py = s * S[4] + c1 * cvy + (u - s) * along * wy
    pz = s * S[5] + c1 * cvz + (u - s) * along * wz
    c = cos(u)
    for i in range(3):
        a, b, d = T[3 * i], T[3 * i + 1], T[3 * i + 2]
        T[9 + i] += a * px + b * py + d * pz
        ax, ay, az = b * wz - d * wy, d * wx - a * wz, a * wy - b * wx
        dot = a * wx + b * wy + d * wz
        T[3 * i] = c * a + s * ax + c1 * dot * wx
        T[3 * i + 1] = c * b + s * ay + c1 * dot * wy
        T[3 * i + 2] = c * d + s * az + c1 * dot * wz


@compiled
def transform_screw(T: Floats, S: Floats, out: Floats) -> None:
    """Out (6,) <- Ad(T) S."""
    for i in range(3):
        out[i] = T[3 * i] * S[0] + T[3 * i + 1] * S[1] + T[3 * i + 2] * S[2]
        out[3 + i] = T[3 * i] * S[3] + T[3 * i + 1] * S[4] + T[3 * i + 2] * S[5]
    out[3] += T[10] * out[2] - T[11] * out[1]
    out[4] += T[11] * out[0] - T[9] * out[2]
    out[5] += T[9] * out[1] - T[10] * out[0]


@compiled
def place_bodies(
    u: Floats, S: Floats, first: NDArray[np.int64], tree: NDArray[np.int64], ends: NDArray[np.int64],
    closing: NDArray[np.int64], T: Floats, W: Floats,
) -> None:  # fmt: skip
    """Step 1: bodies T (N, 12) and screws W (F, 6) at coordinates u (F,).

    Args:
        u: free of units.
        S: (F, 6) screws as drawn, free of units.
        first: (J + 1,) index of the first coordinate of each joint.
        tree: (N - 1, 2) joint, and 1 if it is passed forwards.
        ends: (J, 2) bodies.
        closing: joints that close the loops.
        T, W: what is filled.
    """
    for i in range(12):
        T[0, i] = 1.0 if i in (0, 4, 8) else 0.0
    here = np.empty(12)
    for step in range(len(tree) + len(closing)):
        loop = step >= len(tree)
        j = closing[step - len(tree)] if loop else tree[step, 0]
        a, b = ends[j, 0], ends[j, 1]
        if not loop and tree[step, 1] == 0:
            here[:] = T[b]
            for k in range(first[j + 1] - 1, first[j] - 1, -1):
                moved_by(here, S[k], -u[k])
            T[a] = here
        here[:] = T[a]
        for k in range(first[j], first[j + 1]):
            transform_screw(here, S[k], W[k])
            moved_by(here, S[k], u[k])
        if not loop and tree[step, 1] == 1:
            T[b] = here


@reordered
def rank_of_rows(A: Floats, size: Floats, tolerance: float) -> tuple[int, float]:
    """Step 3: rank of A (m, n), which is destroyed, and how near the decision was: the ratio to the tolerance, >= 1.

    1. The longest row that is left; if it is below the tolerance, the rank is what was taken before.
    2. It becomes a unit vector, and what the others have of it is removed from them.

    Args:
        A: rows.
        size: (m,) room for squares of lengths.
        tolerance: share of the longest row below which a row is zero.
    """
    m, n = A.shape
    for i in range(m):
        total = 0.0
        for k in range(n):
            total += A[i, k] * A[i, k]
        size[i] = total
    largest, last, rank = 0.0, 1.0, 0
    while rank < m:
        # 1.
        best, pivot = 0.0, -1
        for i in range(m):
            if size[i] > best:
                best, pivot = size[i], i
        if rank == 0:
            largest = best
        if pivot < 0 or best <= tolerance * tolerance * largest:
            left = sqrt(best / largest) if largest > 0.0 else 0.0
            below = tolerance / left if left > 0.0 else np.inf
            return rank, min(below, last / tolerance)
        # 2.
        last = sqrt(best / largest)
        scale = 1.0 / sqrt(best)
        size[pivot] = -1.0
        for k in range(n):
            A[pivot, k] *= scale
        for i in range(m):
            if size[i] > 0.0:
                dot = 0.0
                for k in range(n):
                    dot += A[i, k] * A[pivot, k]
                if dot != 0.0:
                    total = 0.0
                    for k in range(n):
                        A[i, k] -= dot * A[pivot, k]
                        total += A[i, k] * A[i, k]
                    size[i] = total
        rank += 1
    return rank, last / tolerance


@compiled
def ranks(
    u: Floats, S: Floats, first: NDArray[np.int64], tree: NDArray[np.int64], ends: NDArray[np.int64],
    closing: NDArray[np.int64], cycles: NDArray[np.int64], tolerance: float, rank: NDArray[np.int64],
    doubt: NDArray[np.bool_],
) -> None:  # fmt: skip
    """Rank of the loop matrix at each row of u (B, F); arguments as of `place_bodies`.

    Args:
        u, S, first, tree, ends, closing: see `place_bodies`.
        cycles: (L, J) senses in which the loops pass the joints.
        tolerance: see `rank_of_rows`.
        rank: (B,) filled.
        doubt: (B,) filled: whether the decision is within two digits of the tolerance.
    """
    F, L = len(S), len(closing)
    T, W, A, size = np.zeros((ends.max() + 1, 12)), np.zeros((F, 6)), np.zeros((6 * L, F)), np.zeros(6 * L)
    for row in range(len(u)):
        place_bodies(u[row], S, first, tree, ends, closing, T, W)  # 1
        A[:] = 0.0
        for loop in range(L):  # 2
            for j in range(len(ends)):
                sense = cycles[loop, j]
                if sense != 0:
                    for k in range(first[j], first[j + 1]):
                        for i in range(6):
                            A[6 * loop + i, k] = sense * W[k, i]
        rank[row], margin = rank_of_rows(A, size, tolerance)  # 3
        doubt[row] = not margin > DOUBTFUL
