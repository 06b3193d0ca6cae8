"""Twists V = (omega, v) [rad/s, m/s]: from the motion of a pose and back, and changes of frame; any batch.

V_b: omega_b and v_b, the velocity of the origin of {b}, in the axes of {b}. V_s: omega_s and v_s, the velocity of the
body point that passes the origin of {s} now, the body thought without limits, in the axes of {s}.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.algebra.tolerance import SKEW
from mafsil.arrays import Floats, PoseMatrix, Vector3, Vector6
from mafsil.errors import InputError
from mafsil.geometry.declared import Declared

_T = {"T": "pose"}
_R = {"R": "rotation"}

_angular_space = Declared("velocity.angular_space", "R:3,3 Rdot:3,3", "omega_s:3 defect", _R)
_angular_body = Declared("velocity.angular_body", "R:3,3 Rdot:3,3", "omega_b:3 defect", _R)
_space = Declared("velocity.space_twist", "T:4,4 Tdot:4,4", "V_s:6 defect", _T)
_body = Declared("velocity.body_twist", "T:4,4 Tdot:4,4", "V_b:6 defect", _T)
_rate_body = Declared("velocity.pose_rate_of_body_twist", "T:4,4 V_b:6", "Tdot:4,4", _T)
_rate_space = Declared("velocity.pose_rate_of_space_twist", "T:4,4 V_s:6", "Tdot:4,4", _T)
_mean_angular = Declared(
    "velocity.mean_angular_velocity",
    "R_0:3,3 R_1:3,3 duration",
    "omega_s:3",
    {"R_0": "rotation", "R_1": "rotation", "duration": "duration"},
)
_mean = Declared(
    "velocity.mean_space_twist",
    "T_0:4,4 T_1:4,4 duration",
    "V_s:6",
    {"T_0": "pose", "T_1": "pose", "duration": "duration"},
)
_transform = Declared("spatial.transform_twist", "T_ab:4,4 V_b:6", "V_a:6", {"T_ab": "pose"})
_point_velocity = Declared("spatial.point_velocity", "V:6 point:3", "velocity:3")
_ad = Declared("spatial.ad", "V:6", "ad:6,6")
_bracket = Declared("spatial.bracket", "V:6 W:6", "bracket:6")


def angular_velocity_space(R: ArrayLike, Rdot: ArrayLike) -> Vector3:
    """omega_s with [omega_s] = Rdot R', in {s}.

    Args:
        R: (*batch, 3, 3) rotation R_sb.
        Rdot: (*batch, 3, 3) its derivative [1/s].

    Returns:
        (*batch, 3) [rad/s].

    Raises:
        InputError: Rdot is no velocity of R: the symmetric part of R'Rdot exceeds `tolerance.SKEW`.
    """
    return _skew_checked(_angular_space.at(R, Rdot))


def angular_velocity_body(R: ArrayLike, Rdot: ArrayLike) -> Vector3:
    """(*batch, 3) omega_b with [omega_b] = R' Rdot, in {b}; arguments as `angular_velocity_space`."""
    return _skew_checked(_angular_body.at(R, Rdot))


def space_from_pose_rate(T: ArrayLike, Tdot: ArrayLike) -> Vector6:
    """(*batch, 6) V_s with [V_s] = Tdot T^-1: (omega_s, pdot - omega_s x p).

    Args:
        T: (*batch, 4, 4) pose T_sb.
        Tdot: (*batch, 4, 4) its derivative; the last row is not read.

    Raises:
        InputError: Tdot is no velocity of T.
    """
    return _skew_checked(_space.at(T, Tdot))


def body_from_pose_rate(T: ArrayLike, Tdot: ArrayLike) -> Vector6:
    """(*batch, 6) V_b with [V_b] = T^-1 Tdot: (omega_b, R' pdot); arguments as `space_from_pose_rate`."""
    return _skew_checked(_body.at(T, Tdot))


def pose_rate_from_body(T: ArrayLike, V_b: ArrayLike) -> PoseMatrix:
    """(*batch, 4, 4) Tdot = T [V_b]."""
    return _rate_body.at(T, V_b)


def pose_rate_from_space(T: ArrayLike, V_s: ArrayLike) -> PoseMatrix:
    """(*batch, 4, 4) Tdot = [V_s] T."""
    return _rate_space.at(T, V_s)


def mean_angular_velocity(R_0: ArrayLike, R_1: ArrayLike, duration: ArrayLike) -> Vector3:
    """(*batch, 3) constant omega_s [rad/s] that turns R_0 into R_1 within the duration [s], which is not zero."""
    return _mean_angular.at(R_0, R_1, duration)


def mean_space_twist(T_0: ArrayLike, T_1: ArrayLike, duration: ArrayLike) -> Vector6:
    """(*batch, 6) constant V_s that carries T_0 into T_1 within the duration [s], which is not zero."""
    return _mean.at(T_0, T_1, duration)


def transform(T_ab: ArrayLike, V_b: ArrayLike) -> Vector6:
    """V_a = Ad(T_ab) V_b = (R omega, R v + p x R omega).

    Args:
        T_ab: (*batch, 4, 4) pose of {b} in {a}.
        V_b: (*batch, 6) twist, or screw axis, in {b}.

    Returns:
        (*batch, 6).

    Reference: Lynch & Park, Modern Robotics, eq. 3.83.
    """
    return _transform.at(T_ab, V_b)


def point_velocity(V: ArrayLike, point: ArrayLike) -> Vector3:
    """(*batch, 3) omega x r + v [m/s] of the body point at r (*batch, 3) [m], in the frame of the twist."""
    return _point_velocity.at(V, point)


def ad(V: ArrayLike) -> Floats:
    """(*batch, 6, 6) [[ [omega], 0 ], [ [v], [omega] ]]."""
    return _ad.at(V)


def bracket(V: ArrayLike, W: ArrayLike) -> Vector6:
    """(*batch, 6) Lie bracket ad(V) W."""
    return _bracket.at(V, W)


def _skew_checked(answer: tuple[Floats, Any]) -> Floats:
    value, defect = answer
    if np.any(defect > SKEW):
        raise InputError("geometry.skew", name="Rdot", distance=float(np.max(defect)), limit=SKEW)
    return value
