"""The compiled loop: all solutions of six joints for a batch of poses, with a certificate for each.

Imported only where poses are solved: numba is loaded with it. Arrays named `w_...` are room to work in.
"""

# pyright: reportMissingParameterType=false, reportUnknownVariableType=false
from __future__ import annotations

from math import atan2, cos, hypot, pi, sin, sqrt

import numpy as np

from mafsil.ik.general.circle_loops import CELLS, ORDER, harmonics, zeros_on_circle
from mafsil.solvers.loops import compiled

MOST = 16
"""Isolated solutions of six turning joints (Primrose, 1986)."""

CANDIDATES = 48
"""Zeros of one determinant that are looked at."""

STEPS = 12
"""Newton steps of a candidate at most."""

SAME = 1e-7
"""Difference of two solutions that count as one [rad | unit of length]."""

FOLD = 0.05
"""Smallest over largest singular value of the Jacobian below which a second solution is looked for close by."""

ROUNDING = 2.0**-52

DISTURBANCE = 1e-10
"""Of the equations, relative, by which the effect of rounding is measured."""

CLOSED = 1e-10
"""Error of the loop below which a candidate is a solution [rad, unit of length]."""


@compiled
def eliminated(P, before, lines, after, products, left, unit, w_C, w_Q, w_A, w_beta):
    """Coefficients (6, 3, 9) of six equations in c, d, e; the factors of the 14 x 8 system of a and b stay in w_C."""
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


@compiled
def last_joint(frames, slides, P, q, f, w_T):
    """Value of joint f, the others known: what is left of the loop, seen in its frame."""
    T = w_T
    # Before: frames[0] Z_0 ... frames[f]; after: frames[f + 1] Z_{f + 1} ... frames[6].
    _chained(frames, slides, q, 0, f, T[0])
    _chained(frames, slides, q, f + 1, 6, T[1])
    # x axis of the moved frame in the frame before it: before^-1 P after^-1 e_x.
    a0, a1, a2 = T[1, 0, 0], T[1, 0, 1], T[1, 0, 2]
    m0 = P[0, 0] * a0 + P[0, 1] * a1 + P[0, 2] * a2
    m1 = P[1, 0] * a0 + P[1, 1] * a1 + P[1, 2] * a2
    m2 = P[2, 0] * a0 + P[2, 1] * a1 + P[2, 2] * a2
    sine = T[0, 0, 1] * m0 + T[0, 1, 1] * m1 + T[0, 2, 1] * m2
    cosine = T[0, 0, 0] * m0 + T[0, 1, 0] * m1 + T[0, 2, 0] * m2
    return atan2(sine, cosine)


@compiled
def _chained(frames, slides, q, begin, end, out):
    """frames[begin] Z_begin frames[begin + 1] ... Z_{end - 1} frames[end], (3, 4)."""
    for r in range(3):
        for c in range(4):
            out[r, c] = frames[begin, r, c]
    for k in range(begin, end):
        _moved(out, slides[k], q[k])
        _followed(out, frames[k + 1])


@compiled
def _moved(T, slides, q):
    if slides:
        for r in range(3):
            T[r, 3] += q * T[r, 2]
    else:
        c, s = cos(q), sin(q)
        for r in range(3):
            x, y = T[r, 0], T[r, 1]
            T[r, 0], T[r, 1] = c * x + s * y, c * y - s * x


@compiled
def _followed(T, F):
    for r in range(3):
        x, y, z = T[r, 0], T[r, 1], T[r, 2]
        T[r, 0] = x * F[0, 0] + y * F[1, 0] + z * F[2, 0]
        T[r, 1] = x * F[0, 1] + y * F[1, 1] + z * F[2, 1]
        T[r, 2] = x * F[0, 2] + y * F[1, 2] + z * F[2, 2]
        T[r, 3] += x * F[0, 3] + y * F[1, 3] + z * F[2, 3]


@compiled
def polished(frames, slides, P, q, steps, w_J, w_T):
    """Newton's method on the loop, in place; the largest remaining error [rad, unit of length]."""
    T = w_T[0]
    size = 1e300
    for _ in range(steps):
        for r in range(3):
            for c in range(4):
                T[r, c] = frames[0, r, c]
        for k in range(6):
            for r in range(3):
                w_J[r, k] = T[r, 2]
                w_J[3 + r, k] = T[r, 3]
            _moved(T, slides[k], q[k])
            _followed(T, frames[k + 1])
        # Error: half the axis of P T^-1, which is its sine for small angles, and the displacement.
        e0 = e1 = e2 = trace = 0.0
        for c in range(3):
            e0 += T[1, c] * P[2, c] - T[2, c] * P[1, c]
            e1 += T[2, c] * P[0, c] - T[0, c] * P[2, c]
            e2 += T[0, c] * P[1, c] - T[1, c] * P[0, c]
            trace += T[0, c] * P[0, c] + T[1, c] * P[1, c] + T[2, c] * P[2, c]
        w_J[0, 6], w_J[1, 6], w_J[2, 6] = 0.5 * e0, 0.5 * e1, 0.5 * e2
        for r in range(3):
            w_J[3 + r, 6] = P[r, 3] - T[r, 3]
        before = size
        size = 0.0
        for r in range(6):
            size = max(size, abs(w_J[r, 6]))
        if trace < 1.0:
            size = max(size, 1.0)
        if not size < 1e6:
            return 1e300
        if size < 1e-14 or (size < CLOSED and size > 0.25 * before):
            return size
        _jacobian(slides, T, w_J)
        _solved(w_J)
        longest = 0.0
        for k in range(6):
            longest = max(longest, abs(w_J[k, 6]))
        shrink = min(1.0, 0.6 / longest) if longest > 0 else 1.0
        for k in range(6):
            q[k] += shrink * w_J[k, 6]
    return size


@compiled
def _jacobian(slides, T, w_J):
    """Columns (axis, velocity of the tip) from (axis, a point of it)."""
    for k in range(6):
        z0, z1, z2 = w_J[0, k], w_J[1, k], w_J[2, k]
        if slides[k]:
            w_J[0, k], w_J[1, k], w_J[2, k] = 0.0, 0.0, 0.0
            w_J[3, k], w_J[4, k], w_J[5, k] = z0, z1, z2
        else:
            d0, d1, d2 = T[0, 3] - w_J[3, k], T[1, 3] - w_J[4, k], T[2, 3] - w_J[5, k]
            w_J[3, k], w_J[4, k], w_J[5, k] = z1 * d2 - z2 * d1, z2 * d0 - z0 * d2, z0 * d1 - z1 * d0


@compiled
def twins(frames, slides, P, found, q_out, size_out, w_J, w_T):
    """Solutions beside nearly singular ones, where two meet at a fold: searched along the direction that moves least."""
    q = np.empty(6)
    for k in range(found):
        q[:] = q_out[k]
        J = np.empty((6, 6))
        _chained(frames, slides, q, 0, 6, w_T[0])
        for j in range(6):
            _chained(frames, slides, q, 0, j, w_T[1])
            for r in range(3):
                w_J[r, j], w_J[3 + r, j] = w_T[1, r, 2], w_T[1, r, 3]
        _jacobian(slides, w_T[0], w_J)
        J[:] = w_J[:, :6]
        _, values, Vt = np.linalg.svd(J)
        if values[5] > FOLD * values[0]:
            continue
        for a in range(12):
            way = (0.001, 0.01, 0.03, 0.1, 0.3, 0.6)[a % 6] * (1.0 if a < 6 else -1.0)
            q[:] = q_out[k] + way * Vt[5]
            size = polished(frames, slides, P, q, STEPS, w_J, w_T)
            if size < CLOSED and found < MOST:
                found = _noted(q, size, slides, found, q_out, size_out)
    return found


@compiled
def _noted(q, size, slides, found, q_out, size_out):
    """The number of solutions, this one included if it is new."""
    for k in range(6):
        if not slides[k]:
            q[k] -= 2 * pi * np.round(q[k] / (2 * pi))
    for k in range(found):
        if _same(q, q_out[k], slides):
            return found
    if found < MOST:
        q_out[found] = q
        size_out[found] = size
        found += 1
    return found


@compiled
def _solved(M):
    """Six linear equations in place by exchanged rows; the solution in the last column."""
    for k in range(6):
        best, most = k, abs(M[k, k])
        for r in range(k + 1, 6):
            if abs(M[r, k]) > most:
                best, most = r, abs(M[r, k])
        if best != k:
            for c in range(k, 7):
                M[k, c], M[best, c] = M[best, c], M[k, c]
        inverse = 1.0 / (M[k, k] if abs(M[k, k]) > 1e-13 else 1e-13)
        for r in range(k + 1, 6):
            factor = M[r, k] * inverse
            for c in range(k + 1, 7):
                M[r, c] -= factor * M[k, c]
        M[k, 6] *= inverse
        for c in range(k + 1, 6):
            M[k, c] *= inverse
    for k in range(5, -1, -1):
        total = M[k, 6]
        for c in range(k + 1, 6):
            total -= M[k, c] * M[c, 6]
        M[k, 6] = total


@compiled
def fitted_circle(f, degree, angles):
    """(centre, squeeze) of the projective image of the circle on which samples of a polynomial are most alike.

    On the image f(t) is multiplied by r^(2 degree), r^2 = |(m c, s / m)|^2 with the half angle (c, s) of the image
    and the squeeze m: the first harmonic of log r^(2 degree) is made opposite to that of log |f|.
    """
    most = x = y = 0.0
    for l in range(len(angles)):
        most = max(most, abs(f[l]))
    for l in range(len(angles)):
        level = np.log(abs(f[l]) / most + 1e-16)
        x += level * cos(angles[l])
        y += level * sin(angles[l])
    depth = min(0.85, hypot(x, y) / (len(angles) * degree))
    return atan2(-y, -x), sqrt((1 + depth) / (1 - depth))


@compiled
def turned_circle(centre, squeeze, degree, angles, w_cosines, w_sines, w_weights):
    """Nodes of an image of the circle, and their weights."""
    for l in range(len(angles)):
        c, s = squeeze * cos(0.5 * angles[l]), sin(0.5 * angles[l]) / squeeze
        theta = centre + 2 * atan2(s, c)
        w_cosines[l], w_sines[l] = cos(theta), sin(theta)
        w_weights[l] = (c * c + s * s) ** degree


@compiled
def _coefficients(f, fourier, degree, out):
    """Coefficients (2, degree + 1) of cos and sin; the largest of those that must be zero."""
    dust = 0.0
    for i in range(len(f)):
        total = 0.0
        for l in range(len(f)):
            total += fourier[i, l] * f[l]
        if i <= 2 * degree:
            out[i & 1, (i + 1) >> 1] = total
        else:
            dust = max(dust, abs(total))
    out[1, 0] = 0.0
    return dust


@compiled
def _same(a, b, slides):
    for k in range(6):
        d = a[k] - b[k]
        if not slides[k]:
            d -= 2 * pi * np.round(d / (2 * pi))
        if abs(d) > SAME:
            return False
    return True


@compiled
def solved(
    P,
    Q,
    order,
    joints,
    backwards,
    before,
    lines,
    after,
    products,
    left,
    unit,
    frames,
    slides,
    fourier,
    degree,
    twist,
    turns,
    q_out,
    size_out,
    proof_out,
    road_out,
):
    """All solutions of a batch of poses.

    Args:
        P, Q: (b, 3, 4) displacements of the loop and their inverses, in units of the arm.
        order: roads to take one after the other until one proves that nothing is missing.
        joints, backwards, before, lines, after, products, left, unit: constants of the roads, one row each.
        frames: (7, 3, 4) the chain as frames between joints that move about or along z.
        slides: (6,) which joints slide.
        fourier: (nodes, nodes) from samples of the determinant to its coefficients, and to those that must be zero.
        degree: of the trigonometric polynomial.
        twist: where the half angle of joint d is zero.
        turns: (t,) turns of that half angle that are tried.
        q_out, size_out: (b, 16, 6) and (b, 16) solutions and their errors.
        proof_out, road_out: (b,) 1 if the list is proven complete; how many roads were taken.
    """
    nodes = fourier.shape[1]
    angles = 2 * pi / nodes * np.arange(nodes)
    cosines, sines = np.cos(angles), np.sin(angles)
    w_cosines, w_sines, w_weights = np.empty(nodes), np.empty(nodes), np.empty(nodes)
    centre = squeeze = 0.0
    w_B, w_g, w_changes = np.empty((6, 27)), np.empty(nodes), np.empty((2, degree + 1))
    disturbance = np.cos(np.arange(162.0) ** 2).reshape(6, 27)
    w_C, w_Q, w_A, w_beta = np.empty((14, 9)), np.empty((14, 15)), np.empty((6, 27)), np.empty(16)
    w_M, w_K = np.empty((6, 9, nodes)), np.empty((6, 6, nodes))
    w_v, w_f = np.empty((3, nodes)), np.empty(nodes)
    w_m, w_s, w_out, w_x = np.empty((6, 9)), np.empty((6, 6)), np.empty(5), np.empty(14)
    w_J, w_T, w_form, w_last, w_ab = np.empty((6, 7)), np.empty((2, 3, 4)), np.empty(3), np.empty(3), np.empty(2)
    coefficients, zeros = np.empty((2, degree + 1)), np.empty(CANDIDATES)
    w_t, w_stack = np.empty((ORDER + 2, CELLS)), np.empty((64, ORDER + 3))
    waves, factors = harmonics(degree)
    q = np.empty(6)
    for b in range(len(P)):
        found = 0
        proof_out[b] = 0
        for attempt in range(2 * len(order)):
            road, again = order[attempt // 2], attempt % 2 == 1
            X = Q[b] if backwards[road] else P[b]
            if again:
                # The samples differ by orders of magnitude: once more on an image of the circle that evens them out.
                centre, squeeze = fitted_circle(w_f, degree, angles)
                turned_circle(centre, squeeze, degree, angles, w_cosines, w_sines, w_weights)
                determinants(w_A, w_cosines, w_sines, nodes, w_M, w_K, w_v, w_f)
                for l in range(nodes):
                    w_f[l] *= w_weights[l]
            else:
                road_out[b] = 1 + attempt // 2
                eliminated(
                    X,
                    before[road],
                    lines[road],
                    after[road],
                    products[road],
                    left[road],
                    unit[road],
                    w_C,
                    w_Q,
                    w_A,
                    w_beta,
                )
                determinants(w_A, cosines, sines, nodes, w_M, w_K, w_v, w_f)
            dust = _coefficients(w_f, fourier, degree, coefficients)
            if again:
                # What rounding in the equations does to these samples, measured by a larger disturbance.
                for r in range(6):
                    most = 0.0
                    for j in range(27):
                        most = max(most, abs(w_A[r, j]))
                    for j in range(27):
                        w_B[r, j] = w_A[r, j] + DISTURBANCE * most * disturbance[r, j]
                for l in range(nodes):
                    w_g[l] = w_f[l]
                determinants(w_B, w_cosines, w_sines, nodes, w_M, w_K, w_v, w_f)
                for l in range(nodes):
                    w_f[l] = w_f[l] * w_weights[l] - w_g[l]
                _coefficients(w_f, fourier, degree, w_changes)
                small, large, total = 1e300, 0.0, 0.0
                for k in range(8):
                    small, large = min(small, abs(w_beta[8 + k])), max(large, abs(w_beta[8 + k]))
                for k in range(degree + 1):
                    total += abs(w_changes[0, k]) + abs(w_changes[1, k])
                dust += 0.5 * ROUNDING / DISTURBANCE * (1 + large / (small + 1e-300)) * total
            number, certain = zeros_on_circle(coefficients, degree, dust, waves, factors, zeros, w_t, w_stack)
            if again:
                for z in range(number):
                    zeros[z] = centre + 2 * atan2(sin(0.5 * zeros[z]) / squeeze, squeeze * cos(0.5 * zeros[z]))
            elif not certain and number > 0:
                continue
            j = joints[road]
            proven = certain
            for z in range(number):
                hit = False
                for t in range(len(turns)):
                    rank = inner_joints(w_A, zeros[z], turns[t], w_m, w_s, w_out)
                    c, s = w_out[0], w_out[1]
                    q[j[2]] = zeros[z]
                    if slides[j[3]]:
                        q[j[3]] = s / (c if c != 0.0 else 1e-300) - twist
                        scale = 1.0 / (c * c if c != 0.0 else 1e-300)
                        w_form[0], w_form[1], w_form[2] = 1.0, c * s * scale, s * s * scale
                    else:
                        q[j[3]] = twist + 2 * atan2(s, c)
                        w_form[0], w_form[1], w_form[2] = c * c, c * s, s * s
                    if slides[j[4]]:
                        value = w_out[3] / (w_out[2] if w_out[2] != 0.0 else 1e-300)
                        w_last[0], w_last[1], w_last[2] = 1.0, value, value * value
                        q[j[4]] = value
                    else:
                        sign = 1.0 if w_out[2] > 0 else -1.0
                        length = hypot(w_out[3], w_out[4]) * sign + 1e-300
                        w_last[0], w_last[1], w_last[2] = 1.0, w_out[3] / length, w_out[4] / length
                        q[j[4]] = atan2(w_last[2], w_last[1])
                    outer_joints(
                        w_C, w_beta, left[road], zeros[z], w_form, w_last, slides[j[0]], slides[j[1]], w_x, w_ab
                    )
                    q[j[0]], q[j[1]] = w_ab[0], w_ab[1]
                    q[j[5]] = last_joint(frames, slides, P[b], q, j[5], w_T)
                    size = polished(frames, slides, P[b], q, STEPS, w_J, w_T)
                    if size < CLOSED:
                        # The solution must be that of this zero, else the zero is not explained.
                        away = q[j[2]] - zeros[z]
                        away -= 2 * pi * np.round(away / (2 * pi))
                        hit = abs(away) < 1e-3
                        found = _noted(q, size, slides, found, q_out[b], size_out[b])
                    if hit and rank > 1e-9:
                        break
                if not hit:
                    proven = False
            if proven and found == number:
                proof_out[b] = 1
                break
        if proof_out[b] == 0:
            twins(frames, slides, P[b], found, q_out[b], size_out[b], w_J, w_T)
