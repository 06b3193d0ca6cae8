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
    gate,
)
from mafsil.geometry import membership
from mafsil.geometry.declared import Declared
from mafsil.geometry.euler import wrap_positive

_T = {"T": "planar_pose"}
_R = {"R": "planar_rotation"}

_rotation = Declared("planar.rotation", "theta", "R:2,2")
_angle = Declared("planar.angle", "R:2,2", "theta", _R)
_pose = Declared("planar.pose", "theta p:2", "T:3,3")
_coordinates = Declared("planar.coordinates", "T:3,3", "x:3", _T)
_inverse = Declared("planar.inverse", "T:3,3", "inverse:3,3", _T)
_compose = Declared("planar.compose", "T_ab:3,3 T_bc:3,3", "T_ac:3,3", {"T_ab": "planar_pose", "T_bc": "planar_pose"})
_exp = Declared("planar.exp", "V:3", "T:3,3", {"V": "planar_coordinates"})
_log = Declared("planar.log", "T:3,3", "V:3", _T)
_pole = Declared("planar.pole", "T:3,3", "pole:3", _T)
_about_pole = Declared("planar.about_pole", "psi point:2", "T:3,3")
_twist_of_pole = Declared("planar.twist_of_pole", "omega point:2", "V:3")
_adjoint = Declared("planar.adjoint", "T:3,3", "Ad:3,3", _T)
_spatial_rotation = Declared("planar.spatial_rotation", "R:2,2", "R_spatial:3,3", _R)
_spatial_pose = Declared("planar.spatial_pose", "T:3,3", "T_spatial:4,4", _T)
_spatial_twist = Declared("planar.spatial_twist", "V:3", "V_spatial:6")


def rotation(theta: ArrayLike) -> PlanarRotation:
    """(*batch, 2, 2) [[cos, -sin], [sin, cos]] of (*batch) angles [rad]."""
    return _rotation.at(theta)


def angle(R: ArrayLike) -> Scalar:
    """(*batch) angle in [0, 2 pi) [rad] of planar rotations (*batch, 2, 2)."""
    return wrap_positive(_angle.at(R))


def pose(theta: ArrayLike, p: ArrayLike) -> PlanarPose:
    """(*batch, 3, 3) planar pose of an angle (*batch) [rad] and an origin (*batch, 2) [m]."""
    return _pose.at(theta, p)


def coordinates(T: ArrayLike) -> Vector3:
    """(*batch, 3) (theta in [0, 2 pi), p_x, p_y) of planar poses (*batch, 3, 3)."""
    x = np.array(_coordinates.at(T))
    x[..., 0] = wrap_positive(x[..., 0])
    return x


def inverse(T: ArrayLike) -> PlanarPose:
    """(*batch, 3, 3) T^-1 = (R', -R'p)."""
    return _inverse.at(T)


def compose(T_ab: ArrayLike, T_bc: ArrayLike) -> PlanarPose:
    """(*batch, 3, 3) T_ac = (PQ, p + P q)."""
    return _compose.at(T_ab, T_bc)


def displacement(T_sb: ArrayLike, T_sc: ArrayLike) -> PlanarPose:
    """(*batch, 3, 3) T_sc T_sb^-1: carries a body from {b} to {c}, coordinates of {s}."""
    return compose(T_sc, inverse(T_sb))


def exp(V: ArrayLike) -> PlanarPose:
    """(*batch, 3, 3) displacement of planar exponential coordinates (omega, v_x, v_y) (*batch, 3) [rad, m]."""
    return _exp.at(V)


def log(T: ArrayLike) -> Vector3:
    """(*batch, 3) planar exponential coordinates (omega in (-pi, pi], v_x, v_y) of displacements (*batch, 3, 3)."""
    return _log.at(T)


def pole(T: ArrayLike) -> Vector3:
    """The point that a planar displacement keeps, in homogeneous coordinates.

    (p + cot(psi/2) J p) / 2, J a quarter turn; multiplied by sin(psi/2), so that translations have an answer too.

    Args:
        T: (*batch, 3, 3) displacement.

    Returns:
        (*batch, 3) (x, y, w): the pole is (x, y) / w; where w is 0 it is at infinity in the direction (x, y), across
        the translation. The identity gives (0, 0, 0): every point is kept.
    """
    return _pole.at(T)


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


def about_pole(psi: ArrayLike, point: ArrayLike) -> PlanarPose:
    """(*batch, 3, 3) displacement by an angle (*batch) [rad] about a point (*batch, 2) [m]."""
    return _about_pole.at(psi, point)


def twist_of_pole(omega: ArrayLike, point: ArrayLike) -> Vector3:
    """(*batch, 3) omega (1, q_y, -q_x): rotation at a rate (*batch) about a point (*batch, 2)."""
    return _twist_of_pole.at(omega, point)


def adjoint(T_ab: ArrayLike) -> Matrix3:
    """(*batch, 3, 3) with V_a = Ad(T_ab) V_b for planar twists."""
    return _adjoint.at(T_ab)


def to_spatial_rotation(R: ArrayLike) -> RotationMatrix:
    """(*batch, 3, 3) the planar rotation (*batch, 2, 2) as a rotation about z."""
    return _spatial_rotation.at(R)


def to_spatial_pose(T: ArrayLike) -> PoseMatrix:
    """(*batch, 4, 4) the planar pose (*batch, 3, 3) in the x-y plane of space."""
    return _spatial_pose.at(T)


def to_spatial_twist(V: ArrayLike) -> Vector6:
    """(*batch, 6) (0, 0, omega, v_x, v_y, 0): a screw parallel to z without pitch."""
    return _spatial_twist.at(V)


def is_rotation(R: ArrayLike, tolerance: float = ROTATION) -> Truth:
    """(*batch) whether (*batch, 2, 2) matrices are rotations within the tolerance."""
    return membership.is_member("planar_rotation", gate("R", R, (2, 2)), tolerance)


def is_pose(T: ArrayLike, tolerance: float = ROTATION) -> Truth:
    """(*batch) whether (*batch, 3, 3) matrices are planar poses within the tolerance."""
    return membership.is_member("planar_pose", gate("T", T, (3, 3)), tolerance)
