"""Poses by one compiled call: cleaned, searched, wound, checked; what it leaves open the full search explains."""

from __future__ import annotations

import numpy as np

from mafsil.ik.numerical.pose_loops import clean_pose, met, wind_one
from mafsil.ik.numerical.records import CONFIGURATION, DISTANCE, REACHED, TWIST, Batch
from mafsil.ik.numerical.search_loops import TRUSTED, advance, ports
from mafsil.kernels.loop_compiler import address, run_kernel

EVERY = 1 << 40
"""Rounds that no search needs."""


def solve_batch(batch: Batch) -> int:
    """Search for poses.

    1. Poses are cleaned; those that are none, or out of reach, are not begun.
    2. The search, until every pose is solved or has used its attempts.
    3. Whole turns towards the initial guess, or zero.
    4. Every answer is checked afresh; a pose whose answer fails has no winner.

    Args:
        batch: the poses and all memory.

    Returns:
        Number of solved poses.
    """
    search = batch.search
    plan, poses = search.plan, search.poses
    n = plan.joints
    width = CONFIGURATION + n
    # 1.
    for row in range(poses):
        distance = clean_pose(plan, batch.given[16 * row :], search.desired[16 * row :])
        batch.report[width * row + DISTANCE] = distance
        record = search.record[row]
        record.begun, record.winner, record.steps = 0, -1, 0
        record.allowed = batch.allowed if 0.0 <= distance <= plan.radius else 0
        search.q[(n + 1) * row + n] = np.inf
        for i in range(n):
            search.q[(n + 1) * row + i] = 0.0
    # 2.
    search.next_pose, search.active, search.half, search.rounds, search.mode = 0, 0, 0, EVERY, TRUSTED
    advance(search)
    # 3.
    for i in range(n):
        batch.zeros[i] = 0.0
    for row in range(poses):
        wind_one(plan, search.q[(n + 1) * row :], search.q0[n * row :] if search.guessed == 1 else batch.zeros)
    # 4.
    arguments, strides, rows = np.empty(4, np.int64), np.empty(9, np.int64), np.empty(1, np.int64)
    ports(search.desired, plan.task, 8 * (n + 1), 8 * width, arguments, strides)
    arguments[0], arguments[3], rows[0] = address(search.q), address(batch.report[REACHED:]), poses
    run_kernel(batch.check, arguments, rows, strides)
    solved = 0
    for row in range(poses):
        line, q, record = batch.report[width * row :], search.q[(n + 1) * row :], search.record[row]
        if not met(plan, q, line[TWIST:], line):
            record.winner = -1
        solved += 1 if record.winner >= 0 else 0
        for i in range(n):
            line[CONFIGURATION + i] = q[i]
    return solved
