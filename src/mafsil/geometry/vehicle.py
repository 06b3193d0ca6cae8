"""Frames of vehicles: z down (x forward, y right, z towards the ground) and z up (x forward, y left); any batch.

Between them lies a half turn about x: z down from z up is conjugation by diag(1, -1, -1), in which (roll, pitch, yaw)
becomes (roll, -pitch, -yaw).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import RotationMatrix, Vector3, Vector6, as_batch

_TURN = np.array([1.0, -1.0, -1.0])


def vector(x: ArrayLike) -> Vector3:
    """(*batch, 3) components of a vector or a point in the other kind of frame; its own inverse."""
    return as_batch("x", x, (3,)) * _TURN


def rotation(R: ArrayLike) -> RotationMatrix:
    """(*batch, 3, 3) attitude of the vehicle when both its frame and the ground's are exchanged; its own inverse."""
    return as_batch("R", R, (3, 3)) * (_TURN[:, None] * _TURN)


def roll_pitch_yaw(rpy: ArrayLike) -> Vector3:
    """(*batch, 3) (roll, -pitch, -yaw) of (roll, pitch, yaw) [rad]; its own inverse."""
    return as_batch("rpy", rpy, (3,)) * _TURN


def twist(V: ArrayLike) -> Vector6:
    """(*batch, 6) of a twist, or of a wrench, both halves turned; its own inverse."""
    return as_batch("V", V, (6,)) * np.tile(_TURN, 2)
