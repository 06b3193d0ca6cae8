"""Platforms on six legs, compiled: legs and their rates, and Newton's method from a first pose, row by row.

A pose is a row of seven numbers: a quaternion (w, x, y, z) of norm one and the place of the platform. The same loops
take real and complex numbers, so that a path through complex geometries (`path_loops`) ends in real poses.
"""

from __future__ import annotations

from math import sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.kernels.loops.loop import compiled, inlined
from mafsil.parallel.linear_loops import solve_in_place


@inlined
def rotation(x: Any, R: Any) -> None:
    """R (9,) by rows of the unit quaternion in x (7,)."""
    w, i, j, k = x[0], x[1], x[2], x[3]
    R[0], R[1], R[2] = 1 - 2 * (j * j + k * k), 2 * (i * j - w * k), 2 * (i * k + w * j)
    R[3], R[4], R[5] = 2 * (i * j + w * k), 1 - 2 * (i * i + k * k), 2 * (j * k - w * i)
    R[6], R[7], R[8] = 2 * (i * k - w * j), 2 * (j * k + w * i), 1 - 2 * (i * i + j * j)


@compiled
def legs(x: Any, a: Any, b: Any, squares: Any, R: Any, d: Any, M: Any, miss: Any) -> None:
    """Leg vectors, and (|d|^2 - s^2) / 2 with its derivatives by the twist of the platform.

    Args:
        x: (7,) pose.
        a, b: (6, 3) ends of the legs on the base and, in its frame, on the platform.
        squares: (6,) s^2.
        R: (9,) set to the rotation.
        d: (6, 3) set to d = p + R b - a.
        M: (6, 6) rows set to (a x d, d).
        miss: (6, k) first column set to (d.d - s^2) / 2.
    """
    rotation(x, R)
    for i in range(6):
        bx, by, bz = b[i, 0], b[i, 1], b[i, 2]
        ax, ay, az = a[i, 0], a[i, 1], a[i, 2]
        u = x[4] + R[0] * bx + R[1] * by + R[2] * bz - ax
        v = x[5] + R[3] * bx + R[4] * by + R[5] * bz - ay
        w = x[6] + R[6] * bx + R[7] * by + R[8] * bz - az
        d[i, 0], d[i, 1], d[i, 2] = u, v, w
        M[i, 0], M[i, 1], M[i, 2] = ay * w - az * v, az * u - ax * w, ax * v - ay * u
        M[i, 3], M[i, 4], M[i, 5] = u, v, w
        miss[i, 0] = 0.5 * (u * u + v * v + w * w - squares[i])


@inlined
def rates_of(x: Any, V: Any, out: Any) -> None:
    """Out (7,) <- derivative of the pose x for a space twist V (6,): q' = omega q / 2, p' = v + omega x p."""
    p, q, r = V[0], V[1], V[2]
    out[0] = -0.5 * (p * x[1] + q * x[2] + r * x[3])
    out[1] = 0.5 * (p * x[0] + q * x[3] - r * x[2])
    out[2] = 0.5 * (q * x[0] + r * x[1] - p * x[3])
    out[3] = 0.5 * (r * x[0] + p * x[2] - q * x[1])
    out[4] = V[3] + q * x[6] - r * x[5]
    out[5] = V[4] + r * x[4] - p * x[6]
    out[6] = V[5] + p * x[5] - q * x[4]


@inlined
def of_norm_one(x: Any) -> None:
    """The quaternion of x (7,), nearly of norm one, brought nearer: its square of norm deviates by less than 1e-2."""
    for _ in range(3):
        e = x[0] * x[0] + x[1] * x[1] + x[2] * x[2] + x[3] * x[3] - 1.0
        f = 1.0 - e * (0.5 - 0.375 * e)
        for j in range(4):
            x[j] *= f


@compiled
def largest(miss: Any) -> float:
    """Largest absolute value in the first column of (6, k)."""
    most = 0.0
    for i in range(6):
        size = abs(miss[i, 0])
        if not size <= most:
            most = size
    return most


@compiled
def newton(
    lengths: Floats, starts: Floats, a: Floats, b: Floats, tolerance: float, most: int,
    x_out: Floats, error: Floats, steps: NDArray[np.int64], spread: Floats,
) -> None:  # fmt: skip
    """Poses near first ones, with legs of given lengths, row by row.

    1. The residual (|d|^2 - s^2) / 2 and its derivatives by the twist, which stay defined for a leg of length zero.
    2. One Newton step, shortened to half a turn at most; where the residual grows it is halved up to ten times.
    3. Done when every leg is within the tolerance, and one step more takes what is left.

    Args:
        lengths: (k, 6).
        starts: (k, 7) poses.
        a, b: (6, 3).
        tolerance: of a length.
        most: steps.
        x_out: (k, 7) set to the last poses.
        error: (k,) set to the largest error of a length.
        steps: (k,) set to the number of steps.
        spread: (k,) set to the least pivot over the largest of the last step.
    """
    x, trial, rate = np.empty(7), np.empty(7), np.empty(7)
    R, d, M, miss, step, squares = (
        np.empty(9),
        np.empty((6, 3)),
        np.empty((6, 6)),
        np.empty((6, 1)),
        np.empty((6, 1)),
        np.empty(6),
    )
    for row in range(lengths.shape[0]):
        for j in range(7):
            x[j] = starts[row, j]
        for j in range(6):
            squares[j] = lengths[row, j] ** 2
        taken, closing, pivot = 0, False, 0.0
        # 1.
        legs(x, a, b, squares, R, d, M, miss)
        now = largest(miss)
        while taken < most:
            for j in range(6):
                step[j, 0] = -miss[j, 0]
            pivot = solve_in_place(M, step)
            if pivot == 0.0 or not np.isfinite(now):
                break
            # 2.
            turn = sqrt(step[0, 0] ** 2 + step[1, 0] ** 2 + step[2, 0] ** 2)
            share = min(1.0, 1.5 / turn) if turn > 0.0 else 1.0
            for j in range(6):
                step[j, 0] *= share
            rates_of(x, step[:, 0], rate)
            part, after = 1.0, now
            for _ in range(11):
                for j in range(7):
                    trial[j] = x[j] + part * rate[j]
                norm = sqrt(trial[0] ** 2 + trial[1] ** 2 + trial[2] ** 2 + trial[3] ** 2)
                for j in range(4):
                    trial[j] /= norm
                legs(trial, a, b, squares, R, d, M, miss)
                after = largest(miss)
                if after < now or closing:
                    break
                part *= 0.5
            if closing and not after < now:
                break
            for j in range(7):
                x[j] = trial[j]
            now = after
            taken += 1
            if closing or now == 0.0:
                break
            # 3.
            closing = _leg_error(d, lengths, row) <= tolerance
        legs(x, a, b, squares, R, d, M, miss)
        for j in range(7):
            x_out[row, j] = x[j]
        error[row], steps[row], spread[row] = _leg_error(d, lengths, row), taken, pivot


@inlined
def _leg_error(d: Any, lengths: Any, row: int) -> float:
    most = 0.0
    for i in range(6):
        size = abs(sqrt(d[i, 0] ** 2 + d[i, 1] ** 2 + d[i, 2] ** 2) - abs(lengths[row, i]))
        if not size <= most:
            most = size
    return most
