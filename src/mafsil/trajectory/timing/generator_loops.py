"""The tick of a generator, compiled: one piece of polynomials evaluated into arrays that are there already."""

from __future__ import annotations

from mafsil.arrays import Floats
from mafsil.kernels.loops.loop import compiled


@compiled
def evaluate(
    knots: Floats, coefficients: Floats, t: float, piece: int, u_out: Floats, v_out: Floats, a_out: Floats
) -> int:
    """Position, velocity and acceleration at a time; the index of its piece, -1 at rest outside.

    1. The next piece when one has ended (half-open: its start belongs to it); a time that goes back starts anew.
    2. Horner's rule with the local time t - T_k, which is never reset to zero.
    3. Before the start and after the end: hold the position, rates zero.

    Args:
        knots: (pieces + 1,) [s].
        coefficients: (pieces, degree + 1, n) ascending.
        t: [s].
        piece: where to look first, that of the tick before.
        u_out, v_out, a_out: (n,) written.
    """
    pieces, terms, n = coefficients.shape
    # 1
    if piece < 0 or piece >= pieces or t < knots[piece]:
        piece = 0
    while piece < pieces - 1 and t >= knots[piece + 1]:
        piece += 1
    # 2
    end = knots[pieces]
    local = min(max(t, 0.0), end) - knots[piece]
    for i in range(n):
        u = v = a = 0.0
        for k in range(terms - 1, -1, -1):
            a = a * local + 2.0 * v
            v = v * local + u
            u = u * local + coefficients[piece, k, i]
        u_out[i], v_out[i], a_out[i] = u, v, a
    # 3
    if t < 0.0 or t > end:
        for i in range(n):
            v_out[i] = 0.0
            a_out[i] = 0.0
        return -1
    return piece
