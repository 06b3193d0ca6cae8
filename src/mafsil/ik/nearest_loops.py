"""The nearest of several solutions, compiled: whole turns and limits included."""

from __future__ import annotations

from math import ceil, inf, nan, pi, sqrt

import numpy as np

from mafsil.arrays import Booleans, Floats
from mafsil.ik.tolerances import ON_LIMIT, WHOLE_TURN
from mafsil.kernels.loops.loop import compiled

TURN = 2 * pi
BEYOND = 1e6
"""What a solution beyond the limits costs more than one within [rad | m]."""


@compiled
def nearest_rows(q: Floats, valid: Booleans, start: Floats, lower: Floats, upper: Floats, revolute: Booleans) -> Floats:
    """(m, n) for each pose the solution with the least distance to a start, within the limits if any is; NaN if none.

    1. Each angle moves by whole turns as near to the start as possible, then by the fewest turns into its limits;
       where none leads into them, it stays.
    2. The nearest row is kept; rows beyond a limit come after all others.

    Args:
        q: (m, k, n) solutions.
        valid: (m, k) which rows are solutions.
        start: (m, n) configurations, or (1, n) one for all.
        lower, upper: (n,) limits.
        revolute: (n,) which coordinates are angles.
    """
    poses, rows, n = q.shape
    nearest = np.full((poses, n), nan)
    wound = np.empty(n)
    for i in range(poses):
        near = start[i if len(start) > 1 else 0]
        least = inf
        for k in range(rows):
            if not valid[i, k]:
                continue
            # 1.
            square, cost = 0.0, 0.0
            for j in range(n):
                x = q[i, k, j]
                if revolute[j]:
                    x -= TURN * round((x - near[j]) / TURN)
                    shifted = x
                    if x < lower[j]:
                        shifted = x + TURN * ceil((lower[j] - x) / TURN - WHOLE_TURN)
                    elif x > upper[j]:
                        shifted = x - TURN * ceil((x - upper[j]) / TURN - WHOLE_TURN)
                    if lower[j] - ON_LIMIT <= shifted <= upper[j] + ON_LIMIT:
                        x = shifted
                if not lower[j] - ON_LIMIT <= x <= upper[j] + ON_LIMIT:
                    cost = BEYOND
                square += (x - near[j]) ** 2
                wound[j] = x
            # 2.
            cost += sqrt(square)
            if cost < least:
                least = cost
                nearest[i] = wound
    return nearest
