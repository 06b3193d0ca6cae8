"""The compiled way back: from a zero of the determinant to the other joints.

Imported only where poses are solved: numba is loaded with it. Arrays named `w_...` are room to work in.
"""

# pyright: reportMissingParameterType=false, reportUnknownVariableType=false
from __future__ import annotations

from math import atan2, cos, hypot, sin, sqrt

import numpy as np

from mafsil.solvers.loops import reordered


@reordered
def candidates(joints, slides, twist, turn, pick, rows, zeros, A, C, beta, left, q, rank):
    """Five joints that go with zeros of the determinant, and how well each zero determines them.

    Args:
        joints: (6,) coordinates a, b, c, d, e, f of the road.
        slides: (6,) which joints slide.
        twist: where the half angle of joint d is zero.
        turn: angle by which that half angle is turned before; at 0 and 90 degrees beyond it nothing can be found.
        pick: which null vector, see `_null_vector`.
        rows, zeros: (m,) row of A, C, beta, and value of joint c.
        A, C, beta: as `eliminated` leaves them.
        left: (14, 27) of the road.
        q: (m, 6) coordinates; that of f stays.
        rank: (m,) smallest pivot.
    """
    j_a, j_b, j_c, j_d, j_e = joints[0], joints[1], joints[2], joints[3], joints[4]
    m, s, x = np.empty((6, 9)), np.empty((6, 6)), np.empty(14)
    out, form, last = np.empty(5), np.empty(3), np.empty(3)
    for i in range(len(rows)):
        b, zero = rows[i], zeros[i]
        rank[i] = _inner_joints(A[b], zero, turn, pick, m, s, out)
        q[i, j_c] = zero
        cosine = out[0] if out[0] != 0.0 else 1e-300
        if slides[j_d]:
            q[i, j_d] = out[1] / cosine - twist
            scale = 1.0 / (cosine * cosine)
        else:
            q[i, j_d] = twist + 2 * atan2(out[1], out[0])
            scale = 1.0
        form[0], form[1], form[2] = cosine * cosine * scale, cosine * out[1] * scale, out[1] * out[1] * scale
        last[0] = 1.0
        if slides[j_e]:
            value = out[3] / (out[2] if out[2] != 0.0 else 1e-300)
            last[1], last[2] = value, value * value
            q[i, j_e] = value
        else:
            length = hypot(out[3], out[4]) * (1.0 if out[2] > 0 else -1.0) + 1e-300
            last[1], last[2] = out[3] / length, out[4] / length
            q[i, j_e] = atan2(last[2], last[1])
        _outer_products(C[b], beta[b], left, zero, form, last, x)
        # Products (i, j) of a and b without the first: b1 b2, a1, a1 b1, ...
        q[i, j_a] = x[2] if slides[j_a] else atan2(x[5], x[2])
        q[i, j_b] = x[0] if slides[j_b] else atan2(x[1], x[0])


@reordered
def _inner_joints(A, theta, turn, pick, w_m, w_s, w_out):
    """Half angle of d and values of e at a zero: (c, s, e0, e1, e2) into w_out; the smallest pivot."""
    x, y = cos(theta), sin(theta)
    C, S = cos(turn), sin(turn)
    for half in range(2):
        for r in range(6):
            for j in range(3):
                m0 = A[r, j] + x * A[r, 9 + j] + y * A[r, 18 + j]
                m1 = A[r, 3 + j] + x * A[r, 12 + j] + y * A[r, 21 + j]
                m2 = A[r, 6 + j] + x * A[r, 15 + j] + y * A[r, 24 + j]
                t0 = C * C * m0 + C * S * m1 + S * S * m2
                t1 = 2 * C * S * (m2 - m0) + (C * C - S * S) * m1
                t2 = S * S * m0 - C * S * m1 + C * C * m2
                if half == 0:
                    w_m[r, j], w_m[r, 3 + j], w_m[r, 6 + j] = t0, t1, t2
                else:
                    w_m[r, j], w_m[r, 3 + j], w_m[r, 6 + j] = t2, t0, t1
        for k in range(3):
            _step(w_m, k)
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
        _step(w_s, k)
    null = np.empty(6)
    _null_vector(w_s, order, pick, null)
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


@reordered
def _null_vector(R, order, pick, null):
    """A null vector of a triangular matrix with exchanged columns.

    Args:
        R: (6, 6).
        order: (6,) where each of its columns was.
        pick: 0 for the null vector; 1 and -1 where two zeros are so close that the null space is a plane, for the two
            vectors in it that are products of the half angle of d with values of e, so that 2 x 3 minors vanish.
        null: (6,) the vector.
    """
    z = np.zeros((2, 6))
    z[0, 5], z[1, 4] = 1.0, 1.0
    if pick == 0 and R[4, 4] != 0.0:
        z[0, 4] = -R[4, 5] / R[4, 4]
    for k in range(2):
        for r in range(3, -1, -1):
            total = 0.0
            for j in range(r + 1, 6):
                total += R[r, j] * z[k, j]
            z[k, r] = -total / R[r, r] if R[r, r] != 0.0 else 0.0
    N = np.empty((2, 6))
    for j in range(6):
        N[0, order[j]], N[1, order[j]] = z[0, j], z[1, j]
    first, second = 1.0, 0.0
    if pick != 0:
        most = 0.0
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            a = N[0, i] * N[0, 3 + j] - N[0, j] * N[0, 3 + i]
            b = N[0, i] * N[1, 3 + j] + N[1, i] * N[0, 3 + j] - N[0, j] * N[1, 3 + i] - N[1, j] * N[0, 3 + i]
            c = N[1, i] * N[1, 3 + j] - N[1, j] * N[1, 3 + i]
            if abs(a) + abs(b) + abs(c) > most:
                most = abs(a) + abs(b) + abs(c)
                root = sqrt(max(0.0, b * b - 4 * a * c))
                half = -0.5 * (b + (root if b > 0 else -root))
                first, second = (c, half) if pick > 0 else (half, a)
    for j in range(6):
        null[j] = first * N[0, j] + second * N[1, j]


@reordered
def _step(M, k):
    """One Householder step; the diagonal entry is left in place of the vector's head."""
    rows, columns = M.shape
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


@reordered
def _outer_products(C, beta, left, theta, form, last, w_x):
    """Products of a and b, from the factors of the 14 x 8 system.

    Args:
        form: (3,) of d, (c^2, c s, s^2).
        last: (3,) of e, (1, cos, sin) or (1, q, q^2).
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
