"""Rigid motions of the plane: angles, (2, 2) rotations, (3, 3) poses, poles; any batch.

Planar twist (omega, v_x, v_y). A pole is a homogeneous point (x, y, w): w = 0 is a point at infinity, a direction.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mafsil.algebra.tolerance import ROTATION, TRANSLATION
from mafsil.arrays import (
    Matrix3,
    PlanarPose,
    PlanarRotation,
    PoseMatrix,
    RotationMatrix,
    Scalar,
    Truth,
    Vector2,
    Vector3,
    Vector6,
    as_batch,
)
from mafsil.geometry import membership
from mafsil.geometry.conditioned import (
    PlanarCoordinatesLike,
    PlanarPoseLike,
    PlanarRotationLike,
    ScalarLike,
    Vector2Like,
    Vector3Like,
    compile_function,
)
from mafsil.geometry.euler import wrap_positive


@compile_function("planar.angle")
def _angle(R: PlanarRotationLike) -> Scalar: ...


@compile_function("planar.coordinates")
def _coordinates(T: PlanarPoseLike) -> Vector3: ...


@compile_function("planar.rotation")
def rotation(theta: ScalarLike) -> PlanarRotation:
    """(*batch, 2, 2) [[cos, -sin], [sin, cos]] of (*batch) angles [rad]."""
    ...


def angle(R: ArrayLike) -> Scalar:
    """(*batch) angle in [0, 2 pi) [rad] of planar rotations (*batch, 2, 2)."""
    return wrap_positive(_angle(R))


@compile_function("planar.pose")
def pose(theta: ScalarLike, p: Vector2Like) -> PlanarPose:
    """(*batch, 3, 3) planar pose of an angle (*batch) [rad] and an origin (*batch, 2) [m]."""
    ...


def coordinates(T: ArrayLike) -> Vector3:
    """(*batch, 3) (theta in [0, 2 pi), p_x, p_y) of planar poses (*batch, 3, 3)."""
    x = np.array(_coordinates(T))
    x[..., 0] = wrap_positive(x[..., 0])
    return x


@compile_function("planar.inverse")
def inverse(T: PlanarPoseLike) -> PlanarPose:
    """(*batch, 3, 3) T^-1 = (R', -R'p)."""
    ...


@compile_function("planar.compose")
def compose(T_ab: PlanarPoseLike, T_bc: PlanarPoseLike) -> PlanarPose:
    """(*batch, 3, 3) T_ac = (PQ, p + P q)."""
    ...


def displacement(T_sb: ArrayLike, T_sc: ArrayLike) -> PlanarPose:
    """(*batch, 3, 3) T_sc T_sb^-1: carries a body from {b} to {c}, coordinates of {s}."""
    return compose(T_sc, inverse(T_sb))


@compile_function("planar.exp")
def exp(V: PlanarCoordinatesLike) -> PlanarPose:
    """(*batch, 3, 3) displacement of planar exponential coordinates (omega, v_x, v_y) (*batch, 3) [rad, m]."""
    ...


@compile_function("planar.log")
def log(T: PlanarPoseLike) -> Vector3:
    """(*batch, 3) planar exponential coordinates (omega in (-pi, pi], v_x, v_y) of displacements (*batch, 3, 3)."""
    ...


@compile_function("planar.pole")
def pole(T: PlanarPoseLike) -> Vector3:
    """The point that a planar displacement keeps, in homogeneous coordinates.

    (p + cot(psi/2) J p) / 2, J a quarter turn; multiplied by sin(psi/2), so that translations have an answer too.

    Args:
        T: (*batch, 3, 3) displacement.

    Returns:
        (*batch, 3) (x, y, w): the pole is (x, y) / w; where w is 0 it is at infinity in the direction (x, y), across
        the translation. The identity gives (0, 0, 0): every point is kept.
    """
    ...


def finite_pole(T: ArrayLike) -> tuple[Vector2, Truth]:
    """Pole (*batch, 2) [m] and whether there is one (*batch).

    False with inf where the displacement only translates; False with NaN for the identity, which keeps every point.
    """
    x = np.asarray(pole(T))
    exists = np.abs(x[..., 2]) > TRANSLATION / 2
    divisor = np.where(exists, x[..., 2], 1.0)[..., None]
    nowhere = np.where((np.abs(x) <= TRANSLATION).all(-1, keepdims=True), np.nan, np.inf)
    return np.where(exists[..., None], x[..., :2] / divisor, nowhere), exists


def screw(T: ArrayLike) -> tuple[Scalar, Scalar, Vector2]:
    """The unit screw and amount of planar displacements: omega (*batch) in (1, -1, 0), amount (*batch), v (*batch, 2).

    T = exp((omega, v) amount), amount in [0, pi] [rad], or [m] of a translation; a clockwise turn has omega = -1. The
    identity has omega 0, amount 0 and v 0.

    Args:
        T: (*batch, 3, 3).
    """
    V = np.asarray(log(T))
    angle, distance = np.abs(V[..., 0]), np.linalg.norm(V[..., 1:], axis=-1)
    rotates = angle > TRANSLATION
    amount = np.where(rotates, angle, distance)
    omega = np.where(rotates, np.sign(V[..., 0]), 0.0)
    return omega, amount, V[..., 1:] / np.where(amount > 0, amount, 1.0)[..., None]


@compile_function("planar.about_pole")
def about_pole(psi: ScalarLike, point: Vector2Like) -> PlanarPose:
    """(*batch, 3, 3) displacement by an angle (*batch) [rad] about a point (*batch, 2) [m]."""
    ...


@compile_function("planar.twist_of_pole")
def twist_of_pole(omega: ScalarLike, point: Vector2Like) -> Vector3:
    """(*batch, 3) omega (1, q_y, -q_x): rotation at a rate (*batch) about a point (*batch, 2)."""
    ...


@compile_function("planar.adjoint")
def adjoint(T_ab: PlanarPoseLike) -> Matrix3:
    """(*batch, 3, 3) with V_a = Ad(T_ab) V_b for planar twists."""
    ...


@compile_function("planar.spatial_rotation")
def to_spatial_rotation(R: PlanarRotationLike) -> RotationMatrix:
    """(*batch, 3, 3) the planar rotation (*batch, 2, 2) as a rotation about z."""
    ...


@compile_function("planar.spatial_pose")
def to_spatial_pose(T: PlanarPoseLike) -> PoseMatrix:
    """(*batch, 4, 4) the planar pose (*batch, 3, 3) in the x-y plane of space."""
    ...


@compile_function("planar.spatial_twist")
def to_spatial_twist(V: Vector3Like) -> Vector6:
    """(*batch, 6) (0, 0, omega, v_x, v_y, 0): a screw parallel to z without pitch."""
    ...


def is_rotation(R: ArrayLike, tolerance: float = ROTATION) -> Truth:
    """(*batch) whether (*batch, 2, 2) matrices are rotations within the tolerance."""
    return membership.is_member("planar_rotation", as_batch("R", R, (2, 2)), tolerance)


def is_pose(T: ArrayLike, tolerance: float = ROTATION) -> Truth:
    """(*batch) whether (*batch, 3, 3) matrices are planar poses within the tolerance."""
    return membership.is_member("planar_pose", as_batch("T", T, (3, 3)), tolerance)
