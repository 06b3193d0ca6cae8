"""Poses as people write them: position and roll, pitch, yaw, or a quaternion."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats, PoseMatrix, RotationMatrix, Vector3
from mafsil.geometry import rotation
from mafsil.job.description import Goal, Pose

LEVEL = 1e-9
"""Horizontal part of a direction of length one below which it is vertical."""


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


def facing(direction: Vector3) -> RotationMatrix:
    """(3, 3) orientation with z along a direction and x level: a camera that looks along z sees y downwards.

    Args:
        direction: (3,) of any length; straight up or down x is that of the frame.
    """
    z = direction / np.linalg.norm(direction)
    across = np.array([z[1], -z[0], 0.0])
    x = across / np.linalg.norm(across) if np.linalg.norm(across) > LEVEL else np.array([1.0, 0.0, 0.0])
    y = np.cross(z, x)
    y /= np.linalg.norm(y)
    return np.stack([np.cross(y, z), y, z], axis=1)


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
