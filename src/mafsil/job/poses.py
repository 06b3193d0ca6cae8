"""Poses as people write them: position and roll, pitch, yaw, or a quaternion."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats, PoseMatrix
from mafsil.geometry import rotation
from mafsil.job.description import Goal, Pose


def pose_matrix(pose: Pose, *, degrees: bool, orientation: Floats | None = None) -> PoseMatrix:
    """(4, 4) matrix of a pose.

    Args:
        pose: of the job file.
        degrees: whether its angles are degrees.
        orientation: (3, 3) taken if the pose says nothing about it; identity if None.
    """
    T = np.eye(4)
    T[:3, 3] = pose.position
    if pose.quaternion is not None:
        T[:3, :3] = rotation.from_quaternion(np.array(pose.quaternion) / np.linalg.norm(pose.quaternion))
    elif pose.rpy is not None:
        T[:3, :3] = rotation.from_rpy(np.radians(pose.rpy) if degrees else np.array(pose.rpy))
    elif orientation is not None:
        T[:3, :3] = orientation
    return T


def goal_matrix(goal: Goal, here: PoseMatrix, *, degrees: bool) -> PoseMatrix:
    """(4, 4) where a goal is.

    Args:
        goal: of the job; a relative one is a displacement along the axes of the tool or of {s}.
        here: (4, 4) pose of the tip when the move begins: its orientation is taken if the goal names none.
        degrees: whether its angles are degrees.
    """
    if goal.relative is None:
        return pose_matrix(goal, degrees=degrees, orientation=here[:3, :3])
    change = pose_matrix(goal, degrees=degrees)
    if goal.relative == "tool":
        return here @ change
    T = np.array(here)
    T[:3, 3] += change[:3, 3]
    T[:3, :3] = change[:3, :3] @ here[:3, :3]
    return T
