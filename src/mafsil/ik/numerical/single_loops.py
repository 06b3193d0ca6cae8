"""One pose by one compiled call: cleaned, searched, wound, checked; for a single call costs more than its search."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats, JointVector
from mafsil.ik.numerical.search_loops import (
    ALLOWED,
    RECORD,
    STARTED,
    STEPS,
    WINNER,
    Singles,
    Whole,
    advance,
    clean,
    judge,
    wind,
)
from mafsil.solvers.kernel_loops import call_kernel
from mafsil.solvers.loops import compiled

ROTATION, POSITION, DISTANCE, REACHED = 0, 1, 2, 3
"""Places of the report: errors [rad, m], distance of the origin from the centre of the reach, then what the check
kernel gives: pose (16) and twist left (6)."""
REPORT = REACHED + 22


@compiled
def single(
    step: int,
    check: int,
    attempts: int,
    limit: float,
    radius: float,
    centre: Floats,
    numbers: Floats,
    task: Floats,
    turning: Whole,
    wanted: Floats,
    first: JointVector,
    samples: JointVector,
    features: Singles,
    centres: Singles,
    begins: Whole,
    best: Floats,
    report: Floats,
    counts: Whole,
) -> bool:
    """Search for one pose.

    Args:
        step, check: addresses of the kernels.
        attempts: how many are allowed.
        limit, centre: as for `clean`.
        radius: of the reach; infinite where it does not matter.
        numbers, task, samples, features, centres, begins: as for `advance`.
        turning: as for `wind`.
        wanted: (1, 16) pose.
        first: (1, n) start of the user, or (0, n).
        best: (1, n + 1) out.
        report: (REPORT) out.
        counts: (2) steps and attempts, out.

    Returns:
        Whether it was solved; if not, nothing else is to be used.
    """
    n = samples.shape[1]
    target, valid = np.empty((1, 16)), np.empty(1, np.int64)
    clean(wanted, limit, centre, target, valid, report[DISTANCE:REACHED])
    if valid[0] == 0 or report[DISTANCE] > radius:
        return False
    best[0, n] = np.inf
    records = np.zeros((1, RECORD), np.int64)
    records[0, ALLOWED], records[0, WINNER] = attempts, -1
    real, whole, cursor = np.empty((1, 2 * n + 6)), np.empty((1, 2), np.int64), np.zeros(2, np.int64)
    every = 1 << 40
    advance(
        step,
        every,
        numbers,
        task,
        target,
        first,
        samples,
        features,
        centres,
        begins,
        real,
        whole,
        best,
        records,
        cursor,
    )
    wind(best, first if first.shape[0] > 0 else np.zeros((1, n)), turning, task)
    addresses = np.empty(4, np.uintp)
    addresses[0], addresses[1], addresses[2] = best.ctypes.data, target.ctypes.data, task.ctypes.data
    addresses[3] = report.ctypes.data + np.uintp(8 * REACHED)
    strides, dimensions = np.array([0, 0, 0, 0, 8, 32, 8, 8, 8], np.int64), np.ones(1, np.int64)
    call_kernel(check, addresses.ctypes.data, dimensions.ctypes.data, strides.ctypes.data)
    counts[0], counts[1] = records[0, STEPS], records[0, STARTED]
    good = np.empty(1, np.int64)
    checked = report[REACHED:].reshape((1, 22))
    judge(checked, best, numbers, task, report[ROTATION:POSITION], report[POSITION:DISTANCE], good)
    return good[0] == 1
