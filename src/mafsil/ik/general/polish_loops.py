"""Newton's method on the loop of six joints, compiled: candidates become solutions, each noted once.

Imported only where poses are solved: numba is loaded with it.
"""

# pyright: reportMissingParameterType=false, reportUnknownVariableType=false
from __future__ import annotations

from math import atan2, cos, pi, sin

import numpy as np

from mafsil.solvers.loops import reordered

STEPS = 40
"""Newton steps of a candidate at most: near a fold each halves the distance only."""

SAME = 1e-6
"""Difference of two solutions that count as one [rad | unit of length]."""

CLOSED = 1e-10
"""Error of the loop below which a candidate is a solution [rad, unit of length]."""


@reordered
def polished(frames, slides, P, rows, last, q, size):
    """Newton's method on candidates, in place; the largest errors that remain [rad, unit of length].

    Args:
        frames: (7, 3, 4) constants F_k of the loop F_0 Z_0 F_1 Z_1 ... Z_5 F_6.
        slides: (6,) which joints slide.
        P: (k, 4, 4) displacements of the loop.
        rows: (m,) which of them each candidate belongs to.
        last: a turning joint whose value is still to be found from the others; -1 if none.
        q: (m, 6) candidates.
        size: (m,) the errors.
    """
    T, ends, J = np.empty((3, 4)), np.empty((2, 3, 4)), np.empty((6, 7))
    for i in range(len(rows)):
        X = P[rows[i]]
        if last >= 0:
            q[i, last] = _remaining(frames, slides, X, q[i], last, ends)
        error = 1e300
        for step in range(STEPS):
            for r in range(3):
                for c in range(4):
                    T[r, c] = frames[0, r, c]
            for k in range(6):
                for r in range(3):
                    J[r, k], J[3 + r, k] = T[r, 2], T[r, 3]
                _advanced(T, slides[k], q[i, k], frames[k + 1])
            before, error = error, _missing(T, X, J)
            done = error < 1e-14 or step == STEPS - 1 or (error < CLOSED and error > 0.5 * before)
            if done or error > 1e6:
                break
            _columns(slides, T, J)
            _solved(J)
            longest = 0.0
            for k in range(6):
                longest = max(longest, abs(J[k, 6]))
            shrink = min(1.0, 0.6 / longest) if longest > 0 else 1.0
            for k in range(6):
                q[i, k] += shrink * J[k, 6]
        size[i] = error


@reordered
def _missing(T, X, J):
    """The largest error of a loop, 1e300 if it is none; its components into the last column.

    Half the axis of X T^-1, which is its sine for small angles, and the displacement.
    """
    size = trace = total = 0.0
    for r in range(3):
        u, v = (r + 1) % 3, (r + 2) % 3
        turn = 0.0
        for c in range(3):
            turn += T[u, c] * X[v, c] - T[v, c] * X[u, c]
            trace += T[r, c] * X[r, c]
        J[r, 6], J[3 + r, 6] = 0.5 * turn, X[r, 3] - T[r, 3]
        size = max(size, abs(J[r, 6]), abs(J[3 + r, 6]))
        total += abs(J[r, 6]) + abs(J[3 + r, 6])
    # The sum tells NaN, which the maximum may pass over.
    if not total + abs(trace) < 1e6:
        return 1e300
    return max(size, 1.0) if trace < 1.0 else size


@reordered
def _remaining(frames, slides, P, q, f, T):
    """Value of joint f, the others known: what is left of the loop, seen in its frame."""
    # Before: F_0 Z_0 ... F_f; after: F_{f + 1} Z_{f + 1} ... F_6.
    for part in range(2):
        begin = 0 if part == 0 else f + 1
        for r in range(3):
            for c in range(4):
                T[part, r, c] = frames[begin, r, c]
        for k in range(begin, f if part == 0 else 6):
            _advanced(T[part], slides[k], q[k], frames[k + 1])
    # x axis of the moved frame in the frame before it: before^-1 P after^-1 e_x.
    sine = cosine = 0.0
    for r in range(3):
        m = P[r, 0] * T[1, 0, 0] + P[r, 1] * T[1, 0, 1] + P[r, 2] * T[1, 0, 2]
        sine += T[0, r, 1] * m
        cosine += T[0, r, 0] * m
    return atan2(sine, cosine)


@reordered
def _advanced(T, slides, q, F):
    """T Z F in place of T, all (3, 4): the joint moves about or along z."""
    c, s, way = (1.0, 0.0, q) if slides else (cos(q), sin(q), 0.0)
    for r in range(3):
        x, y, z = c * T[r, 0] + s * T[r, 1], c * T[r, 1] - s * T[r, 0], T[r, 2]
        for j in range(3):
            T[r, j] = x * F[0, j] + y * F[1, j] + z * F[2, j]
        T[r, 3] += x * F[0, 3] + y * F[1, 3] + z * (F[2, 3] + way)


@reordered
def _columns(slides, T, J):
    """Columns (axis, velocity of the tip) from (axis, a point of it)."""
    for k in range(6):
        z0, z1, z2 = J[0, k], J[1, k], J[2, k]
        if slides[k]:
            J[0, k], J[1, k], J[2, k] = 0.0, 0.0, 0.0
            J[3, k], J[4, k], J[5, k] = z0, z1, z2
        else:
            d0, d1, d2 = T[0, 3] - J[3, k], T[1, 3] - J[4, k], T[2, 3] - J[5, k]
            J[3, k], J[4, k], J[5, k] = z1 * d2 - z2 * d1, z2 * d0 - z0 * d2, z0 * d1 - z1 * d0


@reordered
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


@reordered
def noted(rows, q, size, slides, found, q_out, size_out):
    """Closed candidates that are new are written down, their angles in [-pi, pi].

    Args:
        rows: (m,) place of each in the lists.
        q, size: (m, 6) candidates, and (m,) their errors.
        slides: (6,) which joints slide.
        found: (k,) lengths of the lists.
        q_out, size_out: (k, most, 6) and (k, most) the lists.
    """
    for i in range(len(rows)):
        if not size[i] < CLOSED:
            continue
        b = rows[i]
        for k in range(6):
            if not slides[k]:
                q[i, k] -= 2 * pi * np.floor(q[i, k] / (2 * pi) + 0.5)
        new = found[b] < q_out.shape[1]
        for j in range(found[b]):
            away = 0.0
            for k in range(6):
                d = q[i, k] - q_out[b, j, k]
                if not slides[k]:
                    d -= 2 * pi * np.floor(d / (2 * pi) + 0.5)
                away = max(away, abs(d))
            new = new and away > SAME
        if new:
            for k in range(6):
                q_out[b, found[b], k] = q[i, k]
            size_out[b, found[b]] = size[i]
            found[b] += 1
