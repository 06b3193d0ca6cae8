"""All logarithms of one rotation or displacement: axes, angles, screws; the solid ball has two names at its rim."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, floor, pi

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, Vector3, Vector6, single
from mafsil.errors import InputError
from mafsil.geometry import membership, rotation, screw

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
    def coordinates(self) -> Vector3:
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


@dataclass(frozen=True, eq=False)
class ScrewAmount:
    """One screw of a displacement, T = exp([S] amount).

    Attributes:
        screw: (6,) unit screw; where every parallel line serves, the one through the origin.
        amount: [rad], with any number of turns; [m] where omega is zero.
        any_line: whether every line parallel to the axis serves as well: whole turns with an advance.
        any_axis: whether every line of space serves: whole turns of the identity.
    """

    screw: Vector6
    amount: float
    any_line: bool = False
    any_axis: bool = False

    @property
    def pitch(self) -> float:
        """[m/rad]; infinite for translations."""
        return float(screw.pitch(self.screw))


def screws(T: ArrayLike, low: float = 0.0, high: float = 2 * pi, tolerance: float = END) -> tuple[ScrewAmount, ...]:
    """Every unit screw and amount of a displacement with low <= amount <= high, ordered by amount.

    (w, theta + 2 pi k) and (-w, -theta + 2 pi k), all about one line, with one advance d = w.p and thus with pitches
    d / amount that differ. At half a turn w and -w both serve, with pitches of opposite sign. A translation is,
    besides, k turns about any line along it with the pitch |p| / (2 pi k), and the identity k turns about any line.

    Args:
        T: (4, 4) one displacement.
        low, high: range of angles [rad]; a pure translation is listed whatever its length.
        tolerance: angle [rad] to 0 or pi that counts as an end.

    Raises:
        InputError: T is no pose, or a batch.
    """
    matrix = membership.require("pose", "T", single("T", T, (4, 4)))
    R, p = matrix[:3, :3], matrix[:3, 3]
    if rotation.angle(R) <= tolerance:
        return _screws_of_translation(p, low, high)
    found: list[ScrewAmount] = []
    for value in logarithms(R, low, high, tolerance):
        omega = np.array(value.axis)
        v = screw.integral_inverse(omega, value.angle) @ p
        found.append(ScrewAmount(np.concatenate([omega, v]), value.angle))
    return tuple(found)


def _screws_of_translation(p: Floats, low: float, high: float) -> tuple[ScrewAmount, ...]:
    length = float(np.linalg.norm(p))
    turns = [k for k in _turns(0.0, low, high) if k]
    if length == 0.0:
        whole = [ScrewAmount(np.array([1.0, 0, 0, 0, 0, 0]), 2 * pi * k, any_axis=True) for k in turns]
        return (ScrewAmount(np.zeros(6), 0.0, any_axis=True), *whole) if low <= 0 <= high else tuple(whole)
    found = [ScrewAmount(np.concatenate([np.zeros(3), p / length]), length)]
    for k in turns:
        for sign in (1.0, -1.0):
            omega = sign * p / length
            pitch = sign * length / (2 * pi * k)
            found.append(ScrewAmount(np.concatenate([omega, pitch * omega]), 2 * pi * k, any_line=True))
    return tuple(found)


def ball_points(R: ArrayLike, tolerance: float = END) -> Floats:
    """(1 or 2, 3) points of the solid ball of radius pi that are this rotation: one inside, two antipodes on the rim.

    Args:
        R: (3, 3) one rotation.
        tolerance: angle [rad] to pi within which both are given.
    """
    r = rotation.log(_one(R))
    return np.stack([r, -r]) if pi - np.linalg.norm(r) <= tolerance else r[None]


def _turns(angle: float, low: float, high: float) -> range:
    """All k with low <= angle + 2 pi k <= high; the ends count when met within END.

    Raises:
        InputError: an end of the range is not finite: there are endless angles.
    """
    low, high = float(single("low", low, ())), float(single("high", high, ()))
    return range(ceil((low - END - angle) / (2 * pi)), floor((high + END - angle) / (2 * pi)) + 1)


def _one(R: ArrayLike) -> Floats:
    matrix = rotation.check(R)
    if matrix.ndim != 2:
        raise InputError("geometry.one_value", name="R", batch=matrix.shape[:-2])
    return matrix


def _as_tuple(axis: Floats) -> tuple[float, float, float]:
    x, y, z = (float(number) for number in axis)
    return x, y, z
