"""Whole turns of revolute joints, compiled: angles near a value and within limits, and solutions that are one."""

from __future__ import annotations

from math import ceil, inf, nan, pi, sqrt

import numpy as np

from mafsil.arrays import Booleans, Floats
from mafsil.ik.tolerances import ON_LIMIT, SAME, WHOLE_TURN
from mafsil.kernels.loops.loop import compiled, inlined

TURN = 2 * pi
BEYOND = 1e6
"""What a solution beyond the limits costs more than one within [rad | m]."""


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
