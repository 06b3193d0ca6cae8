"""Values of motions made of pieces of constant jerk: at many times, and how large they are where pieces meet."""

from __future__ import annotations

from mafsil.arrays import Floats
from mafsil.kernels.loops.loop import compiled

CANCELLED = 1e-15
"""Share of the largest acceleration so far below which one is zero: what jerks leave there is rounding, which a long
wait would multiply by the square of its duration."""
ROUNDED_TIME = 4e-16
"""Share of a time by which it may be off: so near to the end of a piece is its end."""


@compiled
def advance(p: float, v: float, a: float, j: float, t: float) -> tuple[float, float, float]:
    """The state after a time of constant jerk.

    Args:
        p, v, a: position, velocity, acceleration before.
        j: jerk.
        t: time [s].
    """
    return p + t * (v + t * (0.5 * a + t * j * (1.0 / 6.0))), v + t * (a + 0.5 * t * j), a + t * j


@compiled
def sample_rows(
    first: Floats, count: Floats, times: Floats, jerks: Floats, t: Floats, u: Floats, v: Floats, a: Floats, j: Floats
) -> None:
    """States of many coordinates at the same times, or at times of their own.

    Args:
        first: (rows, n, 6) of which p0, v0, a0 are used.
        count, times, jerks: (rows, n), (rows, n, pieces), (rows, n, pieces).
        t: (k, rows) times, not below zero, ascending in k for speed; beyond the last piece its end is held.
        u, v, a, j: (k, rows, n) written here.
    """
    for row in range(first.shape[0]):
        for i in range(first.shape[1]):
            pieces = int(count[row, i])
            piece, begin, most = 0, 0.0, 0.0
            p0, v0, a0 = first[row, i, 0], first[row, i, 1], first[row, i, 2]
            for k in range(len(t)):
                moment = t[k, row]
                if moment < begin:
                    piece, begin, most = 0, 0.0, 0.0
                    p0, v0, a0 = first[row, i, 0], first[row, i, 1], first[row, i, 2]
                while piece < pieces - 1 and moment >= begin + times[row, i, piece]:
                    most = max(most, abs(a0))
                    p0, v0, a0 = advance(p0, v0, a0, jerks[row, i, piece], times[row, i, piece])
                    if abs(a0) <= CANCELLED * most:
                        a0 = 0.0
                    begin += times[row, i, piece]
                    piece += 1
                local, jerk = moment - begin, 0.0
                if pieces > 0:
                    jerk = jerks[row, i, piece]
                    if local >= times[row, i, piece] - ROUNDED_TIME * moment:
                        local = times[row, i, piece]
                u[k, row, i], v[k, row, i], a[k, row, i] = advance(p0, v0, a0, jerk, local)
                j[k, row, i] = jerk


@compiled
def largest_rows(first: Floats, count: Floats, times: Floats, jerks: Floats, largest: Floats) -> None:
    """The largest sizes of position, velocity and acceleration where pieces begin and end.

    Args:
        first: (rows, n, 6) of which p0, v0, a0 are used.
        count, times, jerks: (rows, n), (rows, n, pieces), (rows, n, pieces).
        largest: (rows, n, 3) written here.
    """
    for row in range(first.shape[0]):
        for i in range(first.shape[1]):
            p, v, a = first[row, i, 0], first[row, i, 1], first[row, i, 2]
            most_p, most_v, most_a = abs(p), abs(v), abs(a)
            for piece in range(int(count[row, i])):
                p, v, a = advance(p, v, a, jerks[row, i, piece], times[row, i, piece])
                if abs(a) <= CANCELLED * most_a:
                    a = 0.0
                most_p, most_v, most_a = max(most_p, abs(p)), max(most_v, abs(v)), max(most_a, abs(a))
            largest[row, i, 0], largest[row, i, 1], largest[row, i, 2] = most_p, most_v, most_a
