"""Poses before the search and answers after it, compiled: repair of rotations, whole turns, the check's verdict."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats, JointVector
from mafsil.ik.numerical.start_loops import CENTRE, DEFECT, JOINTS, SHIFT_LIMIT, TASK, TURN_LIMIT
from mafsil.kernels.loop_compiler import Whole

FARTHEST = 1e100
"""As `ik.problem.FARTHEST`; written here since the key of the compiled code covers these files only."""


def cleaned(plan: Floats, given: Floats, made: Floats) -> float:
    """A pose with its rotation brought to working precision; identity where it is none.

    1. A pose has finite numbers, the last row (0, 0, 0, 1) and a rotation, all up to the plan's DEFECT.
    2. Newton's iteration for the polar factor, R - R (R'R - I) / 2, twice: the defect is squared each time.

    Args:
        plan: see `start_loops`.
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
            good = good and abs(given[i] - made[i]) <= plan[DEFECT]
    for i in range(3):
        for j in range(3):
            R[3 * i + j] = given[4 * i + j]
    if not good or not defect(R, S) <= plan[DEFECT] or not determinant(R) > 0.0:
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
        square += (made[4 * i + 3] - plan[CENTRE + i]) ** 2
        for j in range(3):
            made[4 * i + j] = R[3 * i + j]
    return np.sqrt(square)


def clean(plan: Floats, T: Floats, poses: int, out: Floats, distance: Floats) -> None:
    """As `cleaned`, of many poses.

    Args:
        plan: see `start_loops`.
        T: (poses, 16).
        poses: how many.
        out: (poses, 16).
        distance: (poses) of the origin from the centre of the reach, -1 for rows that are no poses, out.
    """
    for row in range(poses):
        distance[row] = cleaned(plan, T[16 * row :], out[16 * row :])


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


def determinant(R: Floats) -> float:
    """Of a matrix (9)."""
    return R[0] * (R[4] * R[8] - R[5] * R[7]) - R[1] * (R[3] * R[8] - R[5] * R[6]) + R[2] * (R[3] * R[7] - R[4] * R[6])


def wound(plan: Floats, q: JointVector, near: JointVector) -> None:
    """Turning joints moved by whole turns as close to `near` as their bounds allow.

    Args:
        plan: see `start_loops`.
        q: (n) changed.
        near: (n).
    """
    n = int(plan[JOINTS])
    task = plan[TASK:]
    for i in range(n):
        if task[9 + 2 * n + i] > 0.0:
            moved = q[i] - 2.0 * np.pi * np.rint((q[i] - near[i]) / (2.0 * np.pi))
            if moved >= task[9 + i] and moved <= task[9 + n + i]:
                q[i] = moved


def wind(plan: Floats, poses: int, best: Floats, near: JointVector, one: int) -> None:
    """As `wound`, of many configurations.

    Args:
        plan: see `start_loops`.
        poses: how many.
        best: (poses, n + 1) configurations, changed.
        near: (poses, n), or (1, n) for all.
        one: 1 if it is the same for all.
    """
    n = int(plan[JOINTS])
    for row in range(poses):
        wound(plan, best[(n + 1) * row :], near[n * row * (1 - one) :])


def met(plan: Floats, q: JointVector, twist: Floats, errors: Floats) -> bool:
    """Whether a configuration meets tolerances and bounds.

    Args:
        plan: see `start_loops`.
        q: (n).
        twist: (6) that is left, by the check kernel.
        errors: (2) of rotation and position [rad, m], as far as they count, out.
    """
    n = int(plan[JOINTS])
    task = plan[TASK:]
    turn = shift = 0.0
    for i in range(3):
        if task[i] > 0.0:
            turn += twist[i] ** 2
        if task[3 + i] > 0.0:
            shift += twist[3 + i] ** 2
    errors[0], errors[1] = np.sqrt(turn), np.sqrt(shift)
    # The search aims at half the tolerances, whose squares the plan holds.
    good = turn <= 4.0 * plan[TURN_LIMIT] and shift <= 4.0 * plan[SHIFT_LIMIT]
    for i in range(n):
        good = good and q[i] >= task[9 + i] and q[i] <= task[9 + n + i]
    return good


def verdict(plan: Floats, poses: int, checked: Floats, best: Floats, errors: Floats, good: Whole) -> None:
    """As `met`, of many configurations.

    Args:
        plan: see `start_loops`.
        poses: how many.
        checked: (poses, 22) pose and twist that is left, by the check kernel.
        best: (poses, n + 1) configurations.
        errors: (poses, 2) of rotation and position [rad, m], out.
        good: (poses) 1 where tolerances and bounds are met, out.
    """
    n = int(plan[JOINTS])
    for row in range(poses):
        fine = met(plan, best[(n + 1) * row :], checked[22 * row + 16 :], errors[2 * row :])
        good[row] = 1 if fine else 0
