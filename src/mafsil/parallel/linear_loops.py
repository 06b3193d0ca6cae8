"""Square systems of a few real or complex unknowns, compiled: Gaussian elimination with pivots, in place."""

from __future__ import annotations

from typing import Any

from mafsil.kernels.loops.loop import compiled, inlined


@inlined
def _size(z: Any) -> float:
    """|re z| + |im z|: as good for the choice of a pivot, and no square root."""
    return abs(z.real) + abs(z.imag)


@compiled
def solve_in_place(M: Any, rhs: Any) -> float:
    """The right side (n, k) becomes M^-1 rhs, M (n, n) is spent; returns the least pivot over the largest.

    1. Column by column the largest entry below the diagonal comes up as the pivot; none, the matrix is singular: 0.
    2. The rows below lose their entry of that column.
    3. Back from the last row.
    """
    n, k = M.shape[0], rhs.shape[1]
    least, most = 1e308, 0.0
    for c in range(n):
        # 1.
        best, size = c, _size(M[c, c])
        for i in range(c + 1, n):
            other = _size(M[i, c])
            if other > size:
                best, size = i, other
        if not size > 0.0:
            return 0.0
        least, most = min(least, size), max(most, size)
        if best != c:
            for j in range(c, n):
                M[c, j], M[best, j] = M[best, j], M[c, j]
            for j in range(k):
                rhs[c, j], rhs[best, j] = rhs[best, j], rhs[c, j]
        # 2.
        over = 1.0 / M[c, c]
        M[c, c] = over
        for i in range(c + 1, n):
            factor = M[i, c] * over
            for j in range(c + 1, n):
                M[i, j] -= factor * M[c, j]
            for j in range(k):
                rhs[i, j] -= factor * rhs[c, j]
    # 3.
    for c in range(n - 1, -1, -1):
        for j in range(k):
            value = rhs[c, j]
            for i in range(c + 1, n):
                value -= M[c, i] * rhs[i, j]
            rhs[c, j] = value * M[c, c]
    return least / most
