"""Poses by one compiled call: cleaned, searched, wound, checked; what it leaves open the full search explains."""

from __future__ import annotations

import numpy as np

from mafsil.ik.numerical.pose_loops import clean_pose, met, wind_one
from mafsil.ik.numerical.records import (
    ALLOWED,
    BEGUN,
    CONFIGURATION,
    DISTANCE,
    REACHED,
    STEPS,
    TWIST,
    WINNER,
    Batch,
    Plan,
    Search,
)
from mafsil.ik.numerical.search_loops import TRUSTED, advance, ports
from mafsil.kernels.loops import Held, compiled, open_held
from mafsil.kernels.loops.lanes import address, call_kernel

EVERY = 1 << 40
"""Rounds that no search needs."""


@compiled
def solve_batch(held: Held[Batch], allowed: int) -> int:
    """Search for poses.

    1. Poses are cleaned; those that are none, or out of reach, are not begun.
    2. The search, until every pose is solved or has used its attempts.
    3. Whole turns towards the initial guess, or zero.
    4. Every answer is checked afresh; a pose whose answer fails has no winner.

    Args:
        held: the poses and all memory.
        allowed: attempts of each pose.

    Returns:
        Number of solved poses.
    """
    batch = open_held(held)
    plan, search, report = batch.plan, batch.search, batch.report
    # 1.
    for row in range(len(report)):
        distance = clean_pose(plan, batch.given[row], search.desired[row])
        report[row, DISTANCE] = distance
        attempts = search.attempts[row]
        attempts[BEGUN], attempts[WINNER], attempts[STEPS] = 0, -1, 0
        attempts[ALLOWED] = allowed if 0.0 <= distance <= plan.radius else 0
        search.q[row, :] = 0.0
        search.q[row, len(plan.lower)] = np.inf
    # 2.
    search.progress[:] = 0
    advance(plan, search, EVERY, TRUSTED)
    # 3.
    for row in range(len(report)):
        wind_one(plan, search.q[row], search.q0[row] if len(search.q0) > 0 else batch.zeros)
    # 4.
    return _check(batch)


@compiled
def _check(batch: Batch) -> int:
    """Number of poses whose configurations meet tolerances and bounds; the report of all."""
    plan, search, report = batch.plan, batch.search, batch.report
    n = len(plan.lower)
    arguments, strides, rows = np.empty(4, np.int64), np.empty(9, np.int64), np.empty(1, np.int64)
    ports(search.desired, plan.task, 8 * (n + 1), 8 * (CONFIGURATION + n), arguments, strides)
    arguments[0], arguments[3], rows[0] = address(search.q), address(report) + 8 * REACHED, len(report)
    call_kernel(batch.check, address(arguments), address(rows), address(strides))
    solved = 0
    for row in range(len(report)):
        line, q = report[row], search.q[row]
        if not met(plan, q, line[TWIST:], line):
            search.attempts[row, WINNER] = -1
        solved += 1 if search.attempts[row, WINNER] >= 0 else 0
        for i in range(n):
            line[CONFIGURATION + i] = q[i]
    return solved


@compiled
def resume(plan: Held[Plan], search: Held[Search], rounds: int, mode: int) -> int:
    """`advance`, for Python.

    Args:
        plan, search, rounds, mode: as there.
    """
    return advance(open_held(plan), open_held(search), rounds, mode)
