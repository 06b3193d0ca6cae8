"""Platforms on six legs, compiled: all poses of given lengths by continuation from a platform whose poses are known.

Geometry and squares of lengths move on a straight line, t in [0, 1], from a complex start to what is wanted. Eight
poses of the start are followed side by side, each at its own t and to its own end; a lane whose path has ended takes
the next one. In every turn of the loop all lanes do the same:

1. Newton's method takes one step at t, (|d|^2 - s^2) / 2 = 0, and the rate along t follows from the same matrix. A
   path whose first correction is larger than it should be may have jumped to another: its step is halved.
2. Where the correction is small the pose is kept, and the next step follows from the first correction: the error of
   the predictor grows with the eighth power of the step.
3. Predictor: the polynomial through the last four poses and their rates, extrapolated.
4. A path ends at t = 1; or it is lost: poses grow without bound, or steps become too short because paths meet.

Reference: Sommese and Wampler, The Numerical Solution of Systems of Polynomials, 2005, ch. 2 and 7 (parameter
continuation: a general start has as many poses as any platform can have isolated ones).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mafsil.kernels.loops.lanes import (
    WIDTH,
    any_lane,
    get,
    in_lanes,
    lane_bits,
    lanes,
    part,
    put,
    seen,
    square_root,
    where,
)
from mafsil.kernels.loops.loop import compiled, inlined
from mafsil.parallel.platforms.complex_lane_loops import extent, number, solve_in_lanes
from mafsil.parallel.platforms.path_loops import LARGEST, finish
from mafsil.parallel.platforms.stewart_loops import legs_in_lanes, norm_one_in_lanes, rates_in_lanes

if TYPE_CHECKING:
    from mafsil.kernels.loops.lanes import Buffer, Lanes, Mask

ARRIVED, MERGED, UNBOUNDED, STUCK = 0, 1, 2, 3
"""How a path ended: at t = 1; where it meets another, at the end; at infinity; or where it cannot go on."""
SHORTEST = 1e-9
"""Steps below it are not taken: two paths meet there."""
NEARLY = 1e-4
"""Paths that meet this near to the end have met at the end, in a pose that is singular there."""
FIRST = 0.01
"""First step."""
ENDED = 1e-6
"""Corrections below it, over the pose, are the last on the way: the next would be their square."""
CORRECTIONS = 3
"""Most of one step."""
KNOWN = 4
"""Poses that the predictor knows."""
LONG_AGO = -1e30
"""Time of poses before the first: the polynomial does not see them."""

POSE, RATE = 14, 14
"""Places of seven complex numbers."""
Y = 0
WAS = Y + POSE
RATES = WAS + KNOWN * POSE
TIMES = RATES + KNOWN * RATE
MOVES = TIMES + KNOWN
NOW = MOVES + 84
STEP = NOW + 1
COUNT = STEP + 1
CHANGE = COUNT + 1
R = CHANGE + 1
M = R + 18
SPEED = M + 96
PLACES = SPEED + RATE
"""Where a lane keeps: the pose at hand, the last poses, their rates and times, how its geometry moves along t; the
time at hand, the step, corrections made, the first of them; and work."""


@inlined
def _most(a: Lanes, b: Lanes) -> Lanes:
    return where(b > a, b, a)


@compiled
def predict_in_lanes(w: Buffer, due: Mask) -> None:
    """The pose at hand <- the polynomial through the last poses and their rates (Hermite) at the time at hand.

    Args:
        w: work of the lanes.
        due: lanes that ask for it.
    """
    t, was, rates, x, y = w[NOW], part(w, WAS), part(w, RATES), part(w, R), part(w, Y)
    for j in range(POSE):
        x[j] = 0.0
    for a in range(KNOWN):
        own = w[TIMES + a]
        past = t - own
        basis, slope = lanes(1.0), lanes(0.0)
        for c in range(KNOWN):
            if c != a:
                over = 1.0 / (own - w[TIMES + c])
                basis = basis * (t - w[TIMES + c]) * over
                slope = slope + over
        square = basis * basis
        of_pose, of_rate = (1.0 - 2.0 * past * slope) * square, past * square
        for j in range(POSE):
            x[j] = x[j] + of_pose * was[POSE * a + j] + of_rate * rates[POSE * a + j]
    norm_one_in_lanes(x)
    for j in range(POSE):
        y[j] = where(due, x[j], y[j])


@compiled
def correct_in_lanes(start: Any, w: Buffer) -> tuple[Lanes, Lanes]:
    """One step of Newton's method for the poses at hand, and their rates; sizes of corrections and of poses."""
    x, m, rate = part(w, Y), part(w, M), part(w, SPEED)
    legs_in_lanes(x, start, part(w, MOVES), w[NOW], part(w, R), m)
    solve_in_lanes(m)
    rates_in_lanes(x, m, 6, rate)
    size, scale = extent(number(m, 6)), lanes(1.0)
    for i in range(1, 6):
        size = _most(size, extent(number(m, 8 * i + 6)))
    for j in range(7):
        scale = _most(scale, extent(number(x, j)))
    for j in range(POSE):
        x[j] = x[j] + rate[j]
    norm_one_in_lanes(x)
    rates_in_lanes(x, m, 7, rate)
    return size, scale


@compiled
def turn(start: Any, w: Buffer, most: float) -> tuple[int, int, int]:
    """One step of Newton's method in all lanes, and what follows from it: bits of lanes that arrived, grew, or stuck.

    1. The correction; the first of a step is judged.
    2. Kept: the pose joins the last ones. Failed: half the step.
    3. The next time, and the predictor there.

    Args:
        start: (6, 14) geometry at t = 0.
        w: work of the lanes.
        most: largest share of a pose that a first correction may move.
    """
    # 1.
    size, scale = correct_in_lanes(start, w)
    count, begun = w[COUNT], _most(w[TIMES + KNOWN - 1], lanes(0.0))
    change = where(count == 0.0, size / scale, w[CHANGE])
    near = change <= most
    kept = near & (size <= ENDED * scale)
    failed = ~near | (~kept & (count >= CORRECTIONS - 1.0))
    due = kept | failed
    w[CHANGE], w[COUNT] = change, where(due, 0.0, count + 1.0)
    if not any_lane(due):
        return 0, 0, 0
    # 2.
    growth = 0.8 * square_root(square_root(square_root(most / where(change > 1e-30, change, 1e-30))))
    growth = where(growth > 2.0, 2.0, where(growth > 0.5, growth, 0.5))
    taken, step = w[NOW] - begun, w[STEP]
    w[STEP] = where(kept, where(taken > 0.0, taken * growth, step), where(failed, 0.5 * taken, step))
    _shift(w, kept)
    arrived = kept & (w[NOW] >= 1.0)
    grown = kept & ~(scale < LARGEST)
    stuck = failed & ~(w[STEP] >= SHORTEST)
    # 3.
    begun = w[TIMES + KNOWN - 1]
    w[NOW] = where(due, where(w[STEP] >= 1.0 - begun, 1.0, begun + w[STEP]), w[NOW])
    predict_in_lanes(w, due)
    return lane_bits(arrived), lane_bits(grown), lane_bits(stuck)


@inlined
def _shift(w: Buffer, kept: Mask) -> None:
    """The pose at hand joins the last ones, in some lanes."""
    for k in range(KNOWN):
        w[TIMES + k] = where(kept, w[NOW] if k == KNOWN - 1 else w[TIMES + k + 1], w[TIMES + k])
        for j in range(POSE):
            pose, rate = WAS + POSE * k + j, RATES + POSE * k + j
            last = k == KNOWN - 1
            w[pose] = where(kept, w[Y + j] if last else w[pose + POSE], w[pose])
            w[rate] = where(kept, w[SPEED + j] if last else w[rate + POSE], w[rate])


@inlined
def _begin(w: Buffer, lane: int, start: Any, end: Any, pose: Any) -> None:
    """A lane takes a path: geometry from start to end (6, 14), and the pose (14,) at t = 0."""
    for i in range(6):
        for j in range(14):
            put(w, MOVES + 14 * i + j, lane, end[i, j] - start[i, j])
    for j in range(KNOWN * POSE):
        put(w, WAS + j, lane, 0.0)
        put(w, RATES + j, lane, 0.0)
    for k in range(KNOWN):
        put(w, TIMES + k, lane, (KNOWN - k) * LONG_AGO)
    for j in range(POSE):
        put(w, Y + j, lane, pose[j])
    put(w, NOW, lane, 0.0)
    put(w, STEP, lane, FIRST)
    put(w, COUNT, lane, 0.0)


@inlined
def _last(w: Buffer, lane: int, x: Any) -> None:
    """The last pose of a lane that was kept."""
    for j in range(7):
        place = WAS + POSE * (KNOWN - 1) + 2 * j
        x[j] = complex(get(w, place, lane), get(w, place + 1, lane))


@inlined
def _how(w: Buffer, lane: int, grown: bool, stuck: bool) -> int:
    """How the path of a lane ended."""
    if stuck:
        return MERGED if 1.0 - get(w, TIMES + KNOWN - 1, lane) < NEARLY else STUCK
    return UNBOUNDED if grown else ARRIVED


@compiled
def follow_all(start: Any, ends: Any, poses: Any, most: float, out: Any, how: NDArray[np.int8]) -> None:
    """All poses of a start followed to many ends.

    1. Every lane takes a path; each end has as many as the start has poses.
    2. Lanes take turns until some of them have ended; what they found is made exact.
    3. Such a lane takes the next path; without one it goes on unheeded until all have ended.

    Args:
        start: (6, 7) complex: ends on the base, on the platform, squares of lengths.
        ends: (k, 6, 7) the same of the ends.
        poses: (m, 7) poses of the start.
        most: largest share of a pose that a corrector may move.
        out: (k, m, 7) set to the poses of the ends.
        how: (k, m) set to how each path ended.
    """
    # Its owner is counted, so it has to be named wherever it is used: after the last of these it is freed.
    work, paths = in_lanes(PLACES), np.full(WIDTH, -1, np.int64)
    begins, finals, known = start.view(np.float64), ends.view(np.float64), poses.view(np.float64)
    R9, d, M6 = np.empty(9, np.complex128), np.empty((6, 3), np.complex128), np.empty((6, 6), np.complex128)
    miss, rate = np.empty((6, 1), np.complex128), np.empty(7, np.complex128)
    per, given, busy = len(poses), 0, 0
    total = len(ends) * per
    # 1.
    for lane in range(WIDTH if total else 0):
        # Lanes without a path of their own follow one that another has.
        path = min(lane, total - 1)
        _begin(seen(work), lane, begins, finals[path // per], known[path % per])
        if lane < total:
            paths[lane], given, busy = lane, given + 1, busy + 1
    while busy > 0:
        # 2.
        arrived, grown, stuck = turn(begins, seen(work), most)
        ended = arrived | grown | stuck
        for lane in range(WIDTH if ended else 0):
            path = paths[lane]
            if not (ended >> lane) & 1 or path < 0:
                continue
            row, column = path // per, path % per
            _last(seen(work), lane, out[row, column])
            how[row, column] = _how(seen(work), lane, (grown >> lane) & 1 == 1, (stuck >> lane) & 1 == 1)
            if how[row, column] <= MERGED:
                finish(out[row, column], ends[row], R9, d, M6, miss, rate)
            # 3.
            if given < total:
                _begin(seen(work), lane, begins, finals[given // per], known[given % per])
                paths[lane], given = given, given + 1
            else:
                paths[lane], busy = -1, busy - 1
