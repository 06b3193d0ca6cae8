"""Poses and displacements as (4, 4) matrices T = [[R, p], [0, 1]]; any batch, leading dimensions broadcast.

T_ab is the pose of {b} in {a} (descriptive) and equally the displacement that carries a body from {a} to {b}
(prescriptive). Twists (omega, v), angular part first; radians, metres.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mafsil.algebra.tolerance import ROTATION
from mafsil.arrays import Matrix4, Matrix6, PoseMatrix, RotationMatrix, Truth, Vector3, Vector6, as_batch
from mafsil.geometry import membership, rotation
from mafsil.geometry.conditioned import (
    ExponentialCoordinatesLike,
    Matrix4Like,
    PoseLike,
    RotationLike,
    ScalarLike,
    Vector3Like,
    Vector6Like,
    compile_function,
)


@compile_function("se3.exp")
def exp(V: ExponentialCoordinatesLike) -> PoseMatrix:
    """Displacement of exponential coordinates V = (omega, v): T = (exp(omega), J(omega) v).

    Args:
        V: (*batch, 6) [rad, m]; omega of any length up to 1e150, zero included.

    Returns:
        (*batch, 4, 4).

    Reference: Lynch & Park, Modern Robotics, prop. 3.25.
    """
    ...


@compile_function("se3.log")
def log(T: PoseLike) -> Vector6:
    """Exponential coordinates V = (omega, v) of a displacement, |omega| in [0, pi].

    Args:
        T: (*batch, 4, 4) pose.

    Returns:
        (*batch, 6) [rad, m]; of the two answers at a half turn the one of `rotation.log`.

    Raises:
        InputError: T is not a pose.
    """
    ...


@compile_function("se3.inverse")
def inverse(T: PoseLike) -> PoseMatrix:
    """(*batch, 4, 4) T_ab^-1 = T_ba = (R', -R'p)."""
    ...


@compile_function("se3.compose")
def compose(T_ab: PoseLike, T_bc: PoseLike) -> PoseMatrix:
    """(*batch, 4, 4) T_ac = T_ab T_bc."""
    ...


@compile_function("se3.pose")
def from_rotation_translation(R: RotationLike, p: Vector3Like) -> PoseMatrix:
    """(*batch, 4, 4) pose of a rotation (*batch, 3, 3) and an origin (*batch, 3) [m].

    Raises:
        InputError: R is not a rotation.
    """
    ...


def from_translation(p: ArrayLike) -> PoseMatrix:
    """(*batch, 4, 4) translation by p (*batch, 3) [m]."""
    return from_rotation_translation(np.eye(3), p)


def rotation_of(T: ArrayLike) -> RotationMatrix:
    """(*batch, 3, 3) R of a pose: a view."""
    return as_batch("T", T, (4, 4))[..., :3, :3]


def translation_of(T: ArrayLike) -> Vector3:
    """(*batch, 3) p of a pose [m]: a view."""
    return as_batch("T", T, (4, 4))[..., :3, 3]


@compile_function("se3.act")
def act(T: PoseLike, x: Vector3Like) -> Vector3:
    """R x + p: a point x_b seen from {a} (T = T_ab), or a point displaced by T.

    Args:
        T: (*batch, 4, 4) pose.
        x: (*batch, 3) [m].

    Returns:
        (*batch, 3) [m].
    """
    ...


@compile_function("se3.adjoint")
def adjoint(T: PoseLike) -> Matrix6:
    """(*batch, 6, 6) Ad(T) = [[R, 0], [[p] R, R]]: V_a = Ad(T_ab) V_b, F_b = Ad(T_ab)' F_a."""
    ...


@compile_function("se3.body_error")
def error(T_sb: PoseLike, T_sd: PoseLike) -> Vector6:
    """Body twist that takes {b} to {d} in unit time: log(T_sb^-1 T_sd), in {b}.

    Args:
        T_sb: (*batch, 4, 4).
        T_sd: (*batch, 4, 4).

    Returns:
        (*batch, 6) [rad, m].
    """
    ...


@compile_function("se3.space_error")
def space_error(T_sb: PoseLike, T_sd: PoseLike) -> Vector6:
    """(*batch, 6) space twist that takes {b} to {d} in unit time: log(T_sd T_sb^-1), in {s}."""
    ...


def displacement(T_01: ArrayLike, T_02: ArrayLike) -> PoseMatrix:
    """(*batch, 4, 4) T_02 T_01^-1: carries a body from pose {1} to pose {2}, coordinates of {0}."""
    return compose(T_02, inverse(T_01))


@compile_function("se3.left_jacobian")
def left_jacobian(V: ExponentialCoordinatesLike) -> Matrix6:
    """(*batch, 6, 6) J with V_s = J(V) Vdot for T = exp(V).

    Reference: Barfoot, State Estimation for Robotics, eq. 7.85.
    """
    ...


@compile_function("se3.left_jacobian_inverse")
def left_jacobian_inverse(V: ExponentialCoordinatesLike) -> Matrix6:
    """(*batch, 6, 6) J(V)^-1, |omega| < 2 pi."""
    ...


@compile_function("se3.right_jacobian")
def right_jacobian(V: ExponentialCoordinatesLike) -> Matrix6:
    """(*batch, 6, 6) J(-V), with V_b = J_r(V) Vdot for T = exp(V)."""
    ...


@compile_function("se3.right_jacobian_inverse")
def right_jacobian_inverse(V: ExponentialCoordinatesLike) -> Matrix6:
    """(*batch, 6, 6) inverse of the right Jacobian, |omega| < 2 pi."""
    ...


@compile_function("se3.interpolate_screw")
def interpolate_screw(T_0: PoseLike, T_1: PoseLike, t: ScalarLike) -> PoseMatrix:
    """T_0 exp(t log(T_0^-1 T_1)): one screw motion from T_0 (t = 0) to T_1 (t = 1).

    Args:
        T_0: (*batch, 4, 4).
        T_1: (*batch, 4, 4).
        t: (*batch), beyond [0, 1] too.

    Returns:
        (*batch, 4, 4).
    """
    ...


@compile_function("se3.interpolate_decoupled")
def interpolate_decoupled(T_0: PoseLike, T_1: PoseLike, t: ScalarLike) -> PoseMatrix:
    """(*batch, 4, 4) rotation at constant angular velocity, origin along the straight line; arguments as above."""
    ...


@compile_function("spatial.hat")
def hat(V: Vector6Like) -> Matrix4:
    """(*batch, 4, 4) matrix [V] = [[ [omega], v ], [0, 0]] of twists (*batch, 6)."""
    ...


@compile_function("spatial.vee")
def vee(M: Matrix4Like) -> Vector6:
    """(*batch, 6) twist of matrices [V] (*batch, 4, 4); of the skew part where the upper left block is not skew."""
    ...


def is_pose(T: ArrayLike, tolerance: float = ROTATION) -> Truth:
    """(*batch) whether the rotation of T is one within the tolerance and its last row is (0, 0, 0, 1)."""
    return membership.is_member("pose", T, tolerance)


def check(T: ArrayLike, name: str = "T", tolerance: float | None = None) -> PoseMatrix:
    """The array (*batch, 4, 4) itself, if all of it are poses, with those mended that were printed with few digits.

    Args:
        T: (*batch, 4, 4).
        name: what the error calls it.
        tolerance: largest Frobenius norm of R'R - I; if given, nothing is mended.

    Raises:
        InputError: names the first row that is not a pose, its distance, the tolerance and the remedy.
    """
    return membership.require("pose", name, T, tolerance)


def project(T: ArrayLike) -> PoseMatrix:
    """(*batch, 4, 4) pose with the rotation nearest to the upper left block and the same origin; only on request."""
    array = as_batch("T", T, (4, 4))
    return from_rotation_translation(rotation.project(array[..., :3, :3]), array[..., :3, 3])
