"""Platforms on six legs, compiled: all poses of given lengths by continuation from a platform whose poses are known.

Geometry and squares of lengths move on a straight line, t in [0, 1], from a complex start to what is wanted. Every pose
of the start is followed:

1. Predictor: the polynomial through the last three poses and their rates along t, extrapolated.
2. Corrector: Newton's method at the new t, (|d|^2 - s^2) / 2 = 0; the last of its matrices gives the rate too. A step
   whose correction is larger than it should be may have jumped to another path: it is halved and tried again.
3. The next step follows from the correction of the last: its error grows with the sixth power of the step.
4. A path ends at t = 1; or it is lost: poses grow without bound, or steps become too short because paths meet.

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

LARGEST = 1e7
"""Poses whose numbers grow beyond it (lengths over the size) run to infinity."""
SHORTEST = 1e-9
"""Steps below it are not taken: two paths meet there."""
NEARLY = 1e-4
"""Paths that meet this near to the end have met at the end, in a pose that is singular there."""
FIRST = 0.01
"""First step."""
ENDED = 1e-6
"""Corrections below it are the last: the next would be their square."""
EXACT = 1e-13
"""The same at the end of a path: a double pose comes nearer by half with each."""
STEPS = 3
LAST_STEPS = 60
"""Most corrections on the way and at the end."""


@uncounted
def at(t: float, start: Any, dg: Any, g: Any) -> None:
    """G (6, 7) <- start + t dg, the geometry at t."""
    for i in range(6):
        for j in range(7):
            g[i, j] = start[i, j] + t * dg[i, j]


@uncounted
def predicted(times: Any, poses: Any, rates: Any, known: int, t: float, out: Any) -> None:
    """Out (7,) <- the polynomial through poses and their rates at the last times (Hermite), taken at t.

    Args:
        times: (3,); poses, rates: (3, 7): the newest last.
        known: how many of them, from the end.
        t: where.
        out: set.
    """
    for j in range(7):
        out[j] = 0.0
    for a in range(3 - known, 3):
        basis, slope = 1.0, 0.0
        for c in range(3 - known, 3):
            if c != a:
                basis *= (t - times[c]) / (times[a] - times[c])
                slope += 1.0 / (times[a] - times[c])
        past = t - times[a]
        of_pose, of_rate = (1.0 - 2.0 * past * slope) * basis * basis, past * basis * basis
        for j in range(7):
            out[j] += of_pose * poses[a, j] + of_rate * rates[a, j]


@uncounted
def corrected(x: Any, g: Any, dg: Any, R: Any, d: Any, M: Any, r: Any, rate: Any, most: float, ended: float) -> float:
    """Newton's method on the pose x (7,) at geometry g, and its rate by t from the last of the matrices.

    1. One matrix and two right sides: what the legs miss, and how fast they do along t.
    2. A first correction that is too large, or a singular matrix, ends it: another path may be nearer.
    3. The corrected pose and the rate there; done when the correction is nearly rounding.

    Args:
        x: pose, corrected.
        g, dg: (6, 7) ends on the base, on the platform, squares of lengths, and their derivatives by t.
        R, d, M, r: work.
        rate: (7,) set to dx/dt.
        most: largest first correction.
        ended: size of the last.

    Returns:
        The first correction over the size of the pose; infinite if the corrections did not end.
    """
    first = -1.0
    for _ in range(LAST_STEPS if ended < ENDED else STEPS):
        # 1.
        legs(x, g[:, 0:3], g[:, 3:6], g[:, 6], R, d, M, r)
        for i in range(6):
            u, v, w = dg[i, 3], dg[i, 4], dg[i, 5]
            r[i, 1] = (
                0.5 * dg[i, 6]
                - d[i, 0] * (R[0] * u + R[1] * v + R[2] * w - dg[i, 0])
                - d[i, 1] * (R[3] * u + R[4] * v + R[5] * w - dg[i, 1])
                - d[i, 2] * (R[6] * u + R[7] * v + R[8] * w - dg[i, 2])
            )
            r[i, 0] = -r[i, 0]
        # 2.
        if solved(M, r) == 0.0:
            return np.inf
        size, scale = 0.0, 1.0
        for i in range(6):
            size = max(size, abs(r[i, 0].real) + abs(r[i, 0].imag))
        for j in range(7):
            scale = max(scale, abs(x[j].real) + abs(x[j].imag))
        if first < 0.0:
            first = size / scale
            if not first <= most:
                return np.inf
        # 3.
        rates_of(x, r[:, 0], rate)
        for j in range(7):
            x[j] += rate[j]
        of_norm_one(x)
        rates_of(x, r[:, 1], rate)
        if size <= ended * scale:
            return first
    return np.inf


@uncounted
def follow(
    x: Any, start: Any, dg: Any, g: Any, times: Any, poses: Any, rates: Any, y: Any, rate: Any,
    R: Any, d: Any, M: Any, r: Any, most: float,
) -> int:  # fmt: skip
    """The pose x (7,) from t = 0 to t = 1; how it ended. Work arrays as in `follow_all`."""
    at(0.0, start, dg, g)
    corrected(x, g, dg, R, d, M, r, rate, np.inf, EXACT)
    for j in range(7):
        poses[2, j], rates[2, j] = x[j], rate[j]
    times[2] = 0.0
    t, step, known = 0.0, FIRST, 1
    while t < 1.0:
        h = min(step, 1.0 - t)
        # 1.
        predicted(times, poses, rates, known, t + h, y)
        of_norm_one(y)
        # 2.
        at(t + h, start, dg, g)
        change = corrected(y, g, dg, R, d, M, r, rate, most, ENDED)
        # 3.
        if change <= most:
            t += h
            size = 0.0
            for k in range(2):
                times[k] = times[k + 1]
                for j in range(7):
                    poses[k, j], rates[k, j] = poses[k + 1, j], rates[k + 1, j]
            times[2] = t
            for j in range(7):
                x[j] = y[j]
                poses[2, j], rates[2, j] = y[j], rate[j]
                size = max(size, abs(x[j].real) + abs(x[j].imag))
            if not size < LARGEST:
                return UNBOUNDED
            growth = 2.0 if change <= 0.0 else 0.8 * (most / change) ** (0.25 if known == 2 else 1.0 / 6.0)
            step = h * min(max(growth, 0.5), 2.0)
            known = min(known + 1, 3)
        else:
            step = 0.5 * h
            if step < SHORTEST:
                near = 1.0 - t < NEARLY
                if near:
                    at(1.0, start, dg, g)
                    corrected(x, g, dg, R, d, M, r, rate, np.inf, EXACT)
                return MERGED if near else STUCK
    at(1.0, start, dg, g)
    corrected(x, g, dg, R, d, M, r, rate, np.inf, EXACT)
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
    dg, g, d = np.empty((6, 7), np.complex128), np.empty((6, 7), np.complex128), np.empty((6, 3), np.complex128)
    times, was, rates = np.empty(3), np.empty((3, 7), np.complex128), np.empty((3, 7), np.complex128)
    y, rate, R = np.empty(7, np.complex128), np.empty(7, np.complex128), np.empty(9, np.complex128)
    M, r = np.empty((6, 6), np.complex128), np.empty((6, 2), np.complex128)
    for row in range(ends.shape[0]):
        for i in range(6):
            for j in range(7):
                dg[i, j] = ends[row, i, j] - start[i, j]
        for path in range(poses.shape[0]):
            x = out[row, path]
            for j in range(7):
                x[j] = poses[path, j]
            how[row, path] = follow(x, start, dg, g, times, was, rates, y, rate, R, d, M, r, most)


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
