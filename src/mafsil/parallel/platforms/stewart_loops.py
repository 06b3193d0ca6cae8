"""Platforms on six legs, compiled: legs and their rates, and Newton's method from a first pose, row by row.

A pose is a row of seven numbers: a quaternion (w, x, y, z) of norm one and the place of the platform. The same loops
take real and complex numbers, so that a path through complex geometries (`path_loops`) ends in real poses.

Platforms on six legs in complex poses, eight side by side: equations of Newton's method along a path, compiled.

A pose is a row of seven numbers, as in `stewart_loops`: a quaternion (w, x, y, z) of norm one, and the place.
"""

from __future__ import annotations

from math import sqrt
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.kernels.loops.lanes import part
from mafsil.kernels.loops.loop import compiled, inlined
from mafsil.parallel.linear_loops import solve_in_place
from mafsil.parallel.platforms.complex_lane_loops import (
    keep,
    minus,
    minus_times,
    number,
    plus,
    plus_times,
    scale_complex,
    times,
)

if TYPE_CHECKING:
    from mafsil.kernels.loops.lanes import Buffer, Lanes


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


@compiled
def legs_in_lanes(x: Buffer, start: Any, moves: Buffer, t: Lanes, r: Buffer, m: Buffer) -> None:
    """Equations of Newton's method: rows (a x d, d), what (|d|^2 - s^2) / 2 misses, and the rate of that along t.

    Args:
        x: (7,) poses.
        start: (6, 14) geometry at t = 0, real and imaginary parts in turn: ends on the base, on the platform, s^2.
        moves: (6, 7) its derivative by t, a number for each lane.
        t: where each lane is.
        r: (9,) set to the rotations.
        m: (6, 8) set to matrices and both right sides.
    """
    rotation_in_lanes(x, r)
    for i in range(6):
        g = part(moves, 14 * i)
        da, db = (number(g, 0), number(g, 1), number(g, 2)), (number(g, 3), number(g, 4), number(g, 5))
        a0, a1, a2 = at(start, i, 0, t, da[0]), at(start, i, 1, t, da[1]), at(start, i, 2, t, da[2])
        b0, b1, b2 = at(start, i, 3, t, db[0]), at(start, i, 4, t, db[1]), at(start, i, 5, t, db[2])
        d0 = minus(plus(number(x, 4), rotate_row(r, 0, b0, b1, b2)), a0)
        d1 = minus(plus(number(x, 5), rotate_row(r, 1, b0, b1, b2)), a1)
        d2 = minus(plus(number(x, 6), rotate_row(r, 2, b0, b1, b2)), a2)
        keep(m, 8 * i, minus_times(times(a1, d2), a2, d1))
        keep(m, 8 * i + 1, minus_times(times(a2, d0), a0, d2))
        keep(m, 8 * i + 2, minus_times(times(a0, d1), a1, d0))
        keep(m, 8 * i + 3, d0)
        keep(m, 8 * i + 4, d1)
        keep(m, 8 * i + 5, d2)
        ds = number(g, 6)
        missed = minus_times(minus_times(minus_times(at(start, i, 6, t, ds), d0, d0), d1, d1), d2, d2)
        keep(m, 8 * i + 6, scale_complex(0.5, missed))
        rate = scale_complex(0.5, ds)
        rate = minus_times(rate, d0, minus(rotate_row(r, 0, db[0], db[1], db[2]), da[0]))
        rate = minus_times(rate, d1, minus(rotate_row(r, 1, db[0], db[1], db[2]), da[1]))
        keep(m, 8 * i + 7, minus_times(rate, d2, minus(rotate_row(r, 2, db[0], db[1], db[2]), da[2])))


@inlined
def at(start: Any, i: int, j: int, t: Lanes, move: Any) -> Any:
    """Number j of leg i at t."""
    return t * move[0] + start[i, 2 * j], t * move[1] + start[i, 2 * j + 1]


@inlined
def rotate_row(r: Buffer, row: int, b0: Any, b1: Any, b2: Any) -> Any:
    """A row of the rotation times b."""
    return plus_times(plus_times(times(number(r, 3 * row), b0), number(r, 3 * row + 1), b1), number(r, 3 * row + 2), b2)


@inlined
def rotation_in_lanes(x: Buffer, r: Buffer) -> None:
    """R (9,) by rows of the unit quaternion in x (7,)."""
    w, i, j, k = number(x, 0), number(x, 1), number(x, 2), number(x, 3)
    ii, jj, kk = times(i, i), times(j, j), times(k, k)
    ij, ik, jk = times(i, j), times(i, k), times(j, k)
    wi, wj, wk = times(w, i), times(w, j), times(w, k)
    _diagonal(r, 0, jj, kk)
    _diagonal(r, 4, ii, kk)
    _diagonal(r, 8, ii, jj)
    keep(r, 1, scale_complex(2.0, minus(ij, wk)))
    keep(r, 2, scale_complex(2.0, plus(ik, wj)))
    keep(r, 3, scale_complex(2.0, plus(ij, wk)))
    keep(r, 5, scale_complex(2.0, minus(jk, wi)))
    keep(r, 6, scale_complex(2.0, minus(ik, wj)))
    keep(r, 7, scale_complex(2.0, plus(jk, wi)))


@inlined
def _diagonal(r: Buffer, k: int, a: Any, b: Any) -> None:
    s = plus(a, b)
    r[2 * k], r[2 * k + 1] = 1.0 - 2.0 * s[0], -2.0 * s[1]


@inlined
def rates_in_lanes(x: Buffer, m: Buffer, column: int, out: Buffer) -> None:
    """Out (7,) <- derivative of x for the space twist in a column of m: q' = omega q / 2, p' = v + omega x p."""
    p, q, r = number(m, column), number(m, 8 + column), number(m, 16 + column)
    w, i, j, k = number(x, 0), number(x, 1), number(x, 2), number(x, 3)
    keep(out, 0, scale_complex(-0.5, plus_times(plus_times(times(p, i), q, j), r, k)))
    keep(out, 1, scale_complex(0.5, minus_times(plus_times(times(p, w), q, k), r, j)))
    keep(out, 2, scale_complex(0.5, minus_times(plus_times(times(q, w), r, i), p, k)))
    keep(out, 3, scale_complex(0.5, minus_times(plus_times(times(r, w), p, j), q, i)))
    u, v, z = number(x, 4), number(x, 5), number(x, 6)
    keep(out, 4, minus_times(plus_times(number(m, 24 + column), q, z), r, v))
    keep(out, 5, minus_times(plus_times(number(m, 32 + column), r, u), p, z))
    keep(out, 6, minus_times(plus_times(number(m, 40 + column), p, v), q, u))


@inlined
def norm_one_in_lanes(x: Buffer) -> None:
    """The quaternion of x (7,), of norm one within 1e-3, brought nearer: within 1e-9, or within rounding of 1e-6."""
    e0, e1 = x[0] * x[0] - x[1] * x[1] - 1.0, 2.0 * x[0] * x[1]
    for j in range(1, 4):
        e0, e1 = e0 + x[2 * j] * x[2 * j] - x[2 * j + 1] * x[2 * j + 1], e1 + 2.0 * x[2 * j] * x[2 * j + 1]
    f0, f1 = 0.375 * e0 - 0.5, 0.375 * e1
    f0, f1 = 1.0 + e0 * f0 - e1 * f1, e0 * f1 + e1 * f0
    for j in range(4):
        keep(x, j, times(number(x, j), (f0, f1)))
