"""Poses and displacements as (4, 4) matrices T = [[R, p], [0, 1]]; any batch, leading dimensions broadcast.

T_ab is the pose of {b} in {a} (descriptive) and equally the displacement that carries a body from {a} to {b}
(prescriptive). Twists (omega, v), angular part first; radians, metres.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.algebra.tolerance import ROTATION
from mafsil.arrays import Floats, PoseMatrix, Vector3, Vector6, gate
from mafsil.geometry import membership
from mafsil.geometry.declared import Declared

_T = {"T": "pose"}
_BOTH = {"T_0": "pose", "T_1": "pose"}
_COORDINATES = {"V": "exponential_coordinates"}

_exp = Declared("se3.exp", "V:6", "T:4,4", _COORDINATES)
_log = Declared("se3.log", "T:4,4", "V:6", _T)
_inverse = Declared("se3.inverse", "T:4,4", "inverse:4,4", _T)
_compose = Declared("se3.compose", "T_ab:4,4 T_bc:4,4", "T_ac:4,4", {"T_ab": "pose", "T_bc": "pose"})
_pose = Declared("se3.pose", "R:3,3 p:3", "T:4,4", {"R": "rotation"})
_act = Declared("se3.act", "T:4,4 x:3", "y:3", _T)
_adjoint = Declared("se3.adjoint", "T:4,4", "Ad:6,6", _T)
_error = Declared("se3.body_error", "T_sb:4,4 T_sd:4,4", "V_b:6", {"T_sb": "pose", "T_sd": "pose"})
_space_error = Declared("se3.space_error", "T_sb:4,4 T_sd:4,4", "V_s:6", {"T_sb": "pose", "T_sd": "pose"})
_left_jacobian = Declared("se3.left_jacobian", "V:6", "J:6,6", _COORDINATES)
_left_jacobian_inverse = Declared("se3.left_jacobian_inverse", "V:6", "J:6,6", _COORDINATES)
_right_jacobian = Declared("se3.right_jacobian", "V:6", "J:6,6", _COORDINATES)
_right_jacobian_inverse = Declared("se3.right_jacobian_inverse", "V:6", "J:6,6", _COORDINATES)
_interpolate_screw = Declared("se3.interpolate_screw", "T_0:4,4 T_1:4,4 t", "T:4,4", _BOTH)
_interpolate_decoupled = Declared("se3.interpolate_decoupled", "T_0:4,4 T_1:4,4 t", "T:4,4", _BOTH)
_hat = Declared("spatial.hat", "V:6", "M:4,4")
_vee = Declared("spatial.vee", "M:4,4", "V:6")


def exp(V: ArrayLike) -> PoseMatrix:
    """Displacement of exponential coordinates V = (omega, v): T = (exp(omega), J(omega) v).

    Args:
        V: (*batch, 6) [rad, m]; omega of any length up to 1e150, zero included.

    Returns:
        (*batch, 4, 4).

    Reference: Lynch & Park, Modern Robotics, prop. 3.25.
    """
    return _exp.at(V)


def log(T: ArrayLike) -> Vector6:
    """Exponential coordinates V = (omega, v) of a displacement, |omega| in [0, pi].

    Args:
        T: (*batch, 4, 4) pose.

    Returns:
        (*batch, 6) [rad, m]; of the two answers at a half turn the one of `rotation.log`.

    Raises:
        InputError: T is not a pose.
    """
    return _log.at(T)


def inverse(T: ArrayLike) -> PoseMatrix:
    """(*batch, 4, 4) T_ab^-1 = T_ba = (R', -R'p)."""
    return _inverse.at(T)


def compose(T_ab: ArrayLike, T_bc: ArrayLike) -> PoseMatrix:
    """(*batch, 4, 4) T_ac = T_ab T_bc."""
    return _compose.at(T_ab, T_bc)


def from_rotation_translation(R: ArrayLike, p: ArrayLike) -> PoseMatrix:
    """(*batch, 4, 4) pose of a rotation (*batch, 3, 3) and an origin (*batch, 3) [m].

    Raises:
        InputError: R is not a rotation.
    """
    return _pose.at(R, p)


def from_translation(p: ArrayLike) -> PoseMatrix:
    """(*batch, 4, 4) translation by p (*batch, 3) [m]."""
    return from_rotation_translation(np.eye(3), p)


def rotation_of(T: ArrayLike) -> Floats:
    """(*batch, 3, 3) R of a pose: a view."""
    return gate("T", T, (4, 4))[..., :3, :3]


def translation_of(T: ArrayLike) -> Vector3:
    """(*batch, 3) p of a pose [m]: a view."""
    return gate("T", T, (4, 4))[..., :3, 3]


def act(T: ArrayLike, x: ArrayLike) -> Vector3:
    """R x + p: a point x_b seen from {a} (T = T_ab), or a point displaced by T.

    Args:
        T: (*batch, 4, 4) pose.
        x: (*batch, 3) [m].

    Returns:
        (*batch, 3) [m].
    """
    return _act.at(T, x)


def adjoint(T: ArrayLike) -> Floats:
    """(*batch, 6, 6) Ad(T) = [[R, 0], [[p] R, R]]: V_a = Ad(T_ab) V_b, F_b = Ad(T_ab)' F_a."""
    return _adjoint.at(T)


def error(T_sb: ArrayLike, T_sd: ArrayLike) -> Vector6:
    """Body twist that takes {b} to {d} in unit time: log(T_sb^-1 T_sd), in {b}.

    Args:
        T_sb: (*batch, 4, 4).
        T_sd: (*batch, 4, 4).

    Returns:
        (*batch, 6) [rad, m].
    """
    return _error.at(T_sb, T_sd)


def space_error(T_sb: ArrayLike, T_sd: ArrayLike) -> Vector6:
    """(*batch, 6) space twist that takes {b} to {d} in unit time: log(T_sd T_sb^-1), in {s}."""
    return _space_error.at(T_sb, T_sd)


def displacement(T_01: ArrayLike, T_02: ArrayLike) -> PoseMatrix:
    """(*batch, 4, 4) T_02 T_01^-1: carries a body from pose {1} to pose {2}, coordinates of {0}."""
    return compose(T_02, inverse(T_01))


def left_jacobian(V: ArrayLike) -> Floats:
    """(*batch, 6, 6) J with V_s = J(V) Vdot for T = exp(V).

    Reference: Barfoot, State Estimation for Robotics, eq. 7.85.
    """
    return _left_jacobian.at(V)


def left_jacobian_inverse(V: ArrayLike) -> Floats:
    """(*batch, 6, 6) J(V)^-1, |omega| < 2 pi."""
    return _left_jacobian_inverse.at(V)


def right_jacobian(V: ArrayLike) -> Floats:
    """(*batch, 6, 6) J(-V), with V_b = J_r(V) Vdot for T = exp(V)."""
    return _right_jacobian.at(V)


def right_jacobian_inverse(V: ArrayLike) -> Floats:
    """(*batch, 6, 6) inverse of the right Jacobian, |omega| < 2 pi."""
    return _right_jacobian_inverse.at(V)


def interpolate_screw(T_0: ArrayLike, T_1: ArrayLike, t: ArrayLike) -> PoseMatrix:
    """T_0 exp(t log(T_0^-1 T_1)): one screw motion from T_0 (t = 0) to T_1 (t = 1).

    Args:
        T_0: (*batch, 4, 4).
        T_1: (*batch, 4, 4).
        t: (*batch), beyond [0, 1] too.

    Returns:
        (*batch, 4, 4).
    """
    return _interpolate_screw.at(T_0, T_1, t)


def interpolate_decoupled(T_0: ArrayLike, T_1: ArrayLike, t: ArrayLike) -> PoseMatrix:
    """(*batch, 4, 4) rotation at constant angular velocity, origin along the straight line; arguments as above."""
    return _interpolate_decoupled.at(T_0, T_1, t)


def hat(V: ArrayLike) -> Floats:
    """(*batch, 4, 4) matrix [V] = [[ [omega], v ], [0, 0]] of twists (*batch, 6)."""
    return _hat.at(V)


def vee(M: ArrayLike) -> Vector6:
    """(*batch, 6) twist of matrices [V] (*batch, 4, 4); of the skew part where the upper left block is not skew."""
    return _vee.at(M)


def is_pose(T: ArrayLike, tolerance: float = ROTATION) -> Any:
    """(*batch) whether the rotation of T is one within the tolerance and its last row is (0, 0, 0, 1)."""
    return membership.is_member("pose", T, tolerance)


def check(T: ArrayLike, name: str = "T", tolerance: float = ROTATION) -> PoseMatrix:
    """The array (*batch, 4, 4) itself, if all of it are poses.

    Args:
        T: (*batch, 4, 4).
        name: what the error calls it.
        tolerance: largest Frobenius norm of R'R - I.

    Raises:
        InputError: names the first row that is not a pose, its distance, the tolerance and the remedy.
    """
    return membership.require("pose", name, T, tolerance)


def project(T: ArrayLike) -> PoseMatrix:
    """(*batch, 4, 4) pose with the rotation nearest to the upper left block and the same origin; only when asked."""
    from mafsil.geometry import rotation

    array = gate("T", T, (4, 4))
    return from_rotation_translation(rotation.project(array[..., :3, :3]), array[..., :3, 3])
