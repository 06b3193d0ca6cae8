"""Platforms on six legs, compiled: where paths of poses end is made exact, and poses that differ are gathered."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mafsil.kernels.loops.loop import compiled
from mafsil.parallel.linear_loops import solve_in_place
from mafsil.parallel.platforms.stewart_loops import legs, of_norm_one, rates_of

ARRIVED, MERGED, UNBOUNDED, STUCK = 0, 1, 2, 3

LARGEST = 1e7
"""Poses whose numbers grow beyond it (lengths over the size) run to infinity."""
EXACT = 1e-13
"""Corrections below it, over the pose, are the last at the end of a path: a double pose comes nearer by half."""
LAST_STEPS = 60
"""Most of them."""


@compiled
def finish(x: Any, g: Any, R: Any, d: Any, M: Any, r: Any, rate: Any) -> bool:
    """A pose x (7,) near the end of its path made exact by Newton's method; whether its corrections ended.

    1. One matrix and what the legs miss.
    2. The corrected pose; done when the correction is rounding.

    Args:
        x: pose, corrected.
        g: (6, 7) ends on the base, on the platform, squares of lengths.
        R, d, M, r, rate: work, (9,), (6, 3), (6, 6), (6, 1), (7,).
    """
    for _ in range(LAST_STEPS):
        # 1.
        legs(x, g[:, 0:3], g[:, 3:6], g[:, 6], R, d, M, r)
        if solve_in_place(M, r) == 0.0:
            return False
        # 2.
        rates_of(x, r[:, 0], rate)
        size, scale = 0.0, 1.0
        for i in range(6):
            size = max(size, abs(r[i, 0].real) + abs(r[i, 0].imag))
        for j in range(7):
            scale = max(scale, abs(x[j].real) + abs(x[j].imag))
            x[j] -= rate[j]
        of_norm_one(x)
        if size <= EXACT * scale:
            return True
    return False


@compiled
def apart(x: Any, y: Any) -> float:
    """Largest difference of poses, whose quaternions mean the same with the other sign."""
    same, other, place = 0.0, 0.0, 0.0
    for j in range(4):
        same, other = max(same, abs(x[j] - y[j])), max(other, abs(x[j] + y[j]))
    for j in range(4, 7):
        place = max(place, abs(x[j] - y[j]))
    return max(min(same, other), place)


@compiled
def collect(
    found: Any,
    ended: NDArray[np.bool_],
    same: float,
    real: bool,
    kept: Any,
    count: NDArray[np.int64],
    times: NDArray[np.int64],
) -> None:
    """Poses that differ, row by row, added to those that are kept already.

    1. A pose of a path that ended there is kept unless it is there; then it is counted once more.
    2. Of real geometry poses come in conjugate pairs: the conjugate of a complex one is kept too.

    Args:
        found: (k, m, 7) poses; ended: (k, m) which of them are poses.
        same: difference below which poses are one.
        real: whether the geometry is real.
        kept: (k, n, 7) poses so far.
        count: (k,) how many; times: (k, n) how many paths ended there in this call.
    """
    mirror = np.empty(7, np.complex128)
    for row in range(found.shape[0]):
        for path in range(found.shape[1]):
            # 1.
            if ended[row, path]:
                _keep(found[row, path], same, kept[row], count, times[row], row, 1)
        if real:
            # 2.
            for k in range(count[row]):
                for j in range(7):
                    mirror[j] = kept[row, k, j].conjugate()
                if apart(mirror, kept[row, k]) > same:
                    _keep(mirror, same, kept[row], count, times[row], row, 0)


@compiled
def _keep(x: Any, same: float, kept: Any, count: Any, times: Any, row: int, more: int) -> None:
    for j in range(7):
        if not abs(x[j]) < LARGEST:
            return
    for k in range(count[row]):
        # Most differ in one number already, whose real part is quicker than all absolute values.
        if abs(x[4].real - kept[k, 4].real) <= same and apart(x, kept[k]) <= same:
            times[k] += more
            return
    if count[row] < kept.shape[0]:
        for j in range(7):
            kept[count[row], j] = x[j]
        times[count[row]] = more
        count[row] += 1
