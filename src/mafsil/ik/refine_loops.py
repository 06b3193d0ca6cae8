"""Newton's method on rows that are nearly solutions, compiled: each for itself, by the arm's kernels."""

from __future__ import annotations

from math import atan2, pi, sqrt

import numpy as np

from mafsil.arrays import Booleans, Floats
from mafsil.floating_point import EPS, LEAST_DIVISOR
from mafsil.ik.tolerances import EXACT_POSE, NO_BETTER, SINGULAR
from mafsil.kernels.loops.lanes import address, call_kernel
from mafsil.kernels.loops.loop import compiled

LONGEST = 0.5
"""Step of a joint [rad | m]."""
SWEEPS = 40
"""Most sweeps of rotations; six are usual."""
HALF_TURN = 1e-3
"""Sine of an angle near a half turn below which the axis is read from the symmetric part of a rotation."""


@compiled
def refine(
    poses: int, jacobians: int, q: Floats, T_sd: Floats, mask: Floats, moving: Booleans, steps: int, size: Floats
) -> None:
    """Newton steps of least norm that never make the error larger.

    1. The error of the row; one that is exact stands.
    2. The step J+ e, as long as `LONGEST` at most; joints that are locked have no column in J.
    3. It is taken if the error becomes smaller; else the row has converged.

    Args:
        poses, jacobians: addresses of the kernels of the tip's pose and of its body Jacobian.
        q: (k, n) rows, changed.
        T_sd: (k, 16) requested poses.
        mask: (6,) one for components of the error that count, else zero.
        moving: (k, n) which joints may move.
        steps: most steps.
        size: (k,) residuals, out.
    """
    n = q.shape[1]
    T, flat, V = np.empty(16), np.empty(6 * n), np.empty((n, n))
    J: Floats = flat.reshape(6, n)
    error, trial_error, step, trial = np.empty(6), np.empty(6), np.empty(n), np.empty(n)
    for row in range(len(q)):
        # 1.
        _evaluate(poses, q[row], T, 4)
        size[row] = pose_error(T, T_sd[row], mask, error)
        for _ in range(steps):
            if not size[row] > NO_BETTER:
                break
            # 2.
            _evaluate(jacobians, q[row], flat, n)
            for i in range(n):
                for r in range(6):
                    J[r, i] *= mask[r] if moving[row, i] else 0.0
            least_norm(J, error, V, step)
            longest = LEAST_DIVISOR
            for i in range(n):
                longest = max(longest, abs(step[i]))
            for i in range(n):
                trial[i] = q[row, i] + step[i] * min(1.0, LONGEST / longest)
            # 3.
            _evaluate(poses, trial, T, 4)
            left = pose_error(T, T_sd[row], mask, trial_error)
            if not left < size[row]:
                break
            q[row], error[:], size[row] = trial, trial_error, left


@compiled
def _evaluate(kernel: int, q: Floats, made: Floats, columns: int) -> None:
    """A matrix at a configuration, by a kernel's entry for few rows."""
    arguments, rows, strides = np.empty(2, np.int64), np.empty(1, np.int64), np.empty(5, np.int64)
    arguments[0], arguments[1], rows[0] = address(q), address(made), 1
    strides[0], strides[1], strides[2], strides[3], strides[4] = 8 * len(q), 8 * len(made), 8, 8 * columns, 8
    call_kernel(kernel, address(arguments), address(rows), address(strides))


@compiled
def pose_error(T: Floats, T_sd: Floats, mask: Floats, error: Floats) -> float:
    """What is left of a task: rotation vector and displacement in the reached frame; the larger of both.

    1. The displacement.
    2. The rotation vector; of a task that asks for the z axis alone the shortest turn that brings it there.

    Args:
        T, T_sd: (16,) reached and requested pose.
        mask: (6,) components that count.
        error: (6,) out.
    """
    # 1.
    R = np.empty(9)
    distance = turn = 0.0
    for c in range(3):
        along = 0.0
        for r in range(3):
            along += T[4 * r + c] * (T_sd[4 * r + 3] - T[4 * r + 3])
        error[3 + c] = along * mask[3 + c]
        distance += error[3 + c] ** 2
        for k in range(3):
            R[3 * c + k] = T[c] * T_sd[k] + T[4 + c] * T_sd[4 + k] + T[8 + c] * T_sd[8 + k]
    # 2.
    if mask[0] * mask[1] * mask[2] > 0.0:
        _rotation_vector(R, error)
    else:
        error[0], error[1], error[2] = -R[5] * mask[0], R[2] * mask[1], 0.0
        sine = sqrt(error[0] ** 2 + error[1] ** 2)
        if sine > EXACT_POSE:
            angle = atan2(sine, R[8])
            error[0], error[1] = error[0] * angle / sine, error[1] * angle / sine
        elif R[8] < 0.0:
            error[0] += pi * mask[0]
    for c in range(3):
        turn += error[c] ** 2
    return sqrt(max(distance, turn))


@compiled
def _rotation_vector(R: Floats, error: Floats) -> None:
    """The vector of a rotation (9,) into the first three of `error`."""
    x, y, z = 0.5 * (R[7] - R[5]), 0.5 * (R[2] - R[6]), 0.5 * (R[3] - R[1])
    sine, cosine = sqrt(x * x + y * y + z * z), 0.5 * (R[0] + R[4] + R[8] - 1.0)
    factor = atan2(sine, cosine) / sine if sine > 0.0 else 1.0
    error[0], error[1], error[2] = factor * x, factor * y, factor * z
    if cosine < 0.0 and sine < HALF_TURN:
        # (1 - cos) a a' = (R + R')/2 - cos I: its longest column has the axis, up to the sign.
        k = 0
        for j in range(1, 3):
            k = j if R[4 * j] > R[4 * k] else k
        length = along = 0.0
        for j in range(3):
            error[j] = 0.5 * (R[3 * j + k] + R[3 * k + j]) - (cosine if j == k else 0.0)
            length += error[j] ** 2
        along = error[0] * x + error[1] * y + error[2] * z
        factor = (-1.0 if along < 0.0 else 1.0) * atan2(sine, cosine) / sqrt(length)
        for j in range(3):
            error[j] *= factor


@compiled
def least_norm(J: Floats, e: Floats, V: Floats, x: Floats) -> None:
    """x = J+ e, singular values below `SINGULAR` of the largest left out, by one-sided rotations.

    1. Columns of J are turned in pairs until all are orthogonal, J V = U S.
    2. x = V S^-1 U' e.

    Args:
        J: (m, n), changed.
        e: (m,).
        V: (n, n) to work in.
        x: (n,) out.

    Reference: Hestenes, Inversion of Matrices by Biorthogonalization and Related Results, J. SIAM 6, 1958.
    """
    m, n = J.shape
    total = 0.0
    for i in range(n):
        x[i] = 0.0
        for k in range(n):
            V[i, k] = 1.0 if i == k else 0.0
        for r in range(m):
            total += J[r, i] ** 2
    # 1.
    for _ in range(SWEEPS):
        turned = False
        for i in range(n):
            for k in range(i + 1, n):
                a = b = c = 0.0
                for r in range(m):
                    a, b, c = a + J[r, i] ** 2, b + J[r, k] ** 2, c + J[r, i] * J[r, k]
                if abs(c) <= 4.0 * EPS * sqrt(a * b) or min(a, b) <= EPS * EPS * total:
                    continue
                turned = True
                zeta = (b - a) / (2.0 * c)
                t = (1.0 if zeta >= 0.0 else -1.0) / (abs(zeta) + sqrt(1.0 + zeta * zeta))
                cosine = 1.0 / sqrt(1.0 + t * t)
                _turn_columns(J, i, k, cosine, cosine * t)
                _turn_columns(V, i, k, cosine, cosine * t)
        if not turned:
            break
    # 2.
    largest = 0.0
    for turn in range(2):
        for i in range(n):
            square = share = 0.0
            for r in range(m):
                square, share = square + J[r, i] ** 2, share + J[r, i] * e[r]
            if turn == 0:
                largest = max(largest, square)
            elif square > SINGULAR * SINGULAR * largest:
                for k in range(n):
                    x[k] += V[k, i] * (share / square)


@compiled
def _turn_columns(A: Floats, i: int, k: int, cosine: float, sine: float) -> None:
    for r in range(len(A)):
        a, b = A[r, i], A[r, k]
        A[r, i], A[r, k] = cosine * a - sine * b, sine * a + cosine * b
