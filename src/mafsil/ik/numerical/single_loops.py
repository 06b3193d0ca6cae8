"""One pose by one compiled call: cleaned, searched, wound, checked; for a single call costs more than its search."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats
from mafsil.ik.numerical.pose_loops import clean, verdict, wind
from mafsil.ik.numerical.search_loops import (
    ACTIVE,
    ALLOWED,
    QUEUE,
    RECORD,
    SIDE,
    STARTED,
    STEPS,
    TRUSTED,
    WINNER,
    advance,
)
from mafsil.ik.numerical.start_loops import JOINTS, LANE, RADIUS, TASK
from mafsil.kernels.loop_compiler import Singles, address, run_kernel

WANTED, REPORT = 0, 16
"""Places of the work: the wanted pose (16), the report, the start of the user (n), what the search needs."""
ROTATION, POSITION, DISTANCE, ITERATIONS, ATTEMPTS, REACHED = 0, 1, 2, 3, 4, 5
"""Places of the report: errors [rad, m], distance of the origin from the centre of the reach [m], steps, attempts; what
the check kernel gives: pose (16) and twist left (6); then joints (n) and zero."""
JOINTS_FOUND = REACHED + 22


def single(plan: Floats, features: Singles, step: int, check: int, work: Floats, attempts: int, seeded: int) -> bool:
    """Search for one pose.

    1. The pose is cleaned; one that is none, or out of reach, is left to the general way.
    2. The search.
    3. Whole turns towards the start, or zero.
    4. The answer is checked afresh.

    Args:
        plan: see `start_loops`.
        features: as for `nearest_cells`.
        step, check: addresses of the kernels.
        work: (16 + 28 + 5 n + 46) see WANTED, ROTATION.
        attempts: how many are allowed.
        seeded: 1 if the user gave a start.

    Returns:
        Whether it was solved; if not, nothing of the report is to be used.
    """
    n = int(plan[JOINTS])
    report = work[REPORT:]
    best, seed = report[JOINTS_FOUND:], report[JOINTS_FOUND + 1 + n :]
    target, lanes = seed[n:], seed[n + 16 :]
    # 1.
    valid, good = np.empty(1, np.int64), np.empty(1, np.int64)
    clean(plan, work, 1, target, valid, report[DISTANCE:])
    if valid[0] == 0 or report[DISTANCE] > plan[RADIUS]:
        return False
    # 2.
    places, record, cursor = np.empty(LANE, np.int64), np.empty(RECORD, np.int64), np.empty(3, np.int64)
    record[STARTED], record[ALLOWED], record[WINNER], record[STEPS] = 0, attempts, -1, 0
    cursor[QUEUE], cursor[ACTIVE], cursor[SIDE] = 0, 0, 0
    best[n] = np.inf
    advance(plan, features, step, 1 << 40, TRUSTED, target, seed, seeded, 1, 1, lanes, places, best, record, cursor)
    # 3.
    if seeded == 0:
        for i in range(n):
            seed[i] = 0.0
    wind(plan, 1, best, seed, 1)
    # 4.
    arguments, strides, rows = np.empty(4, np.int64), np.empty(9, np.int64), np.empty(1, np.int64)
    arguments[0], arguments[1], arguments[2] = address(best), address(target), address(plan[TASK:])
    arguments[3], rows[0] = address(report[REACHED:]), 1
    strides[0], strides[1], strides[2], strides[3] = 0, 0, 0, 0
    strides[4], strides[5], strides[6], strides[7], strides[8] = 8, 32, 8, 8, 8
    run_kernel(check, arguments, rows, strides)
    verdict(plan, 1, report[REACHED:], best, report[ROTATION:], report[POSITION:], good)
    report[ITERATIONS], report[ATTEMPTS] = float(record[STEPS]), float(record[STARTED])
    return good[0] == 1
