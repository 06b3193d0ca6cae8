"""Linear algebra of numbers that are not there yet: elimination and rotations of fixed length, without decisions."""

from __future__ import annotations

from typing import Any, TypeAlias

from mafsil.kernels.traced_number import chosen, larger, negative, root, vanishes

Rows: TypeAlias = list[list[Any]]
"""Numbers, or Numbers of expressions."""
SWEEPS = 8
"""Of Jacobi's rotations: they converge quadratically; matrices of six rows are diagonal to rounding after six."""


def eliminate(A: Rows, b: Rows) -> Rows:
    """X with A X = b, by elimination with exchange of rows; both are used up.

    Args:
        A: (n, n).
        b: (n, k).
    """
    n = len(A)
    for k in range(n):
        for i in range(k + 1, n):
            exchange = larger(A[i][k], A[k][k])
            for rows, first in ((A, k), (b, 0)):
                for j in range(first, len(rows[0])):
                    upper, lower = rows[k][j], rows[i][j]
                    rows[k][j], rows[i][j] = chosen(exchange, lower, upper), chosen(exchange, upper, lower)
        for i in range(k + 1, n):
            share = A[i][k] / A[k][k]
            A[i][k + 1 :] = [x - share * y for x, y in zip(A[i][k + 1 :], A[k][k + 1 :], strict=True)]
            b[i] = [x - share * y for x, y in zip(b[i], b[k], strict=True)]
    for k in reversed(range(n)):
        for i in range(k + 1, n):
            b[k] = [x - A[k][i] * y for x, y in zip(b[k], b[i], strict=True)]
        b[k] = [x / A[k][k] for x in b[k]]
    return b


def axes_of(A: Rows) -> tuple[list[Any], Rows]:
    """Eigenvalues (n,), in any order, and axes (n, n) as columns, of a symmetric matrix (n, n), which is used up.

    Jacobi's rotation by t = tan(angle) makes a_pq zero: with d = a_qq - a_pp, t = 2 a_pq / (d +- sqrt(d^2 + 4 a_pq^2)),
    the smaller of both; where a_pq and d are zero, t is.
    """
    n = len(A)
    axes: Rows = [[1.0 if i == j else 0.0 for j in range(n)] for i in range(n)]
    pairs = [(i, j) for i in range(n) for j in range(i + 1, n)]
    for p, q in pairs * SWEEPS:
        d, twice = A[q][q] - A[p][p], 2.0 * A[p][q]
        length = root(d * d + twice * twice)
        down = d + chosen(negative(d), -length, length)
        t = twice / chosen(vanishes(length), 1.0, down)
        c = 1.0 / root(1.0 + t * t)
        s = t * c
        A[p][p], A[q][q] = A[p][p] - t * A[p][q], A[q][q] + t * A[p][q]
        A[p][q] = A[q][p] = 0.0
        for k in range(n):
            if k not in (p, q):
                x, y = A[k][p], A[k][q]
                A[k][p] = A[p][k] = c * x - s * y
                A[k][q] = A[q][k] = s * x + c * y
            x, y = axes[k][p], axes[k][q]
            axes[k][p], axes[k][q] = c * x - s * y, s * x + c * y
    return [A[k][k] for k in range(n)], axes
