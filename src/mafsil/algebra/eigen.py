"""Symmetric eigenproblems of fixed small size as straight-line expressions: cyclic Jacobi rotations, no branches."""

from __future__ import annotations

import mafsil.expression as ex

SWEEPS = 6
"""Cyclic sweeps; convergence is quadratic, sizes 3 and 4 are converged to rounding after four to five."""


def symmetric(K: ex.Expression, sweeps: int = SWEEPS) -> tuple[ex.Expression, ex.Expression]:
    """Eigenvalues (n,) in no order and eigenvectors, the columns of (n, n), of a symmetric (n, n) matrix.

    Reference: Golub & Van Loan, Matrix Computations, sec. 8.5 (Jacobi methods).
    """
    n = K.shape[0]
    A = [[K[i, j] for j in range(n)] for i in range(n)]
    V = [[ex.Expression(float(i == j)) for j in range(n)] for i in range(n)]
    for _ in range(sweeps):
        for p in range(n - 1):
            for q in range(p + 1, n):
                _annihilate(A, V, p, q)
    return ex.vertcat(*(A[i][i] for i in range(n))), ex.blockcat(V)


def dominant_vector(K: ex.Expression) -> ex.Expression:
    """(n,) unit eigenvector of the largest eigenvalue of a symmetric matrix."""
    values, vectors = symmetric(K)
    best, largest = vectors[:, 0], values[0]
    for k in range(1, K.shape[0]):
        better = values[k] > largest
        best, largest = ex.if_else(better, vectors[:, k], best), ex.if_else(better, values[k], largest)
    return best


def _annihilate(A: list[list[ex.Expression]], V: list[list[ex.Expression]], p: int, q: int) -> None:
    """One Jacobi rotation in the plane (p, q), in place; the identity where the entry is zero already."""
    apq = A[p][q]
    zero = ex.fabs(apq) <= 2.0**-56 * ex.sqrt(A[p][p] ** 2 + A[q][q] ** 2)
    tau = (A[q][q] - A[p][p]) / (2 * ex.if_else(zero, 1.0, apq))
    t = ex.if_else(tau < 0, -1.0, 1.0) / (ex.fabs(tau) + ex.sqrt(1 + tau**2))
    t = ex.if_else(zero, 0.0, t)
    c = 1 / ex.sqrt(1 + t**2)
    s = t * c
    A[p][p], A[q][q] = A[p][p] - t * apq, A[q][q] + t * apq
    A[p][q] = A[q][p] = ex.Expression(0)
    for k in range(len(A)):
        if k not in (p, q):
            a, b = A[k][p], A[k][q]
            A[k][p] = A[p][k] = c * a - s * b
            A[k][q] = A[q][k] = s * a + c * b
        a, b = V[k][p], V[k][q]
        V[k][p], V[k][q] = c * a - s * b, s * a + c * b
