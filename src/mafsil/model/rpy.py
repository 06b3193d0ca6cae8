"""Roll, pitch, yaw about the fixed axes of a rotation, without loss at pitch = pi/2."""

from __future__ import annotations

from math import atan2, cos, sin

from mafsil.arrays import Floats


def rpy_from_rotation(R: Floats) -> tuple[float, float, float]:
    """Roll, pitch, yaw [rad] of a rotation matrix (3, 3).

    Yaw is found first and turned back; what remains is a turn about y and one about x, well conditioned everywhere.
    """
    yaw = atan2(R[1, 0], R[0, 0]) if max(abs(R[1, 0]), abs(R[0, 0])) > 1e-14 else 0.0
    c, s = cos(yaw), sin(yaw)
    pitch = atan2(-R[2, 0], c * R[0, 0] + s * R[1, 0])
    roll = atan2(s * R[0, 2] - c * R[1, 2], c * R[1, 1] - s * R[0, 1])
    return roll, pitch, yaw
