"""Rotations by three successive angles: every Euler and roll-pitch-yaw convention, and general orthogonal axis triples.

A sequence is named by three letters: capitals for axes carried by the body (`ZYX`), small letters for fixed axes
(`xyz`), in the order in which the turns are listed; `ZYX` with (a, b, c) is `xyz` with (c, b, a). Angles in radians.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Annotated, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from mafsil.algebra.euler_sequence import SEQUENCES as SEQUENCES
from mafsil.algebra.euler_sequence import EulerSequence as EulerSequence
from mafsil.arrays import (
    Floats,
    Matrix3,
    Quaternion,
    RotationMatrix,
    Scalar,
    Shape,
    Truth,
    Vector3,
    as_batch,
    real_array,
)
from mafsil.errors import InputError
from mafsil.geometry.conditioned import AxisTripleLike, Conditioned, RotationLike, Vector3Like, compile_function
from mafsil.geometry.membership import Declared
from mafsil.geometry.tolerances import ROUNDOFF, SPECIAL

TwoTriples: TypeAlias = Annotated[Floats, Shape("*batch", 2, 3)]
"""(*batch, 2, 3) both triples of angles of a rotation [rad]."""


def from_euler(angles: ArrayLike, sequence: str) -> RotationMatrix:
    """Rotation of three angles.

    Args:
        angles: (*batch, 3) [rad], in the order of the letters.
        sequence: such as `ZYX` (body axes) or `xyz` (fixed axes).

    Returns:
        (*batch, 3, 3).

    Raises:
        InputError: the sequence is not one of the 24.

    Reference: Lynch & Park, Modern Robotics, app. B.
    """
    return _kernels(sequence).matrix.at(angles)


def to_euler(R: ArrayLike, sequence: str) -> Vector3:
    """Principal angles of a rotation; `solutions` gives all.

    Middle angle in [-pi/2, pi/2], or in [0, pi] where first and third axis are equal; the others in (-pi, pi]. At a
    gimbal lock the leftmost factor of R gets angle zero.

    Args:
        R: (*batch, 3, 3) rotation.
        sequence: such as `ZYX` or `xyz`.

    Returns:
        (*batch, 3) [rad]; R is recovered to rounding everywhere, at and near gimbal locks too.
    """
    return _kernels(sequence).principal.at(R)


def from_rpy(rpy: ArrayLike) -> RotationMatrix:
    """Rotation of roll, pitch, yaw about the fixed axes x, y, z: R = Rot(z, yaw) Rot(y, pitch) Rot(x, roll).

    Args:
        rpy: (*batch, 3) [rad].

    Returns:
        (*batch, 3, 3).
    """
    return _kernels("xyz").matrix.at(rpy)


def to_rpy(R: ArrayLike) -> Vector3:
    """Roll, pitch, yaw (*batch, 3) [rad] of (*batch, 3, 3), pitch in [-pi/2, pi/2]; at pitch +-pi/2 yaw is 0."""
    return _kernels("xyz").principal.at(R)


def quaternion_from_euler(angles: ArrayLike, sequence: str) -> Quaternion:
    """(*batch, 4) unit quaternion of three angles (*batch, 3) [rad]."""
    return _kernels(sequence).quaternion.at(angles)


@compile_function("euler.davenport_matrix")
def from_davenport(angles: Vector3Like, axes: AxisTripleLike) -> RotationMatrix:
    """Rotation by three angles about general axes: R = Rot(n1, a) Rot(n2, b) Rot(n3, c).

    Args:
        angles: (*batch, 3) [rad].
        axes: (*batch, 3, 3) unit axes n1, n2, n3 as rows, n2 orthogonal to n1 and n3.

    Returns:
        (*batch, 3, 3).

    Raises:
        InputError: the axes are not such; triples of other axes leave orientations out of reach.

    Reference: Shuster & Markley, Generalization of the Euler angles, J. Astronautical Sciences 51, 2003.
    """
    ...


@compile_function("euler.davenport_angles")
def to_davenport(R: RotationLike, axes: AxisTripleLike) -> TwoTriples:
    """Both angle triples (*batch, 2, 3) [rad] of rotations (*batch, 3, 3) about general axes; see `from_davenport`."""
    ...


def rates_to_angular_velocity(angles: ArrayLike, sequence: str) -> Matrix3:
    """(*batch, 3, 3) E with omega_s = E (angle rates); its determinant vanishes at gimbal locks.

    Args:
        angles: (*batch, 3) [rad].
        sequence: such as `ZYX` or `xyz`.
    """
    return _kernels(sequence).rates.at(angles)


@dataclass(frozen=True)
class EulerSolutions:
    """All angle triples of rotations.

    Attributes:
        angles: (*batch, 2, 3) [rad], row 0 principal; away from locks these two are all, up to turns by 2 pi.
        locked: (*batch) whether the rotation is at a gimbal lock: then the triples are members of a family.
        direction: (3,) the change of angles that changes nothing at the lock, per row: (*batch, 3), zero elsewhere.
    """

    angles: TwoTriples
    locked: Truth
    direction: Vector3

    def family(self, t: ArrayLike) -> Vector3:
        """(*batch, 3) members of the family at the parameter t [rad]: principal + t direction."""
        return self.angles[..., 0, :] + np.asarray(t, dtype=np.float64)[..., None] * self.direction

    def positive(self) -> TwoTriples:
        """(*batch, 2, 3) the angles in [0, 2 pi)."""
        return wrap_positive(self.angles)


def solutions(R: ArrayLike, sequence: str, tolerance: float = SPECIAL) -> EulerSolutions:
    """All angle triples of rotations: two, or a family of one parameter at gimbal locks.

    Args:
        R: (*batch, 3, 3) rotation.
        sequence: such as `ZYX` or `xyz`.
        tolerance: angle [rad] to a lock within which it counts as one.
    """
    known = sequence_named(sequence)
    angles = _kernels(sequence).angles(R)
    axes = np.eye(3)[list(known.body_axes)]
    locked = np.asarray(_gimbal_distance(R, axes)) <= tolerance
    # cos(b + lambda) = n1 . R n3 tells which lock it is: at +1 the axes agree and a + c is fixed, at -1 they oppose.
    agree = np.asarray(as_batch("R", R, (3, 3)))[..., known.body_axes[0], known.body_axes[2]] > 0
    third = np.where(agree, -1.0, 1.0)
    direction = np.stack([np.ones_like(third), np.zeros_like(third), third], axis=-1) * locked[..., None]
    return EulerSolutions(angles, locked, direction)


def to_fixed(angles: ArrayLike, sequence: str) -> tuple[Vector3, str]:
    """The same rotation in the other reading, axes fixed: order and letters reversed; fixed sequences stay."""
    known = sequence_named(sequence)
    array = as_batch("angles", angles, (3,))
    return (array, sequence) if known.fixed else (array[..., ::-1], sequence[::-1].lower())


def to_moving(angles: ArrayLike, sequence: str) -> tuple[Vector3, str]:
    """The same rotation in the other reading, axes carried by the body; moving sequences stay as they are."""
    known = sequence_named(sequence)
    array = as_batch("angles", angles, (3,))
    return (array[..., ::-1], sequence[::-1].upper()) if known.fixed else (array, sequence)


def range_of_middle(sequence: str) -> tuple[float, float]:
    """Where the principal middle angle lies [rad]: [0, pi] if first and third axis are equal, else [-pi/2, pi/2]."""
    first, _, third = sequence_named(sequence).body_axes
    return (0.0, np.pi) if first == third else (-np.pi / 2, np.pi / 2)


def is_principal(angles: ArrayLike, sequence: str, tolerance: float = ROUNDOFF) -> Truth:
    """(*batch) whether angles are in their principal ranges: outer ones in (-pi, pi], the middle one in its half turn.

    Args:
        angles: (*batch, 3) [rad].
        sequence: such as `ZYX` or `xyz`.
        tolerance: angle [rad] beyond the ends that is rounding.
    """
    array = as_batch("angles", angles, (3,))
    low, high = range_of_middle(sequence)
    outer, middle = array[..., ::2], array[..., 1]
    inside = ((outer > -np.pi) & (outer <= np.pi + tolerance)).all(-1)
    return inside & (middle >= low - tolerance) & (middle <= high + tolerance)


def require_principal(angles: ArrayLike, sequence: str, tolerance: float = ROUNDOFF) -> Vector3:
    """The angles (*batch, 3) themselves, if `is_principal` holds for all rows.

    Args:
        angles: (*batch, 3) [rad].
        sequence: such as `ZYX` or `xyz`.
        tolerance: angle [rad] beyond the ends that is rounding.

    Raises:
        InputError: names the first row that is not, and the ranges; `to_euler` of the rotation gives principal angles.
    """
    array = as_batch("angles", angles, (3,))
    outside = ~np.asarray(is_principal(array, sequence, tolerance)) & ~np.isnan(array).any(-1)
    if outside.any():
        index = tuple(int(i) for i in np.argwhere(outside)[0])
        low, high = np.degrees(range_of_middle(sequence))
        place = f"[{', '.join(map(str, index))}]" if index else ""
        given = np.degrees(array[index]).tolist()
        raise InputError(
            "geometry.angle_ranges", name=f"angles{place}", value=given, sequence=sequence, low=low, high=high
        )
    return array


def wrap_positive(angles: ArrayLike) -> Floats:
    """Angles [rad] of any shape brought into [0, 2 pi)."""
    wrapped = np.mod(real_array("angles", angles), 2 * np.pi)
    return np.where(wrapped >= 2 * np.pi, 0.0, wrapped)


def wrap_symmetric(angles: ArrayLike) -> Floats:
    """Angles [rad] of any shape brought into (-pi, pi]."""
    return np.pi - wrap_positive(np.pi - real_array("angles", angles))


def sequence_named(name: str) -> EulerSequence:
    """The sequence of a name.

    Raises:
        InputError: unknown; the sentence lists all 24.
    """
    if name not in SEQUENCES:
        raise InputError("input.choice", name="sequence", value=name, known=", ".join(SEQUENCES))
    return SEQUENCES[name]


@compile_function("euler.gimbal_distance")
def _gimbal_distance(R: RotationLike, axes: AxisTripleLike) -> Scalar: ...


class _SequenceKernels:
    """The compiled functions of one sequence."""

    def __init__(self, name: str) -> None:
        of_rotation = {"R": "rotation"}
        self.matrix = Declared("euler.matrix", "angles:3", "R:3,3", name)
        self.angles = Conditioned("euler.angles", "R:3,3", "angles:2,3", name, conditions=of_rotation)
        self.principal = Conditioned("euler.principal_angles", "R:3,3", "angles:3", name, conditions=of_rotation)
        self.quaternion = Declared("euler.to_quaternion", "angles:3", "q:4", name)
        self.rates = Declared("euler.rate_matrix", "angles:3", "E:3,3", name)


@cache
def _kernels(sequence: str) -> _SequenceKernels:
    return _SequenceKernels(sequence_named(sequence).name)
