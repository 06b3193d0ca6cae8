"""Dynamics of closed chains, compiled, row by row: accelerations, constraint forces, projections onto the loops.

With M = L L' and z = L' qdd, Gauss' principle asks for the z nearest to the free one L^-1 (tau - h) with X' z = -gamma,
X = L^-1 J'. Orthogonal columns of X, the longest first, end where the others depend on them: loops may ask the same
thing several times.
"""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats, Integers
from mafsil.kernels.loops.loop import compiled
from mafsil.parallel.tolerances import RANK


@compiled
def cholesky(M: Floats, L: Floats) -> bool:
    """L (n, n) with M = L L'; False where M is not positive definite."""
    n = M.shape[0]
    for j in range(n):
        for i in range(j, n):
            total = M[i, j]
            for k in range(j):
                total -= L[i, k] * L[j, k]
            if i == j:
                if not total > 0.0:
                    return False
                L[j, j] = np.sqrt(total)
            else:
                L[i, j] = total / L[j, j]
    return True


@compiled
def forward_solved(L: Floats, x: Floats) -> None:
    """X (n, k) <- L^-1 x."""
    n, k = x.shape
    for c in range(k):
        for i in range(n):
            total = x[i, c]
            for j in range(i):
                total -= L[i, j] * x[j, c]
            x[i, c] = total / L[i, i]


@compiled
def orthogonal(Q: Floats, R: Floats, order: Integers, lengths: Floats) -> int:
    """Columns of Q (n, m) become orthonormal, R (m, m) with X[:, order] = Q R; how many there are.

    1. The column with the longest remainder comes next, until it is nothing but rounding.
    2. It is made one long, twice orthogonal to those before it.
    3. The others lose their part along it.
    """
    n, m = Q.shape
    longest = 0.0
    for j in range(m):
        order[j] = j
        lengths[j] = 0.0
        for i in range(n):
            lengths[j] += Q[i, j] * Q[i, j]
        longest = max(longest, lengths[j])
    R[:, :] = 0.0
    rank = 0
    for r in range(min(n, m)):
        # 1
        best = r
        for j in range(r + 1, m):
            if lengths[j] > lengths[best]:
                best = j
        if not lengths[best] > (RANK * RANK) * longest:
            break
        if best != r:
            order[r], order[best] = order[best], order[r]
            lengths[r], lengths[best] = lengths[best], lengths[r]
            for i in range(n):
                Q[i, r], Q[i, best] = Q[i, best], Q[i, r]
            for i in range(r):
                R[i, r], R[i, best] = R[i, best], R[i, r]
        # 2
        for j in range(r):
            part = 0.0
            for i in range(n):
                part += Q[i, j] * Q[i, r]
            R[j, r] += part
            for i in range(n):
                Q[i, r] -= part * Q[i, j]
        size = 0.0
        for i in range(n):
            size += Q[i, r] * Q[i, r]
        size = np.sqrt(size)
        R[r, r] = size
        for i in range(n):
            Q[i, r] /= size
        rank += 1
        # 3
        for j in range(r + 1, m):
            part = 0.0
            for i in range(n):
                part += Q[i, r] * Q[i, j]
            R[r, j] = part
            lengths[j] = 0.0
            for i in range(n):
                Q[i, j] -= part * Q[i, r]
                lengths[j] += Q[i, j] * Q[i, j]
    return rank


@compiled
def least_norm(R: Floats, rank: int, c: Floats, G: Floats, out: Floats) -> None:
    """Out (m,) the shortest x with R[:rank] x = c, in the order of the columns.

    Args:
        R: (m, m) from `orthogonal`.
        rank: rows that count.
        c: (rank,), spent.
        G: (n, n) room.
        out: (m,) set.
    """
    m = R.shape[1]
    for i in range(rank):
        for j in range(i + 1):
            G[i, j] = 0.0
            for k in range(m):
                G[i, j] += R[i, k] * R[j, k]
    for j in range(rank):
        for i in range(j, rank):
            for k in range(j):
                G[i, j] -= G[i, k] * G[j, k]
            G[i, j] = np.sqrt(G[j, j]) if i == j else G[i, j] / G[j, j]
    for i in range(rank):
        for k in range(i):
            c[i] -= G[i, k] * c[k]
        c[i] /= G[i, i]
    for i in range(rank - 1, -1, -1):
        for k in range(i + 1, rank):
            c[i] -= G[k, i] * c[k]
        c[i] /= G[i, i]
    for k in range(m):
        out[k] = 0.0
        for i in range(rank):
            out[k] += R[i, k] * c[i]


@compiled
def accelerations(
    M: Floats, h: Floats, J: Floats, gamma: Floats, tau: Floats, qdd: Floats, force: Floats, ranks: Integers
) -> None:
    """Accelerations of the tree and forces of the loops.

    1. The free motion z, and X = L^-1 J'.
    2. Orthonormal columns of X; z keeps what is across them and takes along them what the loops ask.
    3. The forces are the shortest with X force = z - z_free.
    4. qdd = L'^-1 z.

    Args:
        M: (rows, n, n); h, tau: (rows, n); J: (rows, m, n); gamma: (rows, m).
        h: bias forces.
        J: rows of the loops.
        gamma: their bias.
        tau: (rows, n) efforts.
        qdd: (rows, n) set.
        force: (rows, m) set.
        ranks: (rows,) set; -1 where the mass matrix is singular.
    """
    rows, m, n = J.shape
    L, Q, R, G = np.zeros((n, n)), np.empty((n, m)), np.empty((m, m)), np.empty((n, n))
    z, order, lengths, shortest = np.empty((n, 1)), np.empty(m, np.int64), np.empty(m), np.empty(m)
    along, asked = np.empty(n), np.empty(n)
    for row in range(rows):
        if not cholesky(M[row], L):
            ranks[row] = -1
            qdd[row], force[row] = np.nan, np.nan
            continue
        # 1
        for i in range(n):
            z[i, 0] = tau[row, i] - h[row, i]
            for j in range(m):
                Q[i, j] = J[row, j, i]
        forward_solved(L, z)
        forward_solved(L, Q)
        # 2
        rank = orthogonal(Q, R, order, lengths)
        ranks[row] = rank
        for k in range(rank):
            asked[k] = -gamma[row, order[k]]
            for i in range(k):
                asked[k] -= R[i, k] * asked[i]
            asked[k] /= R[k, k]
            along[k] = asked[k]
            for i in range(n):
                along[k] -= Q[i, k] * z[i, 0]
        for k in range(rank):
            for i in range(n):
                z[i, 0] += along[k] * Q[i, k]
        # 3
        least_norm(R, rank, along, G, shortest)
        for j in range(m):
            force[row, order[j]] = shortest[j]
        # 4
        for i in range(n - 1, -1, -1):
            for k in range(i + 1, n):
                z[i, 0] -= L[k, i] * z[k, 0]
            z[i, 0] /= L[i, i]
            qdd[row, i] = z[i, 0]


@compiled
def corrections(J: Floats, gap: Floats, step: Floats, ranks: Integers) -> None:
    """The shortest steps with J step = -gap, in the sense of least squares where rows contradict each other.

    Args:
        J: (rows, m, n) rows of the loops.
        gap: (rows, m).
        step: (rows, n) set.
        ranks: (rows,) set.
    """
    rows, m, n = J.shape
    Q, R, order, lengths = np.empty((n, m)), np.empty((m, m)), np.empty(m, np.int64), np.empty(m)
    for row in range(rows):
        for i in range(n):
            step[row, i] = 0.0
            for j in range(m):
                Q[i, j] = J[row, j, i]
        rank = orthogonal(Q, R, order, lengths)
        ranks[row] = rank
        for k in range(rank):
            along = -gap[row, order[k]]
            for i in range(k):
                along -= R[i, k] * lengths[i]
            lengths[k] = along / R[k, k]
            for i in range(n):
                step[row, i] += lengths[k] * Q[i, k]
