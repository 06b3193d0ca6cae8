"""Platforms on six legs in complex poses, eight side by side: equations of Newton's method along a path, compiled.

A pose is a row of seven numbers, as in `stewart_loops`: a quaternion (w, x, y, z) of norm one, and the place.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from mafsil.kernels.loops.lanes import part
from mafsil.kernels.loops.loop import compiled, inlined
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
