"""Which solutions of many poses can move while the pose stays, though no joint of the closed form is free.

1. Singular values of the Jacobian: only where one is next to nothing may anything move.
2. The joint that moves most along the null space is moved by a step, to both sides, and locked there.
3. Newton's method on the others: where the pose is met again and the joint is still away, the solution moves.

Where the null space has more than one direction the same is tried along each joint's projection on it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.ik.answers.setting import Setting
from mafsil.ik.refine import refined
from mafsil.ik.tolerances import SELF_MOTION

STEP = 0.02
"""Motion that proves a continuum [rad | m]."""


def moving_joints(setting: Setting, q: JointVector, T: PoseMatrix, tolerance: float) -> NDArray[np.int64]:
    """(k,) the coordinate that moves most along the continuum through each solution; -1 of isolated ones.

    Args:
        setting: the arm.
        q: (k, n) solutions.
        T: (k, 4, 4) their poses.
        tolerance: largest residual of a solution.
    """
    joint = np.full(len(q), -1)
    # 1.
    jacobians = setting.scaled_jacobians(q)
    _, values, rights = np.linalg.svd(jacobians, full_matrices=True)
    weak = np.ones((len(q), q.shape[1]), dtype=np.bool_)
    weak[:, : values.shape[1]] = values <= SELF_MOTION * values[:, :1]
    rows = np.flatnonzero(weak.any(axis=1))
    if not len(rows):
        return joint
    # 2.
    null = rights[rows] * weak[rows][:, :, None]
    sizes: Floats = np.linalg.norm(null, axis=1)
    best = np.round(sizes, 3).argmax(axis=1)
    direction = np.take_along_axis(null, best[:, None, None], axis=2)[:, :, 0]
    rates = np.einsum("ki,kij->kj", direction, null)
    way: Floats = STEP * rates / np.abs(rates).max(axis=1, keepdims=True)
    starts = np.concatenate([q[rows] + way, q[rows] - way])
    locked = np.zeros(starts.shape, dtype=np.bool_)
    locked[np.arange(len(starts)), np.tile(best, 2)] = True
    # 3.
    moved, size = refined(setting.robot, starts, np.tile(T[rows], (2, 1, 1)), setting.mask, None, locked=locked)
    away = np.abs(moved - np.tile(q[rows], (2, 1))).max(axis=1) > STEP / 2
    moves = ((size <= tolerance) & away).reshape(2, -1).any(axis=0)
    joint[rows[moves]] = best[moves]
    return joint
