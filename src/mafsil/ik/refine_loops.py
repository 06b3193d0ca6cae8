"""Rows that are nearly solutions, compiled: moved by Newton's method, judged, wound into limits; which are one."""

from __future__ import annotations

from math import asin, atan2, ceil, inf, nan, pi, sqrt

import numpy as np

from mafsil.arrays import Booleans, Floats, Integers
from mafsil.floating_point import EPS, LEAST_DIVISOR
from mafsil.ik.tolerances import EXACT_POSE, NO_BETTER, ON_LIMIT, SAME, SINGULAR, WHOLE_TURN
from mafsil.kernels.loops.lanes import address, call_kernel
from mafsil.kernels.loops.loop import compiled, inlined

TURN = 2 * pi
BEYOND = 1e6
"""What a solution beyond the limits costs more than one within [rad | m]."""
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


@inlined
def wound_angle(x: float, near: float, low: float, high: float) -> float:
    """The angle by whole turns as near as possible, then by the fewest turns into its limits; else the nearest.

    Args:
        x: the angle [rad].
        near: what it is brought near to [rad].
        low, high: limits [rad].
    """
    x -= TURN * round((x - near) / TURN)
    turns = 0.0
    if x < low:
        turns = ceil((low - x) / TURN - WHOLE_TURN)
    elif x > high:
        turns = -ceil((x - high) / TURN - WHOLE_TURN)
    shifted = x + TURN * turns
    return shifted if low - ON_LIMIT <= shifted <= high + ON_LIMIT else x


@compiled
def nearest_rows(q: Floats, valid: Booleans, start: Floats, lower: Floats, upper: Floats, revolute: Booleans) -> Floats:
    """(m, n) for each pose the solution with the least distance to a start, within the limits if any is; NaN if none.

    1. Each angle is wound near the start and into its limits.
    2. The nearest row is kept; rows beyond a limit come after all others.

    Args:
        q: (m, k, n) solutions.
        valid: (m, k) which rows are solutions.
        start: (m, n) configurations.
        lower, upper: (n,) limits.
        revolute: (n,) which coordinates are angles.
    """
    poses, rows, n = q.shape
    nearest = np.full((poses, n), nan)
    wound = np.empty(n)
    for i in range(poses):
        least = inf
        for k in range(rows):
            if not valid[i, k]:
                continue
            # 1.
            square, cost = 0.0, 0.0
            for j in range(n):
                x = q[i, k, j]
                if revolute[j]:
                    x = wound_angle(x, start[i, j], lower[j], upper[j])
                if not lower[j] - ON_LIMIT <= x <= upper[j] + ON_LIMIT:
                    cost = BEYOND
                square += (x - start[i, j]) ** 2
                wound[j] = x
            # 2.
            cost += sqrt(square)
            if cost < least:
                least = cost
                nearest[i] = wound
    return nearest


@compiled
def unique_rows(q: Floats, good: Booleans, revolute: Booleans) -> None:
    """Take away rows that repeat an earlier good row of their pose, up to whole turns.

    Args:
        q: (m, k, n) coordinates.
        good: (m, k) which of them are solutions, changed.
        revolute: (n,) which coordinates are angles.
    """
    for i in range(len(q)):
        for k in range(1, q.shape[1]):
            for earlier in range(k):
                if good[i, k] and good[i, earlier] and _are_one(q[i, k], q[i, earlier], revolute):
                    good[i, k] = False


@compiled
def _are_one(one: Floats, other: Floats, revolute: Booleans) -> bool:
    for j in range(len(one)):
        apart = one[j] - other[j]
        if revolute[j]:
            apart -= TURN * round(apart / TURN)
        if not abs(apart) <= SAME:
            return False
    return True


@compiled
def judge_solutions(
    reached: Floats,
    T: Floats,
    rows: Integers,
    q0: Floats,
    lower: Floats,
    upper: Floats,
    revolute: Booleans,
    q: Floats,
    residual: Floats,
    within: Booleans,
) -> float:
    """Errors of solutions, and their angles wound as near to `q0` as the limits allow; the largest error.

    1. The distance, and the angle between the rotations: half the axis of R R_d^T has its sine for a length; where
       the trace is small the angle is large, and only that is said.
    2. The turn nearest to `q0`; if it is beyond a limit, the first turn within; if there is none, the nearest.

    Args:
        reached: (m, 4, 4) poses of the solutions.
        T: (k, 4, 4) requested poses.
        rows: (m,) which of them each solution belongs to.
        q0: (n,) values to which angles are wound.
        lower, upper: (n,) limits.
        revolute: (n,) which coordinates are angles.
        q: (m, n) solutions.
        residual: (m,) the larger of angle [rad] and distance [m].
        within: (m,) whether a solution is within the limits.
    """
    worst = 0.0
    for i in range(len(q)):
        # 1.
        A, B = reached[i], T[rows[i]]
        square = length = trace = 0.0
        for r in range(3):
            u, v = (r + 1) % 3, (r + 2) % 3
            axis = 0.0
            for c in range(3):
                axis += A[u, c] * B[v, c] - A[v, c] * B[u, c]
                trace += A[r, c] * B[r, c]
            square += 0.25 * axis * axis
            length += (A[r, 3] - B[r, 3]) ** 2
        angle = asin(min(1.0, sqrt(square))) if trace > 1.0 else 0.5 * pi
        residual[i] = max(angle, sqrt(length))
        if not square + length < 1e300:
            residual[i] = 1e300
        worst = max(worst, residual[i])
        # 2.
        inside = True
        for k in range(q.shape[1]):
            x, low, high = q[i, k], lower[k], upper[k]
            if revolute[k]:
                x = wound_angle(x, q0[k], low, high)
                q[i, k] = x
            inside = inside and low - ON_LIMIT <= x <= high + ON_LIMIT
        within[i] = inside
    return worst


@compiled
def place_lists(
    solutions: Floats,
    errors: Floats,
    inside: Booleans,
    count: Integers,
    largest: float,
    q: Floats,
    residual: Floats,
    within: Booleans,
    sure: Booleans,
) -> None:
    """Lists that stand one after the other, each into the rows of its pose if all its errors are small.

    Args:
        solutions, errors, inside: (m, n), (m,) and (m,) of all poses.
        count: (k,) how many of each; none, or fewer, where nothing is proven.
        largest: error of a list that is sure.
        q, residual, within: (k, most, n), (k, most) and (k, most), NaN and false.
        sure: (k,) false; set where there is a list.
    """
    begin = 0
    for b in range(len(count)):
        number = max(0, count[b])
        good = number > 0
        for i in range(begin, begin + number):
            good = good and errors[i] <= largest
        sure[b] = good
        for i in range(number if good else 0):
            residual[b, i], within[b, i] = errors[begin + i], inside[begin + i]
            for k in range(solutions.shape[1]):
                q[b, i, k] = solutions[begin + i, k]
        begin += number
