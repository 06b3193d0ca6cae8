"""The compiled elimination: from a pose to a determinant in one joint, and from its zero to the other joints.

Imported only where poses are solved: numba is loaded with it. Arrays named `w_...` are room to work in.
"""

# pyright: reportMissingParameterType=false, reportUnknownVariableType=false
from __future__ import annotations

from math import atan2, cos, hypot, sin, sqrt

import numpy as np

from mafsil.solvers.loops import compiled


@compiled
def eliminated(P, before, lines, after, products, left, unit, w_C, w_Q, w_A, w_beta):
    """Coefficients (6, 3, 9) of six equations in c, d, e; the factors of the 14 x 8 system of a and b stay in w_C.

    Arguments as the attributes of `Arm` and `Room` in `solution_loops`.
    """
    w_S = w_Q[:, 6:15]
    for j in range(lines):
        p0 = P[0, 0] * before[j, 0] + P[0, 1] * before[j, 1] + P[0, 2] * before[j, 2] + P[0, 3]
        p1 = P[1, 0] * before[j, 0] + P[1, 1] * before[j, 1] + P[1, 2] * before[j, 2] + P[1, 3]
        p2 = P[2, 0] * before[j, 0] + P[2, 1] * before[j, 1] + P[2, 2] * before[j, 2] + P[2, 3]
        l0 = P[0, 0] * before[j, 3] + P[0, 1] * before[j, 4] + P[0, 2] * before[j, 5]
        l1 = P[1, 0] * before[j, 3] + P[1, 1] * before[j, 4] + P[1, 2] * before[j, 5]
        l2 = P[2, 0] * before[j, 3] + P[2, 1] * before[j, 4] + P[2, 2] * before[j, 5]
        for i in range(9 // lines):
            M = after[i]
            x = M[0, 0] * p0 + M[0, 1] * p1 + M[0, 2] * p2 + M[0, 3]
            y = M[1, 0] * p0 + M[1, 1] * p1 + M[1, 2] * p2 + M[1, 3]
            z = M[2, 0] * p0 + M[2, 1] * p1 + M[2, 2] * p2 + M[2, 3]
            u = M[0, 0] * l0 + M[0, 1] * l1 + M[0, 2] * l2
            v = M[1, 0] * l0 + M[1, 1] * l1 + M[1, 2] * l2
            w = M[2, 0] * l0 + M[2, 1] * l1 + M[2, 2] * l2
            pp, pl, k = x * x + y * y + z * z, x * u + y * v + z * w, i * lines + j
            w_S[0, k], w_S[1, k], w_S[2, k], w_S[3, k] = x, y, z, pp
            w_S[4, k], w_S[5, k], w_S[6, k], w_S[7, k] = u, v, w, pl
            w_S[8, k], w_S[9, k], w_S[10, k] = y * w - z * v, z * u - x * w, x * v - y * u
            w_S[11, k], w_S[12, k], w_S[13, k] = pp * u - 2 * pl * x, pp * v - 2 * pl * y, pp * w - 2 * pl * z
    for r in range(14):
        for c in range(9):
            w_C[r, c] = 0.0
        for k in range(9):
            for c in range(9):
                w_C[r, c] += w_S[r, k] * products[k, c]
    # Householder factors of the columns of a and b; what is left of the unit vectors spans their left null space.
    for r in range(14):
        for c in range(6):
            w_Q[r, c] = 1.0 if r == c + 8 else 0.0
    for k in range(8):
        column = k + 1
        norm = 0.0
        for r in range(k, 14):
            norm += w_C[r, column] ** 2
        norm = sqrt(norm)
        alpha = -norm if w_C[k, column] > 0 else norm
        head = w_C[k, column] - alpha
        w_beta[k] = 0.0 if norm == 0.0 else -1.0 / (alpha * head)
        w_beta[8 + k] = alpha
        w_C[k, column] = head
        for c in range(column + 1, 9):
            dot = 0.0
            for r in range(k, 14):
                dot += w_C[r, column] * w_C[r, c]
            dot *= w_beta[k]
            for r in range(k, 14):
                w_C[r, c] -= dot * w_C[r, column]
    for k in range(7, -1, -1):
        for c in range(6):
            dot = 0.0
            for r in range(k, 14):
                dot += w_C[r, k + 1] * w_Q[r, c]
            dot *= w_beta[k]
            for r in range(k, 14):
                w_Q[r, c] -= dot * w_C[r, k + 1]
    for r in range(6):
        for c in range(27):
            w_A[r, c] = 0.0
        constant = 0.0
        for e in range(14):
            x = w_Q[e, r]
            constant += x * w_C[e, 0]
            for c in range(27):
                w_A[r, c] += x * left[e, c]
        for j in range(3):
            w_A[r, 3 * j] -= constant * unit[j]


@compiled
def determinants(A, cosines, sines, count, w_M, w_K, w_v, w_f):
    """The determinant of the twelve equations at nodes of joint c, side by side in lanes.

    Two orthogonal triangulations of six by three, then one of six by six; the sign is that of a fixed number of
    reflections.

    Arguments as the attributes of `Arm` and `Room` in `solution_loops`.
    """
    for l in range(count):
        w_f[l] = 1.0
    for half in range(2):
        for r in range(6):
            for j in range(9):
                # The second half starts with the last block.
                source = j if half == 0 else (6 + j if j < 3 else j - 3)
                x, y, z = A[r, source], A[r, 9 + source], A[r, 18 + source]
                for l in range(count):
                    w_M[r, j, l] = x + y * cosines[l] + z * sines[l]
        for k in range(3):
            _reflected(w_M, k, 6, 9, count, w_v, w_f)
        for r in range(3):
            for j in range(6):
                for l in range(count):
                    w_K[3 * half + r, j, l] = w_M[3 + r, 3 + j, l]
    for k in range(5):
        _reflected(w_K, k, 6, 6, count, w_v, w_f)
    for l in range(count):
        w_f[l] *= w_K[5, 5, l]


@compiled
def _reflected(M, k, rows, columns, count, w_v, w_f):
    """One Householder step in lanes; w_f is multiplied by the diagonal entry."""
    for l in range(count):
        w_v[0, l] = 0.0
    for r in range(k, rows):
        for l in range(count):
            w_v[0, l] += M[r, k, l] * M[r, k, l]
    for l in range(count):
        norm = sqrt(w_v[0, l])
        x = M[k, k, l]
        alpha = -norm if x > 0 else norm
        head = x - alpha
        w_f[l] *= alpha
        M[k, k, l] = head
        w_v[1, l] = 1.0 / (norm * abs(head) + 1e-300)
    for j in range(k + 1, columns):
        for l in range(count):
            w_v[2, l] = 0.0
        for r in range(k, rows):
            for l in range(count):
                w_v[2, l] += M[r, k, l] * M[r, j, l]
        for l in range(count):
            w_v[2, l] *= w_v[1, l]
        for r in range(k, rows):
            for l in range(count):
                M[r, j, l] -= w_v[2, l] * M[r, k, l]


@compiled
def inner_joints(A, theta, turn, w_m, w_s, w_out):
    """Half angle of d and values of e at a zero of the determinant: (c, s, e0, e1, e2) into w_out; the smallest pivot.

    Args:
        turn: angle by which the half angle of d is turned before; at 0 and 90 degrees beyond it nothing can be found.

    Arguments as the attributes of `Arm` and `Room` in `solution_loops`.
    """
    x, y = cos(theta), sin(theta)
    C, S = cos(turn), sin(turn)
    for half in range(2):
        for r in range(6):
            for j in range(3):
                m0 = A[r, j] + x * A[r, 9 + j] + y * A[r, 18 + j]
                m1 = A[r, 3 + j] + x * A[r, 12 + j] + y * A[r, 15 + 6 + j]
                m2 = A[r, 6 + j] + x * A[r, 15 + j] + y * A[r, 24 + j]
                t0 = C * C * m0 + C * S * m1 + S * S * m2
                t1 = 2 * C * S * (m2 - m0) + (C * C - S * S) * m1
                t2 = S * S * m0 - C * S * m1 + C * C * m2
                if half == 0:
                    w_m[r, j], w_m[r, 3 + j], w_m[r, 6 + j] = t0, t1, t2
                else:
                    w_m[r, j], w_m[r, 3 + j], w_m[r, 6 + j] = t2, t0, t1
        for k in range(3):
            _step(w_m, k, 6, 9)
        for r in range(3):
            for j in range(6):
                w_s[3 * half + r, j] = w_m[3 + r, 3 + j]
    # Null vector of the six by six, by Householder steps with exchanged columns.
    order = np.empty(6, np.int64)
    for j in range(6):
        order[j] = j
    for k in range(5):
        best, most = k, -1.0
        for j in range(k, 6):
            norm = 0.0
            for r in range(k, 6):
                norm += w_s[r, j] ** 2
            if norm > most:
                best, most = j, norm
        if best != k:
            order[k], order[best] = order[best], order[k]
            for r in range(6):
                w_s[r, k], w_s[r, best] = w_s[r, best], w_s[r, k]
        _step(w_s, k, 6, 6)
    z = np.empty(6)
    z[5] = 1.0
    for r in range(4, -1, -1):
        total = 0.0
        for j in range(r + 1, 6):
            total += w_s[r, j] * z[j]
        z[r] = -total / w_s[r, r] if w_s[r, r] != 0.0 else 0.0
    null = np.empty(6)
    for j in range(6):
        null[order[j]] = z[j]
    best, most = 0, -1.0
    for j in range(3):
        size = abs(null[j]) + abs(null[3 + j])
        if size > most:
            best, most = j, size
    length = hypot(null[best], null[3 + best])
    c, s = null[best] / length, null[3 + best] / length
    w_out[0], w_out[1] = c * C - s * S, c * S + s * C
    for j in range(3):
        w_out[2 + j] = c * null[j] + s * null[3 + j]
    return abs(w_s[4, 4]) / (abs(w_s[0, 0]) + 1e-300)


@compiled
def _step(M, k, rows, columns):
    """One Householder step; the diagonal entry is left in place of the vector's head."""
    norm = 0.0
    for r in range(k, rows):
        norm += M[r, k] ** 2
    norm = sqrt(norm)
    alpha = -norm if M[k, k] > 0 else norm
    head = M[k, k] - alpha
    beta = 1.0 / (norm * abs(head) + 1e-300)
    M[k, k] = head
    for j in range(k + 1, columns):
        dot = 0.0
        for r in range(k, rows):
            dot += M[r, k] * M[r, j]
        dot *= beta
        for r in range(k, rows):
            M[r, j] -= dot * M[r, k]
    M[k, k] = alpha


@compiled
def outer_joints(C, beta, left, theta, form, last, slide_a, slide_b, w_x, w_out):
    """Values of a and b from the factors of the 14 x 8 system, into w_out[0], w_out[1].

    Args:
        form: (3,) of d, (c^2, c s, s^2).
        last: (3,) of e, (1, cos, sin) or (1, q, q^2).

    Arguments as the attributes of `Arm` and `Room` in `solution_loops`.
    """
    x, y = cos(theta), sin(theta)
    for r in range(14):
        total = 0.0
        for j in range(3):
            for k in range(3):
                m = 3 * j + k
                total += form[j] * last[k] * (left[r, m] + x * left[r, 9 + m] + y * left[r, 18 + m])
        w_x[r] = total
    # C[:, 0] is the constant, not yet reflected.
    for r in range(14):
        w_x[r] -= C[r, 0]
    for k in range(8):
        dot = 0.0
        for r in range(k, 14):
            dot += C[r, k + 1] * w_x[r]
        dot *= beta[k]
        for r in range(k, 14):
            w_x[r] -= dot * C[r, k + 1]
    for k in range(7, -1, -1):
        total = w_x[k]
        for j in range(k + 1, 8):
            total -= C[k, j + 1] * w_x[j]
        w_x[k] = total / beta[8 + k] if beta[8 + k] != 0.0 else 0.0
    # Products (i, j) of a and b without the first: b1 b2, a1, a1 b1, ...
    w_out[0] = w_x[2] if slide_a else atan2(w_x[5], w_x[2])
    w_out[1] = w_x[0] if slide_b else atan2(w_x[1], w_x[0])
