"""Rotations as (3, 3) matrices and their coordinates; every function works on any batch, leading dimensions broadcast.

R_ab holds the axes of {b} as columns, in {a}. Angles in radians; quaternions (w, x, y, z).
"""

from __future__ import annotations

from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from mafsil.algebra.tolerance import ROTATION
from mafsil.arrays import Floats, Matrix3, RotationMatrix, Scalar, Shape, Truth, Vector3, as_batch
from mafsil.errors import InputError
from mafsil.geometry import membership
from mafsil.geometry.conditioned import (
    AxisLike,
    Matrix3Like,
    RotationLike,
    RotationVectorLike,
    ScalarLike,
    Vector3Like,
    compile_function,
)
from mafsil.geometry.euler import from_davenport as from_davenport
from mafsil.geometry.euler import from_euler as from_euler
from mafsil.geometry.euler import from_rpy as from_rpy
from mafsil.geometry.euler import to_davenport as to_davenport
from mafsil.geometry.euler import to_euler as to_euler
from mafsil.geometry.euler import to_rpy as to_rpy
from mafsil.geometry.quaternion import from_quaternion as from_quaternion
from mafsil.geometry.quaternion import normalise_quaternion as normalise_quaternion
from mafsil.geometry.quaternion import to_quaternion as to_quaternion
from mafsil.geometry.tolerances import SKEWNESS


@compile_function("so3.exp")
def exp(r: RotationVectorLike) -> RotationMatrix:
    """Rotation of exponential coordinates: R = I + sin(theta)/theta [r] + (1 - cos(theta))/theta^2 [r]^2.

    Args:
        r: (*batch, 3) omega theta [rad], of any length up to 1e150; exact to rounding from 0 to beyond pi.

    Returns:
        (*batch, 3, 3).

    Raises:
        InputError: the square of the length overflows.

    Reference: Lynch & Park, Modern Robotics, prop. 3.11.
    """
    ...


@compile_function("so3.log")
def log(R: RotationLike) -> Vector3:
    """Principal exponential coordinates r = omega theta of a rotation, theta in [0, pi].

    At a half turn r and -r are equally right; the one whose largest component is positive is returned. All answers:
    `mafsil.geometry.logarithms`.

    Args:
        R: (*batch, 3, 3) rotation.

    Returns:
        (*batch, 3) [rad]; relative accuracy is kept down to angles of 1e-300.

    Raises:
        InputError: R is not a rotation within `tolerance.ROTATION`.
    """
    ...


@compile_function("so3.angle")
def angle(R: RotationLike) -> Scalar:
    """(*batch) angle theta in [0, pi] [rad] of a rotation (*batch, 3, 3)."""
    ...


@compile_function("so3.angle_between")
def angle_between(R_0: RotationLike, R_1: RotationLike) -> Scalar:
    """(*batch) angle in [0, pi] [rad] of R_0' R_1, the shortest turn between two rotations (*batch, 3, 3)."""
    ...


@compile_function("so3.axis_angle")
def from_axis_angle(axis: AxisLike, angle: ScalarLike) -> RotationMatrix:
    """Rotation about an axis by the right-hand rule.

    Args:
        axis: (*batch, 3), any length but zero.
        angle: (*batch) [rad].

    Returns:
        (*batch, 3, 3).

    Raises:
        InputError: an axis is zero.
    """
    ...


@compile_function("so3.to_axis_angle")
def to_axis_angle(R: RotationLike) -> tuple[Vector3, Scalar]:
    """Unit axis (*batch, 3) and angle (*batch) in [0, pi] [rad]; the identity has angle 0 and axis x."""
    ...


@compile_function("euler.elementary_rotation", 0)
def rot_x(angle: ScalarLike) -> RotationMatrix:
    """(*batch, 3, 3) rotation about x by (*batch) angles [rad]."""
    ...


@compile_function("euler.elementary_rotation", 1)
def rot_y(angle: ScalarLike) -> RotationMatrix:
    """(*batch, 3, 3) rotation about y by (*batch) angles [rad]."""
    ...


@compile_function("euler.elementary_rotation", 2)
def rot_z(angle: ScalarLike) -> RotationMatrix:
    """(*batch, 3, 3) rotation about z by (*batch) angles [rad]."""
    ...


@compile_function("so3.slerp")
def slerp(R_0: RotationLike, R_1: RotationLike, t: ScalarLike) -> RotationMatrix:
    """R_0 exp(t log(R_0' R_1)): from R_0 (t = 0) to R_1 (t = 1) at constant angular velocity, the short way.

    Args:
        R_0: (*batch, 3, 3).
        R_1: (*batch, 3, 3).
        t: (*batch), beyond [0, 1] too.

    Returns:
        (*batch, 3, 3).
    """
    ...


@compile_function("so3.project")
def project(M: Matrix3Like) -> RotationMatrix:
    """The rotation nearest to a matrix in the Frobenius norm; never done unless asked for here.

    Args:
        M: (*batch, 3, 3) any matrix; a reflection too gets its nearest rotation.

    Returns:
        (*batch, 3, 3); of a matrix with several nearest rotations one of them.

    Reference: Horn, J. Opt. Soc. Am. A 4, 1987.
    """
    ...


@compile_function("so3.residuals")
def residuals(M: Matrix3Like) -> Annotated[Floats, Shape("*batch", 7)]:
    """(*batch, 7): entries 11, 22, 33, 12, 13, 23 of M'M - I, then det M - 1, of (*batch, 3, 3) matrices."""
    ...


def is_rotation(M: ArrayLike, tolerance: float = ROTATION) -> Truth:
    """(*batch) whether the Frobenius norm of M'M - I is within the tolerance and det M > 0."""
    return membership.is_member("rotation", M, tolerance)


def check(R: ArrayLike, name: str = "R", tolerance: float | None = None) -> RotationMatrix:
    """The array (*batch, 3, 3) itself, if all of it are rotations, with those mended that were printed with few digits.

    Args:
        R: (*batch, 3, 3).
        name: what the error calls it.
        tolerance: largest Frobenius norm of R'R - I; if given, nothing is mended.

    Raises:
        InputError: names the first row that is not a rotation, its distance, the tolerance and the remedy.
    """
    return membership.require("rotation", name, R, tolerance)


@compile_function("so3.inverse")
def inverse(R: RotationLike) -> RotationMatrix:
    """(*batch, 3, 3) transpose: R_ab^-1 = R_ba."""
    ...


@compile_function("so3.compose")
def compose(R_ab: RotationLike, R_bc: RotationLike) -> RotationMatrix:
    """(*batch, 3, 3) R_ac = R_ab R_bc."""
    ...


@compile_function("so3.act")
def apply(R: RotationLike, x: Vector3Like) -> Vector3:
    """R x: a free vector x_b seen from {a} (R = R_ab), or a vector turned by R.

    Args:
        R: (*batch, 3, 3) rotation.
        x: (*batch, 3).

    Returns:
        (*batch, 3).
    """
    ...


def from_axes(x: ArrayLike, y: ArrayLike, z: ArrayLike) -> RotationMatrix:
    """R_ab from the unit axes of {b} seen from {a}: its columns.

    Args:
        x, y, z: (*batch, 3).

    Returns:
        (*batch, 3, 3).

    Raises:
        InputError: the axes are not unit, orthogonal and right-handed.
    """
    axes = np.broadcast_arrays(as_batch("x", x, (3,)), as_batch("y", y, (3,)), as_batch("z", z, (3,)))
    return check(np.stack(axes, axis=-1), "axes")


@compile_function("so3.hat")
def hat(w: Vector3Like) -> Matrix3:
    """(*batch, 3, 3) skew matrix [w] with [w] x = w x x, of (*batch, 3)."""
    ...


@compile_function("so3.vee")
def _vee(W: Matrix3Like) -> Vector3: ...


def vee(W: ArrayLike) -> Vector3:
    """(*batch, 3) w of skew matrices (*batch, 3, 3), within SKEWNESS of the largest entry.

    Raises:
        InputError: a matrix is not skew; take (W - W')/2 for the skew part of any matrix.
    """
    matrices = as_batch("W", W, (3, 3))
    off = np.abs(matrices + np.swapaxes(matrices, -1, -2)).max(axis=(-2, -1))
    refused = off > SKEWNESS * np.abs(matrices).max(axis=(-2, -1), initial=0.0)
    if refused.any():
        index = tuple(int(k) for k in np.argwhere(refused)[0])
        raise InputError(
            "geometry.not_skew",
            name=f"W[{', '.join(map(str, index))}]" if index else "W",
            distance=float(off[index]),
            limit=SKEWNESS,
        )
    return _vee(matrices)


def bracket(w_1: ArrayLike, w_2: ArrayLike) -> Vector3:
    """(*batch, 3) commutator of so(3): vee([w_1][w_2] - [w_2][w_1]) = w_1 x w_2.

    Args:
        w_1, w_2: (*batch, 3).

    Reference: Lynch & Park, Modern Robotics, sec. 8.2.2.
    """
    W_1, W_2 = hat(w_1), hat(w_2)
    return vee(W_1 @ W_2 - W_2 @ W_1)


@compile_function("so3.left_jacobian")
def left_jacobian(r: RotationVectorLike) -> Matrix3:
    """(*batch, 3, 3) J with omega_s = J(r) rdot for R = exp(r), of (*batch, 3) [rad]."""
    ...


@compile_function("so3.left_jacobian_inverse")
def left_jacobian_inverse(r: RotationVectorLike) -> Matrix3:
    """(*batch, 3, 3) J(r)^-1, |r| < 2 pi."""
    ...


@compile_function("so3.right_jacobian")
def right_jacobian(r: RotationVectorLike) -> Matrix3:
    """(*batch, 3, 3) J(-r), with omega_b = J_r(r) rdot for R = exp(r)."""
    ...


@compile_function("so3.right_jacobian_inverse")
def right_jacobian_inverse(r: RotationVectorLike) -> Matrix3:
    """(*batch, 3, 3) inverse of the right Jacobian, |r| < 2 pi."""
    ...


def random(seed: int | np.random.Generator, batch: int | tuple[int, ...] = ()) -> RotationMatrix:
    """(*batch, 3, 3) rotations, uniform over SO(3): normal quaternions have no preferred direction.

    Args:
        seed: of the random numbers: a whole number, or a NumPy generator, which moves on.
        batch: leading shape.
    """
    shape = (batch,) if isinstance(batch, int) else batch
    rng = np.random.default_rng(seed)
    return from_quaternion(normalise_quaternion(rng.standard_normal((*shape, 4))))
