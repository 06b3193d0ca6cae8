"""Hayati's parameters for neighbouring axes that are nearly parallel, where Denavit-Hartenberg numbers run away.

T_i-1,i = Rot(z, theta) Trans(x, a) Rot(x, alpha) Rot(y, beta): the origin of {i} stays in the x-y plane of {i-1}, and
small tilts of the axis give small alpha and beta. Useless where the axes are at right angles.

Reference: S. Hayati, M. Mirmirani, Improving the absolute positioning accuracy of robot manipulators, J. Robotic
Systems 2(4), 1985.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import PoseMatrix
from mafsil.errors import ModelError
from mafsil.model.placement import checked_pose, inverse, rotation_x, rotation_y, rotation_z, translation

STEEPEST = 0.1
"""Smallest cosine of the angle between the axes for which the parameters are offered."""


@dataclass(frozen=True, slots=True)
class HayatiRow:
    """One link between nearly parallel axes.

    Attributes:
        theta, alpha, beta: rotations about z, x and y [rad].
        a: length along x [m].
    """

    theta: float
    a: float
    alpha: float
    beta: float

    def transform(self, q: float = 0.0) -> PoseMatrix:
        """(4, 4) Rot(z, theta + q) Trans(x, a) Rot(x, alpha) Rot(y, beta)."""
        return (
            rotation_z(self.theta + q) @ translation(self.a, 0.0, 0.0) @ rotation_x(self.alpha) @ rotation_y(self.beta)
        )


def hayati_parameters(T: ArrayLike) -> tuple[HayatiRow, PoseMatrix]:
    """Hayati's row of a pose between two axes, and the motion about and along the second axis that is left.

    T = row.transform() Trans(z, d) Rot(z, phi), the rest being a change of frame on the second axis.

    Args:
        T: (4, 4) pose of a frame on the second axis in one on the first, z along the axes.

    Returns:
        The row and the (4, 4) rest.

    Raises:
        ModelError: the axes are too far from parallel, or T is no pose.
    """
    pose = checked_pose("T", T)
    z, p = pose[:3, 2], pose[:3, 3]
    if abs(z[2]) < STEEPEST:
        raise ModelError("dh.hayati", angle=float(np.degrees(np.arccos(np.clip(z[2], -1.0, 1.0)))))
    foot = p - z * (p[2] / z[2])
    a = float(np.hypot(foot[0], foot[1]))
    theta = float(np.arctan2(foot[1], foot[0])) if a > 0.0 else 0.0
    seen = rotation_z(theta)[:3, :3].T @ z
    beta = float(np.arcsin(np.clip(seen[0], -1.0, 1.0)))
    row = HayatiRow(theta, a, float(np.arctan2(-seen[1], seen[2])), beta)
    return row, inverse(row.transform()) @ pose
