"""Twists V = (omega, v) [rad/s, m/s]: from the motion of a pose and back, and changes of frame; any batch.

V_b: omega_b and v_b, the velocity of the origin of {b}, in the axes of {b}. V_s: omega_s and v_s, the velocity of the
body point that passes the origin of {s} now, the body thought without limits, in the axes of {s}.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.algebra.tolerance import SKEW
from mafsil.arrays import Floats, Matrix4, Matrix6, Scalar, Vector3, Vector6
from mafsil.errors import InputError
from mafsil.geometry.conditioned import (
    DurationLike,
    Matrix3Like,
    Matrix4Like,
    PoseLike,
    RotationLike,
    Vector3Like,
    Vector6Like,
    compile_function,
)


@compile_function("se3.angular_space")
def _angular_space(R: RotationLike, Rdot: Matrix3Like) -> tuple[Vector3, Scalar]: ...


@compile_function("se3.angular_body")
def _angular_body(R: RotationLike, Rdot: Matrix3Like) -> tuple[Vector3, Scalar]: ...


@compile_function("se3.space_twist")
def _space(T: PoseLike, Tdot: Matrix4Like) -> tuple[Vector6, Scalar]: ...


@compile_function("se3.body_twist")
def _body(T: PoseLike, Tdot: Matrix4Like) -> tuple[Vector6, Scalar]: ...


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
    return _skew_checked(_angular_space(R, Rdot))


def angular_velocity_body(R: ArrayLike, Rdot: ArrayLike) -> Vector3:
    """(*batch, 3) omega_b with [omega_b] = R' Rdot, in {b}; arguments as `angular_velocity_space`."""
    return _skew_checked(_angular_body(R, Rdot))


def space_from_pose_rate(T: ArrayLike, Tdot: ArrayLike) -> Vector6:
    """(*batch, 6) V_s with [V_s] = Tdot T^-1: (omega_s, pdot - omega_s x p).

    Args:
        T: (*batch, 4, 4) pose T_sb.
        Tdot: (*batch, 4, 4) its derivative; the last row is not read.

    Raises:
        InputError: Tdot is no velocity of T.
    """
    return _skew_checked(_space(T, Tdot))


def body_from_pose_rate(T: ArrayLike, Tdot: ArrayLike) -> Vector6:
    """(*batch, 6) V_b with [V_b] = T^-1 Tdot: (omega_b, R' pdot); arguments as `space_from_pose_rate`."""
    return _skew_checked(_body(T, Tdot))


@compile_function("se3.pose_rate_of_body_twist")
def pose_rate_from_body(T: PoseLike, V_b: Vector6Like) -> Matrix4:
    """(*batch, 4, 4) Tdot = T [V_b]."""
    ...


@compile_function("se3.pose_rate_of_space_twist")
def pose_rate_from_space(T: PoseLike, V_s: Vector6Like) -> Matrix4:
    """(*batch, 4, 4) Tdot = [V_s] T."""
    ...


@compile_function("se3.mean_angular_velocity")
def mean_angular_velocity(R_0: RotationLike, R_1: RotationLike, duration: DurationLike) -> Vector3:
    """(*batch, 3) constant omega_s [rad/s] that turns R_0 into R_1 within the duration [s], which is not zero."""
    ...


@compile_function("se3.mean_space_twist")
def mean_space_twist(T_0: PoseLike, T_1: PoseLike, duration: DurationLike) -> Vector6:
    """(*batch, 6) constant V_s that carries T_0 into T_1 within the duration [s], which is not zero."""
    ...


@compile_function("spatial.transform_twist")
def transform(T_ab: PoseLike, V_b: Vector6Like) -> Vector6:
    """V_a = Ad(T_ab) V_b = (R omega, R v + p x R omega).

    Args:
        T_ab: (*batch, 4, 4) pose of {b} in {a}.
        V_b: (*batch, 6) twist, or screw axis, in {b}.

    Returns:
        (*batch, 6).

    Reference: Lynch & Park, Modern Robotics, eq. 3.83.
    """
    ...


@compile_function("spatial.point_velocity")
def point_velocity(V: Vector6Like, point: Vector3Like) -> Vector3:
    """(*batch, 3) omega x r + v [m/s] of the body point at r (*batch, 3) [m], in the frame of the twist."""
    ...


@compile_function("spatial.ad")
def ad(V: Vector6Like) -> Matrix6:
    """(*batch, 6, 6) [[ [omega], 0 ], [ [v], [omega] ]]."""
    ...


@compile_function("spatial.bracket")
def bracket(V: Vector6Like, W: Vector6Like) -> Vector6:
    """(*batch, 6) Lie bracket ad(V) W."""
    ...


def _skew_checked(answer: tuple[Floats, Any]) -> Floats:
    value, defect = answer
    if np.any(defect > SKEW):
        raise InputError("geometry.skew", name="Rdot", distance=float(np.max(defect)), limit=SKEW)
    return value
