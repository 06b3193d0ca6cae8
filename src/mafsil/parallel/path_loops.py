"""Platforms on six legs, compiled: all poses of given lengths by continuation from a platform whose poses are known.

Geometry and squares of lengths move on a straight line, t in [0, 1], from a complex start to what is wanted. Every pose
of the start is followed:

1. Predictor: (|d|^2 - s^2) / 2 = 0 differentiated along t gives the twist; Runge and Kutta's step of order four.
2. Corrector: Newton's method at the new t. A step that corrects by more than a share of itself may have jumped to
   another path: it is halved and tried again. After a few good steps in a row the step is doubled.
3. A path ends at t = 1; or it is lost: poses grow without bound, or the steps become too short because paths meet.

Reference: Sommese and Wampler, The Numerical Solution of Systems of Polynomials, 2005, ch. 2 and 7 (parameter
continuation: a general start has as many poses as any platform can have isolated ones).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mafsil.parallel.linear_loops import solved
from mafsil.parallel.stewart_loops import legs, of_norm_one, rates_of
from mafsil.solvers.loops import compiled, uncounted

ARRIVED, MERGED, UNBOUNDED, STUCK = 0, 1, 2, 3

LARGEST = 1e5
"""Poses whose numbers grow beyond it (lengths over the size) run to infinity."""
SHORTEST = 1e-9
"""Steps below it are not taken: two paths meet there."""
NEARLY = 1e-4
"""Paths that meet this near to the end have met at the end, in a pose that is singular there."""
FIRST = 0.05
LONGEST = 0.25
CORRECTION = 2e-4
"""Most that the corrector may move a pose of size one: paths of platforms of size one are farther apart."""
GOOD_STEPS = 3


@uncounted
def at(t: float, start: Any, dg: Any, g: Any) -> None:
    """G (6, 7) <- start + t dg, the geometry at t."""
    for i in range(6):
        for j in range(7):
            g[i, j] = start[i, j] + t * dg[i, j]


@uncounted
def motion(x: Any, g: Any, dg: Any, R: Any, d: Any, M: Any, r: Any, out: Any) -> bool:
    """Out (7,) <- derivative of the pose x by t; false if it is singular.

    Args:
        x: (7,) pose.
        g: (6, 7) ends on the base, on the platform, squares of lengths, at t.
        dg: (6, 7) their derivatives by t.
        R, d, M, r: work.
        out: set.
    """
    legs(x, g[:, 0:3], g[:, 3:6], g[:, 6], R, d, M, r)
    for i in range(6):
        u, v, w = dg[i, 3], dg[i, 4], dg[i, 5]
        r[i, 0] = (
            0.5 * dg[i, 6]
            - d[i, 0] * (R[0] * u + R[1] * v + R[2] * w - dg[i, 0])
            - d[i, 1] * (R[3] * u + R[4] * v + R[5] * w - dg[i, 1])
            - d[i, 2] * (R[6] * u + R[7] * v + R[8] * w - dg[i, 2])
        )
    if solved(M, r) == 0.0:
        return False
    rates_of(x, r, out)
    return True


@uncounted
def corrected(x: Any, g: Any, R: Any, d: Any, M: Any, r: Any, rate: Any, most: float, steps: int) -> float:
    """Newton's method on the pose x (7,) at geometry g (6, 7); the first correction, infinite if it did not end."""
    first = -1.0
    for _ in range(steps):
        legs(x, g[:, 0:3], g[:, 3:6], g[:, 6], R, d, M, r)
        for i in range(6):
            r[i, 0] = -r[i, 0]
        if solved(M, r) == 0.0:
            return np.inf
        size = 0.0
        for i in range(6):
            size = max(size, abs(r[i, 0].real) + abs(r[i, 0].imag))
        scale = 1.0
        for j in range(7):
            scale = max(scale, abs(x[j].real) + abs(x[j].imag))
        rates_of(x, r, rate)
        for j in range(7):
            x[j] += rate[j]
        of_norm_one(x)
        if first < 0.0:
            first = size / scale
            if not first <= most:
                return np.inf
        if size <= 1e-8 * scale:
            return first
    return np.inf


@uncounted
def follow(x: Any, start: Any, dg: Any, g: Any, K: Any, y: Any, R: Any, d: Any, M: Any, r: Any, most: float) -> int:
    """The pose x (7,) from t = 0 to t = 1; how it ended. Work arrays as in `follow_all`."""
    t, step, good = 0.0, FIRST, 0
    while t < 1.0:
        h = min(step, 1.0 - t)
        # 1.
        regular = True
        for stage in range(4):
            part = 0.0 if stage == 0 else (h if stage == 3 else 0.5 * h)
            if stage != 2:
                at(t + part, start, dg, g)
            for j in range(7):
                y[j] = x[j] if stage == 0 else x[j] + part * K[stage - 1, j]
            regular = regular and motion(y, g, dg, R, d, M, r, K[stage])
        # 2. The geometry stands at t + h.
        for j in range(7):
            y[j] = x[j] + h / 6.0 * (K[0, j] + 2.0 * K[1, j] + 2.0 * K[2, j] + K[3, j])
        of_norm_one(y)
        change = corrected(y, g, R, d, M, r, K[0], most, 3) if regular else np.inf
        # 3.
        if change <= most:
            t += h
            size = 0.0
            for j in range(7):
                x[j] = y[j]
                size = max(size, abs(x[j].real) + abs(x[j].imag))
            if not size < LARGEST:
                return UNBOUNDED
            good += 1
            if good >= GOOD_STEPS and change < 0.25 * most:
                step, good = min(2.0 * step, LONGEST), 0
        else:
            step, good = 0.5 * h, 0
            if step < SHORTEST:
                at_end = 1.0 - t < NEARLY
                if at_end:
                    at(1.0, start, dg, g)
                    corrected(x, g, R, d, M, r, K[0], np.inf, 60)
                return MERGED if at_end else STUCK
    at(1.0, start, dg, g)
    corrected(x, g, R, d, M, r, K[0], np.inf, 8)
    return ARRIVED


@compiled
def follow_all(start: Any, ends: Any, poses: Any, most: float, out: Any, how: NDArray[np.int8]) -> None:
    """All poses of a start followed to many ends.

    Args:
        start: (6, 7) complex: ends on the base, on the platform, squares of lengths.
        ends: (k, 6, 7) the same of the ends.
        poses: (m, 7) poses of the start.
        most: largest share of a pose that a corrector may move.
        out: (k, m, 7) set to the poses of the ends.
        how: (k, m) set to how each path ended.
    """
    dg, g, K = np.empty((6, 7), np.complex128), np.empty((6, 7), np.complex128), np.empty((4, 7), np.complex128)
    y, R, d = np.empty(7, np.complex128), np.empty(9, np.complex128), np.empty((6, 3), np.complex128)
    M, r = np.empty((6, 6), np.complex128), np.empty((6, 1), np.complex128)
    for row in range(ends.shape[0]):
        for i in range(6):
            for j in range(7):
                dg[i, j] = ends[row, i, j] - start[i, j]
        for path in range(poses.shape[0]):
            x = out[row, path]
            for j in range(7):
                x[j] = poses[path, j]
            how[row, path] = follow(x, start, dg, g, K, y, R, d, M, r, most)


@uncounted
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
    how: NDArray[np.int8],
    same: float,
    real: bool,
    kept: Any,
    count: NDArray[np.int64],
    times: NDArray[np.int64],
) -> None:
    """Poses that differ, row by row, added to those that are kept already.

    1. A pose of a path that arrived, or merged, is kept unless it is there; then it is counted once more.
    2. Of real geometry poses come in conjugate pairs: the conjugate of a complex one is kept too.

    Args:
        found: (k, m, 7) poses; how: (k, m) how their paths ended.
        same: difference below which poses are one.
        real: whether the geometry is real.
        kept: (k, n, 7) poses so far.
        count: (k,) how many; times: (k, n) how many paths ended there in this call.
    """
    mirror = np.empty(7, np.complex128)
    for row in range(found.shape[0]):
        for path in range(found.shape[1]):
            # 1.
            if how[row, path] <= MERGED:
                _keep(found[row, path], same, kept[row], count, times[row], row, 1)
        if real:
            # 2.
            for k in range(count[row]):
                for j in range(7):
                    mirror[j] = kept[row, k, j].conjugate()
                if apart(mirror, kept[row, k]) > same:
                    _keep(mirror, same, kept[row], count, times[row], row, 0)


@uncounted
def _keep(x: Any, same: float, kept: Any, count: Any, times: Any, row: int, more: int) -> None:
    for j in range(7):
        if not abs(x[j]) < LARGEST:
            return
    for k in range(count[row]):
        if apart(x, kept[k]) <= same:
            times[k] += more
            return
    if count[row] < kept.shape[0]:
        for j in range(7):
            kept[count[row], j] = x[j]
        times[count[row]] = more
        count[row] += 1
