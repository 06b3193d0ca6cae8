"""Poses before the search and answers after it, compiled: repair of rotations, whole turns, the check's verdict."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats, JointVector
from mafsil.ik.numerical.start_loops import CENTRE, DEFECT, JOINTS, SHIFT_LIMIT, TASK, TURN_LIMIT
from mafsil.kernels.loop_compiler import Whole

FARTHEST = 1e100
"""As `ik.problem.FARTHEST`; written here since the key of the compiled code covers these files only."""


def clean(plan: Floats, T: Floats, poses: int, out: Floats, valid: Whole, distance: Floats) -> None:
    """Poses with their rotations brought to working precision; identity where a row is no pose.

    1. A pose has finite numbers, the last row (0, 0, 0, 1) and a rotation, all up to the plan's DEFECT.
    2. Newton's iteration for the polar factor, R - R (R'R - I) / 2, twice: the defect is squared each time.

    Args:
        plan: see `start_loops`.
        T: (poses, 16).
        poses: how many.
        out: (poses, 16).
        valid: (poses) 1 for poses, 0 for others, out.
        distance: (poses) of the origin from the centre of the reach, out.
    """
    R, S = np.empty(9), np.empty(9)
    for row in range(poses):
        given, made = T[16 * row :], out[16 * row :]
        # 1.
        good = True
        for i in range(16):
            good = good and abs(given[i]) < FARTHEST
            if i >= 12:
                good = good and abs(given[i] - (1.0 if i == 15 else 0.0)) <= plan[DEFECT]
        for i in range(3):
            for j in range(3):
                R[3 * i + j] = given[4 * i + j]
        good = good and defect(R, S) <= plan[DEFECT] and determinant(R) > 0.0
        valid[row] = 1 if good else 0
        for i in range(16):
            made[i] = 1.0 if i % 5 == 0 else 0.0
        if good:
            # 2.
            for _ in range(2):
                defect(R, S)
                for i in range(3):
                    a, b, c = R[3 * i], R[3 * i + 1], R[3 * i + 2]
                    for j in range(3):
                        R[3 * i + j] -= 0.5 * (a * S[j] + b * S[3 + j] + c * S[6 + j])
            for i in range(3):
                made[4 * i + 3] = given[4 * i + 3]
                for j in range(3):
                    made[4 * i + j] = R[3 * i + j]
        square = 0.0
        for i in range(3):
            square += (made[4 * i + 3] - plan[CENTRE + i]) ** 2
        distance[row] = np.sqrt(square)


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


def wind(plan: Floats, poses: int, best: Floats, near: JointVector, one: int) -> None:
    """Turning joints moved by whole turns as close to `near` as their bounds allow.

    Args:
        plan: see `start_loops`.
        poses: how many.
        best: (poses, n + 1) configurations, changed.
        near: (poses, n), or (1, n) for all.
        one: 1 if it is the same for all.
    """
    n = int(plan[JOINTS])
    task = plan[TASK:]
    for row in range(poses):
        for i in range(n):
            if task[9 + 2 * n + i] > 0.0:
                angle, wanted = best[(n + 1) * row + i], near[i if one == 1 else n * row + i]
                moved = angle - 2.0 * np.pi * np.rint((angle - wanted) / (2.0 * np.pi))
                if moved >= task[9 + i] and moved <= task[9 + n + i]:
                    best[(n + 1) * row + i] = moved


def verdict(
    plan: Floats, poses: int, checked: Floats, best: Floats, rotation: Floats, position: Floats, good: Whole
) -> int:
    """What the check of every configuration says.

    Args:
        plan: see `start_loops`.
        poses: how many.
        checked: (poses, 22) pose and twist that is left, by the check kernel.
        best: (poses, n + 1) configurations.
        rotation, position: (poses) errors of what counts [rad, m], out.
        good: (poses) 1 where tolerances and bounds are met, out.

    Returns:
        Number of good rows.
    """
    n = int(plan[JOINTS])
    task = plan[TASK:]
    count = 0
    for row in range(poses):
        twist = checked[22 * row + 16 :]
        turn = shift = 0.0
        for i in range(3):
            if task[i] > 0.0:
                turn += twist[i] ** 2
            if task[3 + i] > 0.0:
                shift += twist[3 + i] ** 2
        rotation[row], position[row] = np.sqrt(turn), np.sqrt(shift)
        # The search aims at half the tolerances, whose squares the plan holds.
        met = turn <= 4.0 * plan[TURN_LIMIT] and shift <= 4.0 * plan[SHIFT_LIMIT]
        for i in range(n):
            q = best[(n + 1) * row + i]
            met = met and q >= task[9 + i] and q <= task[9 + n + i]
        good[row] = 1 if met else 0
        count += good[row]
    return count
