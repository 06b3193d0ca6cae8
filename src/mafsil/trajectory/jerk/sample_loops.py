"""Values of motions made of pieces of constant jerk: at many times, at the pieces' beginnings, and their extremes."""

from __future__ import annotations

from mafsil.arrays import Floats
from mafsil.kernels.loops.loop import compiled


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
            piece, begin = 0, 0.0
            p0, v0, a0 = first[row, i, 0], first[row, i, 1], first[row, i, 2]
            for k in range(len(t)):
                moment = t[k, row]
                if moment < begin:
                    piece, begin = 0, 0.0
                    p0, v0, a0 = first[row, i, 0], first[row, i, 1], first[row, i, 2]
                while piece < pieces - 1 and moment >= begin + times[row, i, piece]:
                    p0, v0, a0 = advance(p0, v0, a0, jerks[row, i, piece], times[row, i, piece])
                    begin += times[row, i, piece]
                    piece += 1
                local, jerk = moment - begin, 0.0
                if pieces > 0:
                    local, jerk = min(local, times[row, i, piece]), jerks[row, i, piece]
                u[k, row, i], v[k, row, i], a[k, row, i] = advance(p0, v0, a0, jerk, local)
                j[k, row, i] = jerk
