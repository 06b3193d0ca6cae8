"""Poses as people write them: position and roll, pitch, yaw, or a quaternion."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats, PoseMatrix
from mafsil.geometry import rotation
from mafsil.job.description import Pose


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
