"""The path of a body point that a screw carries: a helix about the axis, a circle, or a straight line."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Vector3, Vector6, single
from mafsil.geometry import membership, pose, screw


@dataclass(frozen=True, eq=False)
class Helix:
    """x(theta) = q + exp([w] theta)(x - q) + h theta w.

    Attributes:
        screw: (6,) unit screw.
        start: (3,) the point at theta = 0 [m].
        radius: distance from the axis [m]; 0 for translations.
        speed: length of path for each unit of theta, sqrt(radius^2 + h^2) [m/rad]; 1 for translations.
        lead: advance in one turn, 2 pi h [m]; infinite for translations.
    """

    screw: Vector6
    start: Vector3
    radius: float
    speed: float
    lead: float

    def at(self, theta: ArrayLike) -> Vector3:
        """(*batch, 3) the point after (*batch) theta [rad], or [m] of a translation."""
        return pose.act(screw.displacement(self.screw, theta), self.start)

    def length(self, theta: float) -> float:
        """Length of the path to theta [m]."""
        return abs(theta) * self.speed


def helix(S: ArrayLike, point: ArrayLike) -> Helix:
    """The path of a point along a screw.

    Args:
        S: (6,) unit screw; `screw.from_axis` makes one of axis, point and pitch.
        point: (3,) at the start [m].

    Raises:
        InputError: S is not of unit size.
    """
    unit = membership.require("unit_screw", "S", single("S", S, (6,)))
    start = single("point", point, (3,))
    omega, v = unit[:3], unit[3:]
    if not omega.any():
        return Helix(unit, start, 0.0, 1.0, float("inf"))
    h = float(omega @ v)
    radius = float(np.linalg.norm(np.cross(omega, start) + v - h * omega))
    return Helix(unit, start, radius, float(np.hypot(radius, h)), 2 * np.pi * h)
