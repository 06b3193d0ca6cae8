"""Wrists that stand straight while an elbow or a shoulder is at its limit, where rounding hides the continuum.

Rounding splits the merged roots of the elbow by its square root. The wrist then seems bent by as much, and each of the
split roots gets turns of the wrist's outer joints that mean nothing. With the wrist locked straight both roots are one
again, and where they still reach the pose the outer joints are free.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import JointVector, PoseMatrix
from mafsil.geometry import rotation
from mafsil.ik.answers.setting import Setting
from mafsil.ik.refine import refine_rows
from mafsil.ik.tolerances import EXACT_POSE, HIDDEN, PART_OF_BEND, STRAIGHT
from mafsil.mechanics.arm_pattern import ArmPattern, Family

NEARLY = 1e-2
"""Angle up to which a wrist may be straight but for rounding [rad]: four merged roots are split by its fourth root."""


def straighten_wrist(
    setting: Setting, pattern: ArmPattern, T: PoseMatrix, q: JointVector, free: NDArray[np.int64]
) -> tuple[JointVector, NDArray[np.int64]]:
    """Solutions with the wrist locked straight where that reaches the pose, and the coordinates that are free then.

    Args:
        setting: the arm.
        pattern: of its closed form.
        T: (4, 4) requested pose, or (k, 4, 4) one of each candidate.
        q: (k, n) candidates.
        free: (k,) sum of 2^i over their free coordinates.
    """
    bend, loose = pattern.joints[4:5], pattern.joints[3 if pattern.family is Family.SPHERICAL_WRIST else 5 : 6]
    if not bend or not len(q) or bend[0] < 0 or loose[0] < 0:
        return q, free
    poses = np.broadcast_to(T, (len(q), 4, 4))
    for value in _straight(pattern):
        off = (q[:, bend[0]] - value + np.pi) % (2 * np.pi) - np.pi
        rows = np.flatnonzero((np.abs(off) < NEARLY) & ((free >> loose[0]) % 2 == 0))
        if len(rows):
            start = q[rows]
            start[:, bend[0]] -= off[rows]
            found, residual = refine_rows(setting.robot, start, poses[rows], setting.mask, None, locked=bend)
            reached = residual <= np.maximum(STRAIGHT, np.minimum(HIDDEN, PART_OF_BEND * np.abs(off[rows])))
            rows = rows[reached]
            q, free = q.copy(), free.copy()
            q[rows] = found[reached]
            free[rows] += 1 << loose[0]
    return q, free


def _straight(pattern: ArmPattern) -> list[float]:
    """Values of the fifth joint that make the sixth axis parallel to the fourth, or to the three parallel ones."""
    outer, w5, w6 = pattern.axes[3 if pattern.family is Family.SPHERICAL_WRIST else 1], *pattern.axes[4:6]
    found: list[float] = []
    for goal in (outer, -outer):
        value = float(np.arctan2(w5 @ np.cross(w6, goal), w6 @ goal - (w5 @ w6) * (w5 @ goal)))
        if np.abs(rotation.exp(w5 * value) @ w6 - goal).max() < EXACT_POSE:
            found.append(value)
    return found
