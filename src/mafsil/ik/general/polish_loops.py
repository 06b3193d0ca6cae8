"""Newton's method on the loop of six joints, compiled: candidates become solutions, and solutions find their twins.

Imported only where poses are solved: numba is loaded with it. Arrays named `w_...` are room to work in.
"""

# pyright: reportMissingParameterType=false, reportUnknownVariableType=false
from __future__ import annotations

from math import atan2, cos, pi, sin

import numpy as np

from mafsil.solvers.loops import compiled

MOST = 16
"""Isolated solutions of six turning joints (Primrose, 1986)."""

STEPS = 12
"""Newton steps of a candidate at most."""

SAME = 1e-7
"""Difference of two solutions that count as one [rad | unit of length]."""

FOLD = 0.05
"""Smallest over largest singular value of the Jacobian below which a second solution is looked for close by."""

CLOSED = 1e-10
"""Error of the loop below which a candidate is a solution [rad, unit of length]."""


@compiled
def last_joint(frames, slides, P, q, f, w_T):
    """Value of joint f, the others known: what is left of the loop, seen in its frame.

    Arguments as the attributes of `Arm` and `Room` in `solution_loops`.
    """
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
    """Newton's method on the loop, in place; the largest remaining error [rad, unit of length].

    Arguments as the attributes of `Arm` and `Room` in `solution_loops`.
    """
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
        before, size, total = size, 0.0, trace
        for r in range(6):
            size = max(size, abs(w_J[r, 6]))
            total += abs(w_J[r, 6])
        if trace < 1.0:
            size = max(size, 1.0)
        # The sum tells NaN, which the maximum may pass over.
        if not total < 1e6:
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
    """Solutions beside nearly singular ones, where two meet at a fold, along the direction that moves least.

    Arguments as the attributes of `Arm` and `Room` in `solution_loops`.
    """
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
                found = noted(q, size, slides, found, q_out, size_out)
    return found


@compiled
def noted(q, size, slides, found, q_out, size_out):
    """The number of solutions, this one included if it is new.

    Arguments as the attributes of `Arm` and `Room` in `solution_loops`.
    """
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
def _same(a, b, slides):
    """Whether two solutions are one, full turns apart or not."""
    for k in range(6):
        d = a[k] - b[k]
        if not slides[k]:
            d -= 2 * pi * np.round(d / (2 * pi))
        if abs(d) > SAME:
            return False
    return True
