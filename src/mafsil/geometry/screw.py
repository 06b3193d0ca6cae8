"""Screws S = (omega, v): axis, point and pitch, and the displacement along them; any batch.

A unit screw has |omega| = 1 (amount: an angle [rad]) or omega = 0 and |v| = 1 (amount: a distance [m]).
"""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix, Vector3, Vector6
from mafsil.geometry.declared import Declared

_from_axis = Declared("screw.from_axis", "direction:3 point:3 pitch", "S:6", {"direction": "axis"})
_pitch = Declared("screw.pitch", "S:6", "pitch")
_nearest_point = Declared("screw.nearest_point", "S:6", "point:3")
_normalized = Declared("screw.normalized", "V:6", "S:6")
_magnitude = Declared("screw.magnitude", "V:6", "magnitude")
_motion = Declared("screw.motion", "S:6 amount", "T:4,4", {"S": "unit_screw", "amount": "amount"})
_chasles = Declared("screw.chasles", "T:4,4", "S:6 amount", {"T": "pose"})
_integral = Declared("screw.integral", "omega:3 theta", "G:3,3", {"theta": "amount"})
_integral_inverse = Declared("screw.integral_inverse", "omega:3 theta", "G:3,3", {"theta": "part_turn"})
_reciprocal = Declared("spatial.reciprocal_product", "S:6 Z:6", "product")


def from_axis(direction: ArrayLike, point: ArrayLike, pitch: ArrayLike = 0.0) -> Vector6:
    """Unit screw of an axis: S = (s, -s x q + h s).

    Args:
        direction: (*batch, 3) along the axis, any length but zero.
        point: (*batch, 3) a point of the axis [m].
        pitch: (*batch) advance per angle [m/rad]; 0 is a pure rotation. For a pure translation use `from_direction`.

    Returns:
        (*batch, 6).

    Raises:
        InputError: a direction is zero.

    Reference: Lynch & Park, Modern Robotics, sec. 3.3.2.2.
    """
    return _from_axis.at(direction, point, pitch)


def from_direction(direction: ArrayLike) -> Vector6:
    """(*batch, 6) unit screw of infinite pitch (0, s), a translation along (*batch, 3) of any length but zero."""
    S = from_axis(direction, (0.0, 0.0, 0.0))
    S[..., 3:] = S[..., :3]
    S[..., :3] = 0.0
    return S


def pitch(S: ArrayLike) -> Any:
    """(*batch) pitch omega.v / |omega|^2 [m/rad] of (*batch, 6); infinite where omega is zero."""
    return _pitch.at(S)


def nearest_point(S: ArrayLike) -> Vector3:
    """(*batch, 3) point of the axis nearest to the origin, omega x v / |omega|^2 [m]; NaN where omega is zero."""
    return _nearest_point.at(S)


def normalized(V: ArrayLike) -> Vector6:
    """(*batch, 6) unit screw of twists (*batch, 6); zero for the zero twist."""
    return _normalized.at(V)


def magnitude(V: ArrayLike) -> Any:
    """(*batch) |omega| of twists (*batch, 6), or |v| where omega is zero: the factor that `normalized` divides out."""
    return _magnitude.at(V)


def displacement(S: ArrayLike, amount: ArrayLike) -> PoseMatrix:
    """exp([S] amount): rotation by, or translation along, a unit screw.

    Args:
        S: (*batch, 6) unit screw.
        amount: (*batch) angle [rad], or distance [m] where omega is zero.

    Returns:
        (*batch, 4, 4).

    Raises:
        InputError: S is not unit within `tolerance.UNIT`.

    Reference: Lynch & Park, Modern Robotics, prop. 3.25.
    """
    return _motion.at(S, amount)


def chasles(T: ArrayLike) -> tuple[Vector6, Any]:
    """The one screw that makes a displacement: T = exp([S] amount) (Chasles and Mozzi).

    Rotations below `tolerance.TRANSLATION` count as none. The identity has S = 0 and amount 0; its axis is any line.

    Args:
        T: (*batch, 4, 4) displacement.

    Returns:
        S (*batch, 6) unit screw, amount (*batch) angle in [0, pi] [rad] or distance [m].
    """
    return _chasles.at(T)


def integral(omega: ArrayLike, theta: ArrayLike) -> Floats:
    """(*batch, 3, 3) G(theta) of a unit axis: exp([S] theta) has p = G v.

    Reference: Lynch & Park, Modern Robotics, eq. 3.87.
    """
    return _integral.at(omega, theta)


def integral_inverse(omega: ArrayLike, theta: ArrayLike) -> Floats:
    """(*batch, 3, 3) G(theta)^-1; whole turns are refused, where det G = 2 theta (1 - cos theta) vanishes."""
    return _integral_inverse.at(omega, theta)


def reciprocal_product(S: ArrayLike, Z: ArrayLike) -> Any:
    """(*batch) omega_S . v_Z + v_S . omega_Z: zero for screws that do no work on each other."""
    return _reciprocal.at(S, Z)
