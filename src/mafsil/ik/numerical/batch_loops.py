"""Poses by one compiled call: repaired, searched, wound, checked; what it leaves open the full search explains."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats, JointVector
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
    Whole,
)
from mafsil.ik.numerical.search_loops import TRUSTED, advance, ports
from mafsil.ik.result import FARTHEST
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


@compiled
def clean_pose(plan: Plan, given: Floats, made: Floats) -> float:
    """A pose with its rotation brought to working precision; identity where it is none.

    1. A pose has finite numbers, the last row (0, 0, 0, 1) and a rotation, all up to the plan's `defect`.
    2. Newton's iteration for the polar factor, R - R (R'R - I) / 2, twice: the defect is squared each time.

    Args:
        plan: of the search.
        given: (16) what a user gave.
        made: (16) out.

    Returns:
        Distance of the origin from the centre of the reach; -1 where it is no pose.
    """
    R, S = np.empty(9), np.empty(9)
    # 1.
    good = True
    for i in range(16):
        made[i] = 1.0 if i % 5 == 0 else 0.0
        good = good and abs(given[i]) < FARTHEST
        if i >= 12:
            good = good and abs(given[i] - made[i]) <= plan.defect
    for i in range(3):
        for j in range(3):
            R[3 * i + j] = given[4 * i + j]
    if not good or not defect(R, S) <= plan.defect or not determinant(R) > 0.0:
        return -1.0
    # 2.
    for repeat in range(2):
        if repeat > 0:
            defect(R, S)
        for i in range(3):
            a, b, c = R[3 * i], R[3 * i + 1], R[3 * i + 2]
            for j in range(3):
                R[3 * i + j] -= 0.5 * (a * S[j] + b * S[3 + j] + c * S[6 + j])
    square = 0.0
    for i in range(3):
        made[4 * i + 3] = given[4 * i + 3]
        square += (made[4 * i + 3] - plan.centre[i]) ** 2
        for j in range(3):
            made[4 * i + j] = R[3 * i + j]
    return np.sqrt(square)


@compiled
def clean(held: Held[Plan], T: Floats, out: Floats, distance: Floats) -> None:
    """As `clean_pose`, of many poses.

    Args:
        held: the plan of the search.
        T: (poses, 16).
        out: (poses, 16).
        distance: (poses) of the origin from the centre of the reach, -1 for rows that are no poses, out.
    """
    plan = open_held(held)
    for row in range(len(T)):
        distance[row] = clean_pose(plan, T[row], out[row])


@compiled
def defect(R: Floats, S: Floats) -> float:
    """Largest element of S = R'R - I.

    Args:
        R: (9) matrix.
        S: (9) out.
    """
    worst = 0.0
    for i in range(3):
        for j in range(3):
            one = 1.0 if i == j else 0.0
            S[3 * i + j] = R[i] * R[j] + R[3 + i] * R[3 + j] + R[6 + i] * R[6 + j] - one
            worst = max(worst, abs(S[3 * i + j]))
    return worst


@compiled
def determinant(R: Floats) -> float:
    """Of a matrix (9)."""
    return R[0] * (R[4] * R[8] - R[5] * R[7]) - R[1] * (R[3] * R[8] - R[5] * R[6]) + R[2] * (R[3] * R[7] - R[4] * R[6])


@compiled
def wind_one(plan: Plan, q: JointVector, q0: JointVector) -> None:
    """Move revolute joints by whole turns as close to an initial guess as their bounds allow.

    Args:
        plan: of the search.
        q: (n) changed.
        q0: (n).
    """
    for i in range(len(plan.lower)):
        if plan.revolute[i] > 0:
            moved = q[i] - 2.0 * np.pi * np.rint((q[i] - q0[i]) / (2.0 * np.pi))
            if moved >= plan.lower[i] and moved <= plan.upper[i]:
                q[i] = moved


@compiled
def wind(held: Held[Plan], q: Floats, q0: JointVector) -> None:
    """As `wind_one`, of many configurations.

    Args:
        held: the plan of the search.
        q: (poses, n + 1) configurations, changed.
        q0: (poses, n), or (1, n) for all.
    """
    plan = open_held(held)
    for row in range(len(q)):
        wind_one(plan, q[row], q0[row if len(q0) > 1 else 0])


@compiled
def met(plan: Plan, q: JointVector, twist: Floats, errors: Floats) -> bool:
    """Whether a configuration meets tolerances and bounds.

    Args:
        plan: of the search.
        q: (n).
        twist: (6) that is left, by the check kernel.
        errors: (2) of rotation and position [rad, m], as far as they count, out.
    """
    rotation = position = 0.0
    for i in range(3):
        if plan.weights[i] > 0.0:
            rotation += twist[i] ** 2
        if plan.weights[3 + i] > 0.0:
            position += twist[3 + i] ** 2
    errors[0], errors[1] = np.sqrt(rotation), np.sqrt(position)
    # The search aims at half the tolerances, whose squares the plan holds.
    good = rotation <= 4.0 * plan.rotation_limit and position <= 4.0 * plan.position_limit
    for i in range(len(plan.lower)):
        good = good and q[i] >= plan.lower[i] and q[i] <= plan.upper[i]
    return good


@compiled
def check(held: Held[Plan], checked: Floats, q: Floats, errors: Floats, good: Whole) -> None:
    """As `met`, of many configurations.

    Args:
        held: the plan of the search.
        checked: (poses, 22) pose and twist that is left, by the check kernel.
        q: (poses, n + 1) configurations.
        errors: (poses, 2) of rotation and position [rad, m], out.
        good: (poses) 1 where tolerances and bounds are met, out.
    """
    plan = open_held(held)
    for row in range(len(q)):
        good[row] = 1 if met(plan, q[row], checked[row, TWIST - REACHED :], errors[row]) else 0
