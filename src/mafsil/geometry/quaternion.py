"""Unit quaternions (w, x, y, z) and the numbers that hang on them; any batch, leading dimensions broadcast."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.algebra.tolerance import UNIT
from mafsil.arrays import Floats, Quaternion, RotationMatrix, Scalar, Shape, Truth, Vector3, as_batch
from mafsil.errors import InputError
from mafsil.geometry.conditioned import (
    NonzeroQuaternionLike,
    QuaternionLike,
    RotationLike,
    RotationVectorLike,
    ScalarLike,
    UnitQuaternionLike,
    Vector3Like,
    compile_function,
)
from mafsil.geometry.tolerances import ROUNDOFF

EIGHT = Shape("*batch", 8)
"""Real and imaginary parts of a (2, 2) complex matrix, row by row."""


@compile_function("quaternion.from_matrix")
def to_quaternion(R: RotationLike) -> Quaternion:
    """Unit quaternion of a rotation; of q and -q the one with w >= 0 (at half turns: first non-zero number positive).

    Args:
        R: (*batch, 3, 3) rotation.

    Returns:
        (*batch, 4) (w, x, y, z).

    Raises:
        InputError: R is not a rotation within `tolerance.ROTATION`.

    Reference: Shepperd, J. Guidance and Control 1, 1978.
    """
    ...


@compile_function("quaternion.to_matrix")
def from_quaternion(q: UnitQuaternionLike) -> RotationMatrix:
    """Rotation of a unit quaternion; q and -q give the same.

    Args:
        q: (*batch, 4) (w, x, y, z), unit within `tolerance.UNIT`; what is left of that deviation is divided out.

    Returns:
        (*batch, 3, 3).

    Raises:
        InputError: not of unit length: nothing is scaled unasked (`normalise_quaternion`).
    """
    ...


@compile_function("quaternion.normalise")
def normalise_quaternion(q: NonzeroQuaternionLike) -> Quaternion:
    """(*batch, 4) q / |q|, of any length but zero.

    Raises:
        InputError: a quaternion is zero.
    """
    ...


@compile_function("quaternion.canonical")
def canonical(q: QuaternionLike) -> Quaternion:
    """(*batch, 4) of q and -q the one whose first non-zero number is positive."""
    ...


@compile_function("quaternion.multiply")
def multiply(q: UnitQuaternionLike, p: UnitQuaternionLike) -> Quaternion:
    """(*batch, 4) q p of unit quaternions: R(q p) = R(q) R(p)."""
    ...


@compile_function("quaternion.conjugate")
def conjugate(q: QuaternionLike) -> Quaternion:
    """(*batch, 4) (w, -x, -y, -z), the inverse of a unit quaternion."""
    ...


@compile_function("quaternion.rotate")
def rotate(q: UnitQuaternionLike, x: Vector3Like) -> Vector3:
    """(*batch, 3) R(q) x, without forming the matrix."""
    ...


@compile_function("quaternion.exp")
def exp(r: RotationVectorLike) -> Quaternion:
    """(*batch, 4) (cos(theta/2), omega sin(theta/2)) of exponential coordinates r = omega theta (*batch, 3) [rad]."""
    ...


@compile_function("quaternion.log")
def log(q: UnitQuaternionLike) -> Vector3:
    """(*batch, 3) exponential coordinates [rad], theta in [0, pi]; the same for q and -q."""
    ...


@compile_function("quaternion.slerp")
def slerp(p: UnitQuaternionLike, q: UnitQuaternionLike, t: ScalarLike) -> Quaternion:
    """(*batch, 4) p exp(t log(p* q)): constant angular velocity, the short way from p (t = 0) to +-q (t = 1)."""
    ...


def same_rotation(p: ArrayLike, q: ArrayLike, tolerance: float = ROUNDOFF) -> Truth:
    """(*batch) whether unit quaternions p and q are one rotation: equal up to sign within `tolerance`, by entries."""
    a, b = as_batch("p", p, (4,)), as_batch("q", q, (4,))
    return np.minimum(np.abs(a - b).max(-1), np.abs(a + b).max(-1)) <= tolerance


@compile_function("quaternion.to_su2")
def _parts_of_su2(q: UnitQuaternionLike) -> Annotated[Floats, EIGHT]: ...


@compile_function("quaternion.from_su2")
def _of_parts_of_su2(parts: Annotated[ArrayLike, EIGHT]) -> tuple[Quaternion, Scalar]: ...


def to_su2(q: ArrayLike) -> np.ndarray[Any, np.dtype[np.complex128]]:
    """(*batch, 2, 2) complex matrix [[w + ix, y + iz], [-y + iz, w - ix]]; products go over into products."""
    parts = _parts_of_su2(q)
    pairs = parts.reshape(*parts.shape[:-1], 2, 2, 2)
    return pairs[..., 0] + 1j * pairs[..., 1]


def from_su2(U: ArrayLike) -> Quaternion:
    """(*batch, 4) unit quaternion of SU(2) matrices (*batch, 2, 2).

    Raises:
        InputError: the matrix is not of the form [[a, b], [-b*, a*]] with |a|^2 + |b|^2 = 1, within `tolerance.UNIT`.
    """
    matrix = np.asarray(U, dtype=np.complex128)
    shape = matrix.shape[:-2]
    parts = np.stack([matrix.real, matrix.imag], axis=-1).reshape(*shape, 8)
    q, distance = _of_parts_of_su2(parts)
    if np.any(distance > UNIT):
        raise InputError("geometry.su2", name="U", distance=float(np.max(distance)), limit=UNIT)
    return q


@compile_function("quaternion.to_gibbs")
def to_gibbs(q: UnitQuaternionLike) -> Vector3:
    """(*batch, 3) Rodrigues (Cayley, Gibbs) parameters omega tan(theta/2); infinite at half turns."""
    ...


@compile_function("quaternion.from_gibbs")
def from_gibbs(g: Vector3Like) -> Quaternion:
    """(*batch, 4) unit quaternion (1, g) / sqrt(1 + g.g)."""
    ...


@compile_function("quaternion.to_modified_rodrigues")
def _to_modified_rodrigues(q: UnitQuaternionLike) -> Vector3: ...


def to_modified_rodrigues(q: ArrayLike) -> Vector3:
    """(*batch, 3) omega tan(theta/4), in the closed unit ball, of unit quaternions (-q is taken where w < 0)."""
    return _to_modified_rodrigues(canonical(q))


@compile_function("quaternion.from_modified_rodrigues")
def from_modified_rodrigues(m: Vector3Like) -> Quaternion:
    """(*batch, 4) unit quaternion (1 - m.m, 2 m) / (1 + m.m)."""
    ...
