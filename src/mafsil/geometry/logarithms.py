"""All axes and angles of one rotation: the logarithm has many values, and the solid ball two names at its rim."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, floor, pi

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.geometry import rotation

END = 1e-9
"""Angle [rad] to 0 or pi within which a rotation counts as the identity or as a half turn when answers are listed."""


@dataclass(frozen=True)
class AxisAngle:
    """One logarithm.

    Attributes:
        axis: (3,) unit axis, or None where every axis serves (whole turns of the identity).
        angle: [rad], with any number of turns.
    """

    axis: tuple[float, float, float] | None
    angle: float

    @property
    def coordinates(self) -> Floats:
        """(3,) exponential coordinates r = axis angle [rad]; along x where every axis serves."""
        return np.array(self.axis or (1.0, 0.0, 0.0)) * self.angle


def logarithms(R: ArrayLike, low: float = 0.0, high: float = 2 * pi, tolerance: float = END) -> tuple[AxisAngle, ...]:
    """Every (axis, angle) of a rotation with low <= angle <= high, ordered by angle.

    (w, theta + 2 pi k) and (-w, -theta + 2 pi k); a half turn gives them in pairs, the identity without axis.

    Args:
        R: (3, 3) one rotation.
        low, high: range of angles [rad].
        tolerance: angle [rad] to 0 or pi that counts as an end.
    """
    matrix = _one(R)
    axis, theta = rotation.to_axis_angle(matrix)
    theta = float(theta)
    if theta <= tolerance:
        return tuple(AxisAngle(None, 2 * pi * k) for k in _turns(0.0, low, high))
    if pi - theta <= tolerance:
        theta = pi
    forward, backward = _as_tuple(axis), _as_tuple(-axis)
    found = [AxisAngle(forward, theta + 2 * pi * k) for k in _turns(theta, low, high)]
    found += [AxisAngle(backward, -theta + 2 * pi * k) for k in _turns(-theta, low, high)]
    return tuple(sorted(found, key=lambda value: value.angle))


def ball_points(R: ArrayLike, tolerance: float = END) -> Floats:
    """(1 or 2, 3) points of the solid ball of radius pi that are this rotation: one inside, two antipodes on the rim.

    Args:
        R: (3, 3) one rotation.
        tolerance: angle [rad] to pi within which both are given.
    """
    r = rotation.log(_one(R))
    return np.stack([r, -r]) if pi - np.linalg.norm(r) <= tolerance else r[None]


def _turns(angle: float, low: float, high: float) -> range:
    """All k with low <= angle + 2 pi k <= high; the ends count when met within END."""
    return range(ceil((low - END - angle) / (2 * pi)), floor((high + END - angle) / (2 * pi)) + 1)


def _one(R: ArrayLike) -> Floats:
    matrix = rotation.check(R)
    if matrix.ndim != 2:
        raise InputError("geometry.one_value", name="R", batch=matrix.shape[:-2])
    return matrix


def _as_tuple(axis: Floats) -> tuple[float, float, float]:
    x, y, z = (float(number) for number in axis)
    return x, y, z
