"""Poses of constant frames as NumPy matrices: what tables and files of robots are built from, and written by."""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, cos, pi, sin
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix, Vector3, Vector6, as_batch, frozen
from mafsil.errors import InputError, ModelError
from mafsil.floating_point import EPS
from mafsil.lazy_module import lazily
from mafsil.model.tolerances import POLE, PRINTED_ROTATION

if TYPE_CHECKING:
    import mafsil.geometry.membership as membership
else:
    membership = lazily("mafsil.geometry.membership")


_QUARTER = pi / 2
_ROUNDING = 4 * EPS


def checked_pose(name: str, value: ArrayLike) -> PoseMatrix:
    """A pose (4, 4) as the user gave it, if it is one.

    Args:
        name: the argument's name, for the error.
        value: (4, 4) numbers.

    Raises:
        InputError: another shape, or NaN or infinite numbers.
        ModelError: the rotation block is no rotation or mirrors, or the last row is not 0, 0, 0, 1.

    Warns:
        InputWarning: digits of the rotation were left out, and the nearest one is taken.
    """
    T = checked_poses(name, value)
    if T.ndim != 2:
        raise InputError("input.shape", name=name, expected=(4, 4), got=T.shape, hint="")
    return T


def frozen_pose(name: str, value: ArrayLike) -> PoseMatrix:
    """As `checked_pose`, read-only: for fields."""
    return frozen(checked_pose(name, value))


def checked_poses(name: str, value: ArrayLike) -> PoseMatrix:
    """Poses (*batch, 4, 4) as the user gave them, if each is one; errors and warnings as of `checked_pose`.

    Args:
        name: the argument's name, for the error.
        value: (*batch, 4, 4) numbers.

    Raises:
        InputError, ModelError: as `checked_pose`.
    """
    T = as_batch(name, value, (4, 4), finite=True)
    if T.size == 0 or (_is_pose(T.tolist()) if T.ndim == 2 else _are_poses(T)):
        return T
    try:
        return membership.require("pose", name, T)
    except InputError as fault:
        raise ModelError(fault.key, **fault.details) from None


def _is_pose(T: list[list[float]]) -> bool:
    """Whether four rows are a pose; of one matrix NumPy spends ten times as long on it."""
    defects, determinant = _orthogonality(T)
    return (
        max(defects) <= PRINTED_ROTATION
        and min(defects) >= -PRINTED_ROTATION
        and determinant >= 0.0
        and T[3] == [0.0, 0.0, 0.0, 1.0]
    )


def _are_poses(T: PoseMatrix) -> bool:
    """Whether all matrices of a batch are poses: entry by entry, as NumPy is slow on many small matrices."""
    entries = np.ascontiguousarray(T.reshape(-1, 16).T).reshape(4, 4, -1)
    defects, determinant = _orthogonality(entries)
    off = max(float(np.abs(each).max()) for each in (*defects, *(entries[3] - [[0.0], [0.0], [0.0], [1.0]])))
    return off <= PRINTED_ROTATION and bool((determinant >= 0.0).all())


def _orthogonality(T: Any) -> tuple[tuple[Any, ...], Any]:
    """What the six products of the rows of a rotation are off by, and its determinant."""
    (a, b, c, _), (d, e, f, _), (g, h, i, _) = T[:3]
    lengths = a * a + b * b + c * c - 1.0, d * d + e * e + f * f - 1.0, g * g + h * h + i * i - 1.0
    angles = a * d + b * e + c * f, a * g + b * h + c * i, d * g + e * h + f * i
    return (*lengths, *angles), a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)


def cos_sin(angle: float) -> tuple[float, float]:
    """Cosine and sine of an angle [rad]; exact at whole quarter turns, so that no roundoff enters a robot."""
    quarters = angle / _QUARTER
    nearest = round(quarters)
    if abs(quarters - nearest) <= _ROUNDING * max(1.0, abs(quarters)):
        return ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[nearest % 4]
    return cos(angle), sin(angle)


def rotation_x(angle: float) -> PoseMatrix:
    """(4, 4) Rot(x, angle [rad])."""
    c, s = cos_sin(angle)
    return np.array([[1.0, 0, 0, 0], [0, c, -s, 0], [0, s, c, 0], [0, 0, 0, 1]])


def rotation_y(angle: float) -> PoseMatrix:
    """(4, 4) Rot(y, angle [rad])."""
    c, s = cos_sin(angle)
    return np.array([[c, 0, s, 0], [0, 1.0, 0, 0], [-s, 0, c, 0], [0, 0, 0, 1]])


def rotation_z(angle: float) -> PoseMatrix:
    """(4, 4) Rot(z, angle [rad])."""
    c, s = cos_sin(angle)
    return np.array([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1.0, 0], [0, 0, 0, 1]])


def translation(x: float, y: float, z: float) -> PoseMatrix:
    """(4, 4) Trans(x, y, z) [m]."""
    T = np.eye(4)
    T[:3, 3] = x, y, z
    return T


def pose_from_xyz_rpy(xyz: Sequence[float] | Vector3, rpy: Sequence[float] | Vector3) -> PoseMatrix:
    """(4, 4) Trans(xyz) Rot(z, yaw) Rot(y, pitch) Rot(x, roll), as URDF's `origin`.

    Args:
        xyz: (3,) [m].
        rpy: (3,) roll, pitch, yaw about the fixed x, y, z [rad].
    """
    roll, pitch, yaw = (float(angle) for angle in rpy)
    turned = rotation_z(yaw) @ rotation_y(pitch) @ rotation_x(roll)
    x, y, z = (float(length) for length in xyz)
    return translation(x, y, z) @ turned


def rotation_from_quaternion(wxyz: Floats) -> Floats:
    """Rotation matrix (3, 3) of a unit quaternion (w, x, y, z)."""
    w, x, y, z = wxyz
    return np.array(
        [
            [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
        ]
    )


def quaternion_length(numbers: Sequence[float]) -> float:
    """Length of a quaternion; 0.0 only if all its numbers are zero."""
    largest = max(map(abs, numbers))
    return largest * float(np.linalg.norm(np.asarray(numbers) / largest)) if largest else 0.0


def pose_from_xyz_quaternion(xyz: Sequence[float], xyzw: Sequence[float]) -> PoseMatrix:
    """(4, 4) pose of a place and a quaternion that need not have length 1, as files of robots write them.

    Args:
        xyz: (3,) [m].
        xyzw: (4,) x, y, z, w; not zero.
    """
    x, y, z, w = np.asarray(xyzw, dtype=float) / max(map(abs, xyzw))
    T = translation(*xyz)
    T[:3, :3] = rotation_from_quaternion(np.array([w, x, y, z]) / np.linalg.norm([w, x, y, z]))
    return T


def inverse(T: PoseMatrix) -> PoseMatrix:
    """(4, 4) inverse of one pose."""
    result = np.eye(4)
    result[:3, :3] = T[:3, :3].T
    result[:3, 3] = -T[:3, :3].T @ T[:3, 3]
    return result


def skew(w: Vector3) -> Floats:
    """(3, 3) matrix [w] with [w] p = w x p."""
    x, y, z = w
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def adjoint(T: PoseMatrix) -> Floats:
    """(6, 6) Ad(T) = [[R, 0], [[p] R, R]] for twists (omega, v)."""
    R, p = T[:3, :3], T[:3, 3]
    return np.block([[R, np.zeros((3, 3))], [skew(p) @ R, R]])


def screw_motion(S: Vector6, q: float) -> PoseMatrix:
    """(4, 4) exp([S] q) of a screw S = (omega, v), |omega| = 1, or omega = 0.

    Reference: Lynch & Park, Modern Robotics, prop. 3.25.
    """
    T = np.eye(4)
    omega, v = S[:3], S[3:]
    if not omega.any():
        T[:3, 3] = v * q
        return T
    c, s = cos_sin(q)
    W = skew(omega)
    T[:3, :3] += s * W + (1 - c) * (W @ W)
    T[:3, 3] = (q * np.eye(3) + (1 - c) * W + (q - s) * (W @ W)) @ v
    return T


def turned_tensor(inertia: Floats, R: Floats) -> Floats:
    """(3, 3) tensor R inertia R', symmetric to the last bit."""
    turned = R @ inertia @ R.T
    return frozen((turned + turned.T) / 2)


def frame_along(direction: Vector3) -> Floats:
    """(3, 3) shortest rotation that takes z onto a unit direction; half a turn about x for -z."""
    x, y, z = direction
    across = x * x + y * y
    if z < 0.0 and across == 0.0:
        return np.diag([1.0, -1.0, -1.0])
    W = skew(np.array([-y, x, 0.0]))
    return np.eye(3) + W + W @ W * ((1.0 - z) / across if z < 0.0 else 1.0 / (1.0 + z))


def rpy_from_rotation(R: Floats) -> tuple[float, float, float]:
    """Roll, pitch, yaw [rad] of a rotation matrix (3, 3).

    Yaw is found first and turned back; what remains is a turn about y and one about x, well conditioned everywhere.
    """
    yaw = atan2(R[1, 0], R[0, 0]) if max(abs(R[1, 0]), abs(R[0, 0])) > POLE else 0.0
    c, s = cos(yaw), sin(yaw)
    pitch = atan2(-R[2, 0], c * R[0, 0] + s * R[1, 0])
    roll = atan2(s * R[0, 2] - c * R[1, 2], c * R[1, 1] - s * R[0, 1])
    return roll, pitch, yaw
