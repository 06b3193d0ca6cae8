"""The facet of a convex hull of points that a direction is nearly normal to, exactly through its points, compiled."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats
from mafsil.kernels.loops.loop import compiled
from mafsil.solvers.disc_loops import Dimension
from mafsil.solvers.tolerances import ON_FACET


@compiled
def facet_through(dimension: Dimension, W: Floats, u: Floats, v: Floats) -> bool:
    """The facet of the hull of columns that points nearly along u.

    1. The columns within `ON_FACET` of the furthest along u are gathered.
    2. Elimination with partial pivoting solves v . w = 1 on m of them.
    3. The others lie on that plane too, and no column of the set beyond it.

    Args:
        dimension: m zeros (see `disc_loops.Dimension`).
        W: (m, n) columns.
        u: (m,) direction.
        v: (m,) out.

    Returns:
        Whether such a facet was found.
    """
    (m, n), found, largest, furthest = W.shape, 0, 0.0, -np.inf
    A, heights = np.empty((n, m + 1)), np.empty(n)
    for j in range(n):
        square, height = 0.0, 0.0
        for c in range(m):
            square += W[c, j] * W[c, j]
            height += W[c, j] * u[c]
        heights[j] = height
        largest, furthest = max(largest, square), max(furthest, height)
    for j in range(n):  # 1
        if heights[j] >= furthest - ON_FACET * np.sqrt(largest):
            for c in range(m):
                A[found, c] = W[c, j]
            A[found, m] = 1.0
            found += 1
    if found < m:
        return False
    for r in range(m):  # 2
        pivot = r
        for i in range(r + 1, found):
            pivot = i if abs(A[i, r]) > abs(A[pivot, r]) else pivot
        if not abs(A[pivot, r]) > ON_FACET * np.sqrt(largest):
            return False
        for c in range(m + 1):
            A[r, c], A[pivot, c] = A[pivot, c], A[r, c]
        for i in range(r + 1, found):
            factor = A[i, r] / A[r, r]
            for c in range(r, m + 1):
                A[i, c] -= factor * A[r, c]
    for r in range(m - 1, -1, -1):
        total = A[r, m]
        for c in range(r + 1, m):
            total -= A[r, c] * v[c]
        v[r] = total / A[r, r]
    for j in range(n):  # 3
        height = 0.0
        for c in range(m):
            height += v[c] * W[c, j]
        if height > 1.0 + ON_FACET:
            return False
        if heights[j] >= furthest - ON_FACET * np.sqrt(largest) and height < 1.0 - ON_FACET:
            return False
    return True
