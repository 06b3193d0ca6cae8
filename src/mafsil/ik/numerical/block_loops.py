"""Poses by one compiled call: cleaned, searched, wound, checked; what it leaves open is for those who can say why."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats, JointVector
from mafsil.ik.numerical.pose_loops import cleaned, met, wound
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
from mafsil.kernels.loop_compiler import Singles, Whole, address, run_kernel

ROTATION, POSITION, DISTANCE, ITERATIONS, ATTEMPTS, REACHED = 0, 1, 2, 3, 4, 5
"""Columns of the report: errors [rad, m], distance of the origin from the centre of the reach [m], steps, attempts;
what the check kernel gives: pose (16) and twist left (6); then joints (n)."""
CONFIGURATION = REACHED + 22


def block(
    plan: Floats,
    features: Singles,
    step: int,
    check: int,
    wanted: Floats,
    seeds: JointVector,
    seeded: int,
    poses: int,
    lanes: int,
    attempts: int,
    work: Floats,
    whole: Whole,
    report: Floats,
) -> int:
    """Search for poses.

    1. Poses are cleaned; those that are none, or out of reach, are not begun.
    2. The search, until every pose is solved or has used its attempts.
    3. Whole turns towards the start, or zero.
    4. Every answer is checked afresh; solved poses get whole numbers of steps and attempts, others -1 attempts.

    Args:
        plan: see `start_loops`.
        features: as for `nearest_cells`.
        step, check: addresses of the kernels.
        wanted: (poses, 16).
        seeds: (poses, n) starts of the user.
        seeded: 1 if there are any.
        poses: how many.
        lanes: how many; a multiple of GROUP, or one.
        attempts: how many are allowed.
        work: (16 poses + (n + 1) poses + n + (28 + 2 n) lanes).
        whole: (RECORD poses + LANE lanes + 3).
        report: (poses, CONFIGURATION + n) out.

    Returns:
        Number of solved poses.
    """
    n = int(plan[JOINTS])
    width = CONFIGURATION + n
    best, zeros, lane_work = work[16 * poses :], work[(17 + n) * poses :], work[(17 + n) * poses + n :]
    records, places, cursor = whole[0:], whole[RECORD * poses :], whole[RECORD * poses + LANE * lanes :]
    # 1.
    for row in range(poses):
        distance = cleaned(plan, wanted[16 * row :], work[16 * row :])
        report[width * row + DISTANCE] = distance
        record = records[RECORD * row :]
        record[STARTED], record[WINNER], record[STEPS] = 0, -1, 0
        record[ALLOWED] = attempts if 0.0 <= distance <= plan[RADIUS] else 0
        best[(n + 1) * row + n] = np.inf
        for i in range(n):
            best[(n + 1) * row + i] = 0.0
    # 2.
    cursor[QUEUE], cursor[ACTIVE], cursor[SIDE] = 0, 0, 0
    every = 1 << 40
    advance(
        plan,
        features,
        step,
        every,
        TRUSTED,
        work,
        seeds,
        seeded,
        poses,
        lanes,
        lane_work,
        places,
        best,
        records,
        cursor,
    )
    # 3.
    for i in range(n):
        zeros[i] = 0.0
    for row in range(poses):
        wound(plan, best[(n + 1) * row :], seeds[n * row :] if seeded == 1 else zeros)
    # 4.
    arguments, strides, rows = np.empty(4, np.int64), np.empty(9, np.int64), np.empty(1, np.int64)
    arguments[0], arguments[1], arguments[2] = address(best), address(work), address(plan[TASK:])
    arguments[3], rows[0] = address(report[REACHED:]), poses
    strides[0], strides[1], strides[2], strides[3] = 8 * (n + 1), 128, 0, 8 * width
    strides[4], strides[5], strides[6], strides[7], strides[8] = 8, 32, 8, 8, 8
    run_kernel(check, arguments, rows, strides)
    solved = 0
    for row in range(poses):
        line, q = report[width * row :], best[(n + 1) * row :]
        fine = met(plan, q, line[REACHED + 16 :], line) and records[RECORD * row + WINNER] >= 0
        solved += 1 if fine else 0
        line[ITERATIONS] = float(records[RECORD * row + STEPS])
        line[ATTEMPTS] = float(records[RECORD * row + STARTED]) if fine else -1.0
        for i in range(n):
            line[CONFIGURATION + i] = q[i]
    return solved
