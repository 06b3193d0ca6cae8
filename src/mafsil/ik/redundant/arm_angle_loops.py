"""The compiled loop of arms with a spherical shoulder and a spherical wrist: eight postures per arm angle."""

# pyright: reportMissingParameterType=false, reportUnknownVariableType=false
from __future__ import annotations

from math import asin, atan2, cos, hypot, pi, sin, sqrt

import numpy as np

from mafsil.solvers.loops import compiled

BRANCHES = 8
"""Two elbows, two shoulders, two wrists."""


@compiled
def postures(P, angles, axes, places, upright, frames, turns, q_out):
    """All postures of poses at arm angles; NaN where the wrist cannot be reached.

    Args:
        P: (b, 4, 4) displacements of the chain.
        angles: (b, m) arm angles [rad].
        axes: (7, 3) unit directions at q = 0.
        places: (3, 3) shoulder, elbow (a point of axis 4) and wrist at q = 0.
        upright: (2, 3) directions the arm angle is measured from; the second where the first points to the wrist.
        frames: (2, 3, 3) columns x, y, z of shoulder and wrist: z of its first axis, y of its second.
        turns: (2,) angle from the first to the third axis about the second.
        q_out: (b, m, 8, 7).
    """
    R4, Rs, R0, Q = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    triple = np.empty((2, 3))
    target, seen, e = np.empty(3), np.empty(3), np.empty(3)
    have, want = np.empty((3, 3)), np.empty((3, 3))
    w4 = axes[3]
    for b in range(len(P)):
        for k in range(3):
            target[k] = P[b, k, 3] - places[0, k]
            for j in range(3):
                target[k] += P[b, k, j] * places[2, j]
        distance = sqrt(target[0] ** 2 + target[1] ** 2 + target[2] ** 2)
        # |Rot(w4, q4) u + v| = distance: u from axis 4 to the wrist, v from the shoulder to axis 4.
        uu = vv = along_u = along_v = 0.0
        for k in range(3):
            along_u += w4[k] * (places[2, k] - places[1, k])
            along_v += w4[k] * (places[1, k] - places[0, k])
        x = y = 0.0
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            u = places[2, k] - places[1, k] - along_u * w4[k]
            v = places[1, k] - places[0, k] - along_v * w4[k]
            side = w4[i] * (places[2, j] - places[1, j]) - w4[j] * (places[2, i] - places[1, i])
            uu += u * u
            vv += v * v
            x += u * v
            y += side * v
        height = along_u + along_v
        bend = distance * distance - height * height - uu - vv
        cosine = bend / (2 * hypot(x, y))
        if not abs(cosine) <= 1.0 + 1e-12:
            q_out[b] = np.nan
            continue
        opening = atan2(sqrt(max(0.0, 1.0 - cosine * cosine)), cosine)
        centre = atan2(y, x)
        length = max(distance, 1e-300)
        _across(upright[0], target, length, want)
        if hypot(hypot(want[1, 0], want[1, 1]), want[1, 2]) < 1e-9:
            _across(upright[1], target, length, want)
        _completed(want)
        for elbow in range(2):
            q4 = centre + opening if elbow == 0 else centre - opening
            _turn(w4, q4, R4)
            for k in range(3):
                seen[k] = places[1, k] - places[0, k]
                e[k] = places[1, k] - places[0, k]
                for j in range(3):
                    seen[k] += R4[k, j] * (places[2, j] - places[1, j])
            _across(e, seen, length, have)
            if hypot(hypot(have[1, 0], have[1, 1]), have[1, 2]) < 1e-12:
                # Straight: any direction across the line will do.
                _across(w4, seen, length, have)
            _completed(have)
            for m in range(angles.shape[1]):
                c, s = cos(angles[b, m]), sin(angles[b, m])
                # Rs takes (direction, side, normal) as it is to where it has to be, the side turned by the arm angle.
                for k in range(3):
                    side, normal = c * want[1, k] + s * want[2, k], c * want[2, k] - s * want[1, k]
                    for j in range(3):
                        Rs[k, j] = want[0, k] * have[0, j] + side * have[1, j] + normal * have[2, j]
                _euler(Rs, frames[0], turns[0], Q, triple)
                for branch in range(4):
                    row = q_out[b, m, 4 * elbow + branch]
                    row[:3] = triple[branch // 2]
                    row[3] = _wrapped(q4)
                _product(Rs, R4, R0)
                _remaining(R0, P[b], Rs)
                _euler(Rs, frames[1], turns[1], Q, triple)
                for branch in range(4):
                    q_out[b, m, 4 * elbow + branch, 4:] = triple[branch % 2]


@compiled
def checked(q, T, X, values, held, turning, middle, lower, upper, tolerance, residual, within):
    """By how much postures miss their poses, and which are within the limits; angles are wound, in place.

    Args:
        q: (k m, branches, 7) postures, m values of the parameter for each pose.
        T: (k m, branches, 4, 4) their poses.
        X: (k, 4, 4) wanted poses.
        values: (k m,) values of the parameter.
        held: the joint that has them, and is not wound; -1 if none.
        turning: (7,) which coordinates are angles.
        middle, lower, upper: (7,) of the limits.
        tolerance: residual of a posture.
        residual: (k m, branches) distance or angle, the larger; NaN where there is no posture.
        within: (k m, branches) whether it is one, within its limits.
    """
    each = len(q) // max(1, len(X))
    for i in range(len(q)):
        P = X[i // each]
        for j in range(q.shape[1]):
            distance = chord = 0.0
            for r in range(3):
                distance += (T[i, j, r, 3] - P[r, 3]) ** 2
                for c in range(3):
                    chord += (T[i, j, r, c] - P[r, c]) ** 2
            size = max(sqrt(distance), 2 * asin(min(1.0, sqrt(chord / 8)))) if distance + chord >= 0.0 else np.nan
            good = size <= tolerance
            for k in range(7):
                x = q[i, j, k]
                if turning[k]:
                    x -= 2 * pi * np.floor((x - middle[k]) / (2 * pi) + 0.5)
                    if lower[k] > x:
                        x += 2 * pi * np.ceil((lower[k] - x) / (2 * pi) - 1e-12)
                    elif x > upper[k]:
                        x -= 2 * pi * np.ceil((x - upper[k]) / (2 * pi) - 1e-12)
                if k == held and x == x:
                    x = values[i]
                q[i, j, k] = x
                good = good and lower[k] - 1e-12 <= x <= upper[k] + 1e-12
            residual[i, j], within[i, j] = size, good


@compiled
def _product(A, B, out):
    """A B."""
    for k in range(3):
        for j in range(3):
            out[k, j] = A[k, 0] * B[0, j] + A[k, 1] * B[1, j] + A[k, 2] * B[2, j]


@compiled
def _remaining(A, P, out):
    """A' P: the rotation that is left for the wrist."""
    for k in range(3):
        for j in range(3):
            out[k, j] = A[0, k] * P[0, j] + A[1, k] * P[1, j] + A[2, k] * P[2, j]


@compiled
def _across(v, w, length, out):
    """The unit vector of w, and what v has across it, normalised unless it is tiny."""
    dot = 0.0
    for k in range(3):
        out[0, k] = w[k] / length
        dot += v[k] * out[0, k]
    for k in range(3):
        out[1, k] = v[k] - dot * out[0, k]


@compiled
def _completed(out):
    """Right-handed: the second row normalised, the third normal to both."""
    norm = sqrt(out[1, 0] ** 2 + out[1, 1] ** 2 + out[1, 2] ** 2)
    for k in range(3):
        out[1, k] /= norm
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        out[2, k] = out[0, i] * out[1, j] - out[0, j] * out[1, i]


@compiled
def _turn(w, angle, R):
    """Rotation about a unit vector."""
    c, s = cos(angle), sin(angle)
    for k in range(3):
        for j in range(3):
            R[k, j] = (1 - c) * w[k] * w[j]
        R[k, k] += c
    R[0, 1] -= s * w[2]
    R[1, 0] += s * w[2]
    R[0, 2] += s * w[1]
    R[2, 0] -= s * w[1]
    R[1, 2] -= s * w[0]
    R[2, 1] += s * w[0]


@compiled
def _euler(R, frame, turn, Q, out):
    """Both triples of angles about three axes, the second normal to the others, whose product is R.

    frame' R frame Rot(y, turn) = Rot(z, a) Rot(y, b + turn) Rot(z, c).
    """
    for k in range(3):
        for j in range(3):
            total = 0.0
            for i in range(3):
                row = R[i, 0] * frame[0, j] + R[i, 1] * frame[1, j] + R[i, 2] * frame[2, j]
                total += frame[i, k] * row
            Q[k, j] = total
    c, s = cos(turn), sin(turn)
    for k in range(3):
        x, z = Q[k, 0], Q[k, 2]
        Q[k, 0], Q[k, 2] = c * x - s * z, s * x + c * z
    size = hypot(Q[0, 2], Q[1, 2])
    if size < 1e-12:
        b = 0.0 if Q[2, 2] > 0 else pi
        a, d = 0.0, atan2(Q[1, 0], Q[1, 1])
        for i in range(2):
            out[i, 0], out[i, 1], out[i, 2] = a, _wrapped(b - turn), d
        return
    a, b, d = atan2(Q[1, 2], Q[0, 2]), atan2(size, Q[2, 2]), atan2(Q[2, 1], -Q[2, 0])
    out[0, 0], out[0, 1], out[0, 2] = a, _wrapped(b - turn), d
    out[1, 0], out[1, 1] = (a - pi if a > 0 else a + pi), _wrapped(-b - turn)
    out[1, 2] = d - pi if d > 0 else d + pi


@compiled
def _wrapped(x):
    return x - 2 * pi * np.floor(x / (2 * pi) + 0.5)
