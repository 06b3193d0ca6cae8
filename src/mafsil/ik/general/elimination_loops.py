"""The compiled elimination: from poses to determinants that are trigonometric polynomials of one joint.

Imported only where poses are solved: numba is loaded with it. Each function that Python calls takes a whole batch and
is compiled alone: what one of them calls is optimised again with it, so they call little.
"""

# pyright: reportMissingParameterType=false, reportUnknownVariableType=false
from __future__ import annotations

from math import sqrt

import numpy as np

from mafsil.solvers.loops import reordered


@reordered
def eliminated(P, before, lines, after, products, left, unit, C, beta, A):
    """Six equations in c, d, e for every pose, and the factors of the 14 x 8 system of a and b.

    Args:
        P: (k, 4, 4) displacements of the loop.
        before, lines, after, products, left, unit: constants of a road.
        C: (k, 14, 9) constants of the equations, then the factors.
        beta: (k, 16) scales of the reflections, and their diagonal.
        A: (k, 6, 27) coefficients of the six equations.
    """
    S, Q = np.empty((14, 9)), np.empty((14, 6))
    for b in range(len(P)):
        _lines(P[b], before, lines, after, S)
        for r in range(14):
            for c in range(9):
                C[b, r, c] = 0.0
            for k in range(9):
                for c in range(9):
                    C[b, r, c] += S[r, k] * products[k, c]
        _left_null_space(C[b], beta[b], Q)
        for r in range(6):
            for c in range(27):
                A[b, r, c] = 0.0
            constant = 0.0
            for e in range(14):
                x = Q[e, r]
                constant += x * C[b, e, 0]
                for c in range(27):
                    A[b, r, c] += x * left[e, c]
            for j in range(3):
                A[b, r, 3 * j] -= constant * unit[j]


@reordered
def _lines(X, before, lines, after, S):
    """The fourteen functions of nine lines moved by a pose."""
    y, m = np.empty(3), np.empty(3)
    for k in range(9):
        i, j = k // lines, k % lines
        for r in range(3):
            y[r], m[r] = X[r, 3], 0.0
            for c in range(3):
                y[r] += X[r, c] * before[j, c]
                m[r] += X[r, c] * before[j, 3 + c]
        pp = pl = 0.0
        for r in range(3):
            p, l = after[i, r, 3], 0.0
            for c in range(3):
                p += after[i, r, c] * y[c]
                l += after[i, r, c] * m[c]
            S[r, k], S[4 + r, k] = p, l
            pp += p * p
            pl += p * l
        S[3, k], S[7, k] = pp, pl
        for r in range(3):
            u, v = (r + 1) % 3, (r + 2) % 3
            S[8 + r, k] = S[u, k] * S[4 + v, k] - S[v, k] * S[4 + u, k]
            S[11 + r, k] = pp * S[4 + r, k] - 2 * pl * S[r, k]


@reordered
def _left_null_space(C, beta, Q):
    """Householder factors of the columns of a and b; what is left of the unit vectors spans their left null space."""
    for r in range(14):
        for c in range(6):
            Q[r, c] = 1.0 if r == c + 8 else 0.0
    for k in range(8):
        norm = 0.0
        for r in range(k, 14):
            norm += C[r, k + 1] ** 2
        norm = sqrt(norm)
        alpha = -norm if C[k, k + 1] > 0 else norm
        head = C[k, k + 1] - alpha
        beta[k] = 0.0 if norm == 0.0 else -1.0 / (alpha * head)
        beta[8 + k] = alpha
        C[k, k + 1] = head
        for c in range(k + 2, 9):
            dot = 0.0
            for r in range(k, 14):
                dot += C[r, k + 1] * C[r, c]
            dot *= beta[k]
            for r in range(k, 14):
                C[r, c] -= dot * C[r, k + 1]
    for k in range(7, -1, -1):
        for c in range(6):
            dot = 0.0
            for r in range(k, 14):
                dot += C[r, k + 1] * Q[r, c]
            dot *= beta[k]
            for r in range(k, 14):
                Q[r, c] -= dot * C[r, k + 1]


@reordered
def determinants(A, cosines, sines, f):
    """The determinants of the twelve equations at nodes of joint c, side by side in lanes.

    Two orthogonal triangulations of six by three, then one of six by six; the sign is that of a fixed number of
    reflections.

    Args:
        A: (k, 6, 27) coefficients.
        cosines, sines: (k, nodes), or (1, nodes) for all.
        f: (k, nodes) the determinants.
    """
    nodes = f.shape[1]
    M, K, room = np.empty((6, 9, nodes)), np.empty((6, 6, nodes)), np.empty((2, nodes))
    for b in range(len(A)):
        x, y, out = cosines[min(b, len(cosines) - 1)], sines[min(b, len(sines) - 1)], f[b]
        for l in range(nodes):
            out[l] = 1.0
        # One place that calls the loop below, so that it is compiled once.
        for part in range(3):
            columns = 9 if part < 2 else 6
            for r in range(6):
                for j in range(columns):
                    if part < 2:
                        # The second half starts with the last block.
                        source = j if part == 0 else (6 + j if j < 3 else j - 3)
                        m0, m1, m2 = A[b, r, source], A[b, r, 9 + source], A[b, r, 18 + source]
                        for l in range(nodes):
                            M[r, j, l] = m0 + x[l] * m1 + y[l] * m2
                    else:
                        for l in range(nodes):
                            M[r, j, l] = K[r, j, l]
            _triangulated(M, 3 if part < 2 else 5, columns, out, room)
            for r in range(3 if part < 2 else 0):
                for j in range(6):
                    for l in range(nodes):
                        K[3 * part + r, j, l] = M[3 + r, 3 + j, l]
        for l in range(nodes):
            out[l] *= M[5, 5, l]


@reordered
def _triangulated(M, steps, columns, f, room):
    """Householder steps in lanes; f is multiplied by the diagonal entries."""
    rows, count = M.shape[0], M.shape[2]
    for k in range(steps):
        for l in range(count):
            room[0, l] = 0.0
        for r in range(k, rows):
            for l in range(count):
                room[0, l] += M[r, k, l] * M[r, k, l]
        for l in range(count):
            norm = sqrt(room[0, l])
            x = M[k, k, l]
            alpha = -norm if x > 0 else norm
            f[l] *= alpha
            M[k, k, l] = x - alpha
            room[0, l] = 1.0 / (norm * abs(x - alpha) + 1e-300)
        for j in range(k + 1, columns):
            for l in range(count):
                room[1, l] = 0.0
            for r in range(k, rows):
                for l in range(count):
                    room[1, l] += M[r, k, l] * M[r, j, l]
            for l in range(count):
                room[1, l] *= room[0, l]
            for r in range(k, rows):
                for l in range(count):
                    M[r, j, l] -= room[1, l] * M[r, k, l]


@reordered
def harmonics_of(f, fourier, degree, out, dust):
    """Coefficients of trigonometric polynomials from their samples.

    Args:
        f: (k, nodes) samples.
        fourier: (nodes, nodes) rows a_0, b_1, a_1, b_2, a_2, ...
        degree: of the polynomials.
        out: (k, 2, degree + 1) of cos and sin.
        dust: (k,) the largest of the coefficients that must be zero.
    """
    for b in range(len(f)):
        dust[b] = 0.0
        for i in range(f.shape[1]):
            total = 0.0
            for l in range(f.shape[1]):
                total += fourier[i, l] * f[b, l]
            if i <= 2 * degree:
                out[b, i & 1, (i + 1) >> 1] = total
            else:
                dust[b] = max(dust[b], abs(total))
        out[b, 1, 0] = 0.0
