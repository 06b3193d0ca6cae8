"""Rotations as (3, 3) matrices and their coordinates; every function works on any batch, leading dimensions broadcast.

R_ab holds the axes of {b} as columns, in {a}. Angles in radians; quaternions (w, x, y, z).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.algebra.tolerance import ROTATION
from mafsil.arrays import Floats, Vector3, gate
from mafsil.errors import InputError
from mafsil.geometry import membership
from mafsil.geometry.declared import Declared
from mafsil.geometry.euler import from_davenport as from_davenport
from mafsil.geometry.euler import from_euler as from_euler
from mafsil.geometry.euler import from_rpy as from_rpy
from mafsil.geometry.euler import to_davenport as to_davenport
from mafsil.geometry.euler import to_euler as to_euler
from mafsil.geometry.euler import to_rpy as to_rpy
from mafsil.geometry.quaternion import from_quaternion as from_quaternion
from mafsil.geometry.quaternion import normalize_quaternion as normalize_quaternion
from mafsil.geometry.quaternion import to_quaternion as to_quaternion

_R = {"R": "rotation"}
_BOTH = {"R_0": "rotation", "R_1": "rotation"}
_VECTOR = {"r": "rotation_vector"}

_exp = Declared("so3.exp", "r:3", "R:3,3", _VECTOR)
_log = Declared("so3.log", "R:3,3", "r:3", _R)
_compose = Declared("so3.compose", "R_ab:3,3 R_bc:3,3", "R_ac:3,3", {"R_ab": "rotation", "R_bc": "rotation"})
_inverse = Declared("so3.inverse", "R:3,3", "inverse:3,3", _R)
_act = Declared("so3.act", "R:3,3 x:3", "y:3", _R)
_angle = Declared("so3.angle", "R:3,3", "angle", _R)
_angle_between = Declared("so3.angle_between", "R_0:3,3 R_1:3,3", "angle", _BOTH)
_axis_angle = Declared("so3.axis_angle", "axis:3 angle", "R:3,3", {"axis": "axis"})
_to_axis_angle = Declared("so3.to_axis_angle", "R:3,3", "axis:3 angle", _R)
_elementary = [Declared("euler.elementary_rotation", "angle", "R:3,3", {}, axis) for axis in range(3)]
_slerp = Declared("so3.slerp", "R_0:3,3 R_1:3,3 t", "R:3,3", _BOTH)
_project = Declared("so3.project", "M:3,3", "R:3,3")
_residuals = Declared("so3.residuals", "M:3,3", "residuals:7")
_hat = Declared("so3.hat", "w:3", "W:3,3")
_vee = Declared("so3.vee", "W:3,3", "w:3")
_left_jacobian = Declared("so3.left_jacobian", "r:3", "J:3,3", _VECTOR)
_left_jacobian_inverse = Declared("so3.left_jacobian_inverse", "r:3", "J:3,3", _VECTOR)
_right_jacobian = Declared("so3.right_jacobian", "r:3", "J:3,3", _VECTOR)
_right_jacobian_inverse = Declared("so3.right_jacobian_inverse", "r:3", "J:3,3", _VECTOR)


SKEWNESS = 1e-6
"""By how much W + W' may differ from zero, as a share of the largest entry: rounding, and differences of poses."""


def exp(r: ArrayLike) -> Floats:
    """Rotation of exponential coordinates: R = I + sin(theta)/theta [r] + (1 - cos(theta))/theta^2 [r]^2.

    Args:
        r: (*batch, 3) omega theta [rad], of any length up to 1e150; exact to rounding from 0 to beyond pi.

    Returns:
        (*batch, 3, 3).

    Raises:
        InputError: the square of the length overflows.

    Reference: Lynch & Park, Modern Robotics, prop. 3.11.
    """
    return _exp.at(r)


def log(R: ArrayLike) -> Vector3:
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
    return _log.at(R)


def angle(R: ArrayLike) -> Any:
    """(*batch) angle theta in [0, pi] [rad] of a rotation (*batch, 3, 3)."""
    return _angle.at(R)


def angle_between(R_0: ArrayLike, R_1: ArrayLike) -> Any:
    """(*batch) angle in [0, pi] [rad] of R_0' R_1, the shortest turn between two rotations (*batch, 3, 3)."""
    return _angle_between.at(R_0, R_1)


def from_axis_angle(axis: ArrayLike, angle: ArrayLike) -> Floats:
    """Rotation about an axis by the right-hand rule.

    Args:
        axis: (*batch, 3), any length but zero.
        angle: (*batch) [rad].

    Returns:
        (*batch, 3, 3).

    Raises:
        InputError: an axis is zero.
    """
    return _axis_angle.at(axis, angle)


def to_axis_angle(R: ArrayLike) -> tuple[Vector3, Any]:
    """Unit axis (*batch, 3) and angle (*batch) in [0, pi] [rad]; the identity has angle 0 and axis x."""
    return _to_axis_angle.at(R)


def rot_x(angle: ArrayLike) -> Floats:
    """(*batch, 3, 3) rotation about x by (*batch) angles [rad]."""
    return _elementary[0].at(angle)


def rot_y(angle: ArrayLike) -> Floats:
    """(*batch, 3, 3) rotation about y by (*batch) angles [rad]."""
    return _elementary[1].at(angle)


def rot_z(angle: ArrayLike) -> Floats:
    """(*batch, 3, 3) rotation about z by (*batch) angles [rad]."""
    return _elementary[2].at(angle)


def slerp(R_0: ArrayLike, R_1: ArrayLike, t: ArrayLike) -> Floats:
    """R_0 exp(t log(R_0' R_1)): from R_0 (t = 0) to R_1 (t = 1) at constant angular velocity, the short way.

    Args:
        R_0: (*batch, 3, 3).
        R_1: (*batch, 3, 3).
        t: (*batch), beyond [0, 1] too.

    Returns:
        (*batch, 3, 3).
    """
    return _slerp.at(R_0, R_1, t)


def project(M: ArrayLike) -> Floats:
    """The rotation nearest to a matrix in the Frobenius norm; never done unless asked for here.

    Args:
        M: (*batch, 3, 3) any matrix; a reflection too gets its nearest rotation.

    Returns:
        (*batch, 3, 3); of a matrix with several nearest rotations one of them.

    Reference: Horn, J. Opt. Soc. Am. A 4, 1987.
    """
    return _project.at(M)


def residuals(M: ArrayLike) -> Floats:
    """(*batch, 7): entries 11, 22, 33, 12, 13, 23 of M'M - I, then det M - 1, of (*batch, 3, 3) matrices."""
    return _residuals.at(M)


def is_rotation(M: ArrayLike, tolerance: float = ROTATION) -> Any:
    """(*batch) whether the Frobenius norm of M'M - I is within the tolerance and det M > 0."""
    return membership.is_member("rotation", M, tolerance)


def check(R: ArrayLike, name: str = "R", tolerance: float = ROTATION) -> Floats:
    """The array (*batch, 3, 3) itself, if all of it are rotations.

    Args:
        R: (*batch, 3, 3).
        name: what the error calls it.
        tolerance: largest Frobenius norm of R'R - I.

    Raises:
        InputError: names the first row that is not a rotation, its distance, the tolerance and the remedy.
    """
    return membership.require("rotation", name, R, tolerance)


def inverse(R: ArrayLike) -> Floats:
    """(*batch, 3, 3) transpose: R_ab^-1 = R_ba."""
    return _inverse.at(R)


def compose(R_ab: ArrayLike, R_bc: ArrayLike) -> Floats:
    """(*batch, 3, 3) R_ac = R_ab R_bc."""
    return _compose.at(R_ab, R_bc)


def apply(R: ArrayLike, x: ArrayLike) -> Vector3:
    """R x: a free vector x_b seen from {a} (R = R_ab), or a vector turned by R.

    Args:
        R: (*batch, 3, 3) rotation.
        x: (*batch, 3).

    Returns:
        (*batch, 3).
    """
    return _act.at(R, x)


def from_axes(x: ArrayLike, y: ArrayLike, z: ArrayLike) -> Floats:
    """R_ab from the unit axes of {b} seen from {a}: its columns.

    Args:
        x, y, z: (*batch, 3).

    Returns:
        (*batch, 3, 3).

    Raises:
        InputError: the axes are not unit, orthogonal and right-handed.
    """
    axes = np.broadcast_arrays(gate("x", x, (3,)), gate("y", y, (3,)), gate("z", z, (3,)))
    return check(np.stack(axes, axis=-1), "axes")


def hat(w: ArrayLike) -> Floats:
    """(*batch, 3, 3) skew matrix [w] with [w] x = w x x, of (*batch, 3)."""
    return _hat.at(w)


def vee(W: ArrayLike) -> Vector3:
    """(*batch, 3) w of skew matrices (*batch, 3, 3), within SKEWNESS of the largest entry.

    Raises:
        InputError: a matrix is not skew; take (W - W')/2 for the skew part of any matrix.
    """
    matrices = gate("W", W, (3, 3))
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
    return _vee.at(matrices)


def bracket(w_1: ArrayLike, w_2: ArrayLike) -> Vector3:
    """(*batch, 3) commutator of so(3): vee([w_1][w_2] - [w_2][w_1]) = w_1 x w_2.

    Args:
        w_1, w_2: (*batch, 3).

    Reference: Lynch & Park, Modern Robotics, sec. 8.2.2.
    """
    W_1, W_2 = hat(w_1), hat(w_2)
    return vee(W_1 @ W_2 - W_2 @ W_1)


def left_jacobian(r: ArrayLike) -> Floats:
    """(*batch, 3, 3) J with omega_s = J(r) rdot for R = exp(r), of (*batch, 3) [rad]."""
    return _left_jacobian.at(r)


def left_jacobian_inverse(r: ArrayLike) -> Floats:
    """(*batch, 3, 3) J(r)^-1, |r| < 2 pi."""
    return _left_jacobian_inverse.at(r)


def right_jacobian(r: ArrayLike) -> Floats:
    """(*batch, 3, 3) J(-r), with omega_b = J_r(r) rdot for R = exp(r)."""
    return _right_jacobian.at(r)


def right_jacobian_inverse(r: ArrayLike) -> Floats:
    """(*batch, 3, 3) inverse of the right Jacobian, |r| < 2 pi."""
    return _right_jacobian_inverse.at(r)


def random(rng: np.random.Generator, batch: int | tuple[int, ...] = ()) -> Floats:
    """(*batch, 3, 3) rotations, uniform over SO(3): normal quaternions have no preferred direction.

    Args:
        rng: NumPy generator.
        batch: leading shape.
    """
    shape = (batch,) if isinstance(batch, int) else batch
    return from_quaternion(normalize_quaternion(rng.standard_normal((*shape, 4))))
