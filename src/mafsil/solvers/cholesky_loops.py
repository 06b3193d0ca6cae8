"""Small symmetric matrices factored, S = L L', compiled: a row and column more or less without factoring anew.

And tridiagonal systems.

Reference:
    P. E. Gill, G. H. Golub, W. Murray and M. A. Saunders, Methods for modifying matrix factorizations, Mathematics of
    Computation 28, 1974.
"""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats
from mafsil.kernels.loops.loop import compiled, reordered


@reordered
def factor(S: Floats, m: int) -> bool:
    """S = L L' in place, row by row: whether it is positive definite.

    Args:
        S: (>= m, >= m), of which the lower left is used.
        m: size.
    """
    for i in range(m):
        for k in range(i + 1):
            s = S[i, k]
            for c in range(k):
                s -= S[i, c] * S[k, c]
            if k < i:
                S[i, k] = s / S[k, k]
            elif s > 0.0:
                S[i, i] = np.sqrt(s)
            else:
                return False
    return True


@compiled
def solve(L: Floats, m: int, b: Floats) -> None:
    """L L' x = b, x in place of b.

    Args:
        L: (>= m, >= m) lower left.
        m: size.
        b: (>= m,) in and out.
    """
    for i in range(m):
        s = b[i]
        for c in range(i):
            s -= L[i, c] * b[c]
        b[i] = s / L[i, i]
    for i in range(m - 1, -1, -1):
        b[i] /= L[i, i]
        for c in range(i):
            b[c] -= L[i, c] * b[i]


@compiled
def append_row(L: Floats, m: int, row: Floats) -> bool:
    """One more row and column: L of m + 1 from L of m; whether it is still positive definite.

    Args:
        L: (> m, > m) lower left, in and out.
        m: size before.
        row: (> m,) the new row of the matrix, its diagonal last.
    """
    for k in range(m):
        s = row[k]
        for c in range(k):
            s -= L[m, c] * L[k, c]
        L[m, k] = s / L[k, k]
    s = row[m]
    for c in range(m):
        s -= L[m, c] * L[m, c]
    if not s > 0.0:
        return False
    L[m, m] = np.sqrt(s)
    return True


@compiled
def drop_row(L: Floats, m: int, gone: int, column: Floats) -> None:
    """Without one row and column: what it had below the diagonal goes into the rest by a rank-one update.

    Args:
        L: (>= m, >= m) lower left, in and out.
        m: size before.
        gone: which.
        column: (>= m,) to work in.
    """
    for i in range(gone + 1, m):
        column[i - 1] = L[i, gone]
        for c in range(gone):
            L[i - 1, c] = L[i, c]
        for c in range(gone + 1, i + 1):
            L[i - 1, c - 1] = L[i, c]
    for k in range(gone, m - 1):
        length = np.hypot(L[k, k], column[k])
        c, s = L[k, k] / length, column[k] / length
        L[k, k] = length
        for i in range(k + 1, m - 1):
            below = c * L[i, k] + s * column[i]
            column[i] = c * column[i] - s * L[i, k]
            L[i, k] = below


@compiled
def solve_tridiagonal(lower: Floats, diagonal: Floats, upper: Floats, x: Floats) -> None:
    """A system that needs no pivots, by elimination, in place; the diagonal is written over.

    Args:
        lower, diagonal, upper: (k,) of which the first of `lower` and the last of `upper` do not count.
        x: (k, m) right sides, then solutions.
    """
    k, m = x.shape
    for i in range(1, k):
        weight = lower[i] / diagonal[i - 1]
        diagonal[i] -= weight * upper[i - 1]
        for j in range(m):
            x[i, j] -= weight * x[i - 1, j]
    for j in range(m):
        x[k - 1, j] /= diagonal[k - 1]
    for i in range(k - 2, -1, -1):
        for j in range(m):
            x[i, j] = (x[i, j] - upper[i] * x[i + 1, j]) / diagonal[i]
