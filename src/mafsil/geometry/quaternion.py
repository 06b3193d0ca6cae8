"""Unit quaternions (w, x, y, z) and the numbers that hang on them; any batch, leading dimensions broadcast."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.algebra.tolerance import UNIT
from mafsil.arrays import Floats, Vector3, gate
from mafsil.errors import InputError
from mafsil.geometry.declared import Declared

_Q = {"q": "unit_quaternion"}
_PQ = {"q": "unit_quaternion", "p": "unit_quaternion"}
_R = {"R": "rotation"}

_from_matrix = Declared("quaternion.from_matrix", "R:3,3", "q:4", _R)
_to_matrix = Declared("quaternion.to_matrix", "q:4", "R:3,3", _Q)
_normalized = Declared("quaternion.normalized", "q:4", "unit:4", {"q": "quaternion"})
_canonical = Declared("quaternion.canonical", "q:4", "canonical:4")
_multiply = Declared("quaternion.multiply", "q:4 p:4", "qp:4", _PQ)
_conjugate = Declared("quaternion.conjugate", "q:4", "inverse:4")
_rotate = Declared("quaternion.rotate", "q:4 x:3", "y:3", _Q)
_exp = Declared("quaternion.exp", "r:3", "q:4", {"r": "rotation_vector"})
_log = Declared("quaternion.log", "q:4", "r:3", _Q)
_slerp = Declared("quaternion.slerp", "p:4 q:4 t", "r:4", _PQ)
_to_su2 = Declared("quaternion.to_su2", "q:4", "parts:8", _Q)
_from_su2 = Declared("quaternion.from_su2", "parts:8", "q:4 distance")
_to_gibbs = Declared("quaternion.to_gibbs", "q:4", "g:3", _Q)
_from_gibbs = Declared("quaternion.from_gibbs", "g:3", "q:4")
_to_mrp = Declared("quaternion.to_modified_rodrigues", "q:4", "m:3", _Q)
_from_mrp = Declared("quaternion.from_modified_rodrigues", "m:3", "q:4")


def to_quaternion(R: ArrayLike) -> Floats:
    """Unit quaternion of a rotation; of q and -q the one with w >= 0 (at half turns: first non-zero number positive).

    Args:
        R: (*batch, 3, 3) rotation.

    Returns:
        (*batch, 4) (w, x, y, z).

    Raises:
        InputError: R is not a rotation within `tolerance.ROTATION`.

    Reference: Shepperd, J. Guidance and Control 1, 1978.
    """
    return _from_matrix.at(R)


def from_quaternion(q: ArrayLike) -> Floats:
    """Rotation of a unit quaternion; q and -q give the same.

    Args:
        q: (*batch, 4) (w, x, y, z), unit within `tolerance.UNIT`; what is left of that deviation is divided out.

    Returns:
        (*batch, 3, 3).

    Raises:
        InputError: not of unit length: nothing is scaled unasked (`normalize_quaternion`).
    """
    return _to_matrix.at(q)


def normalize_quaternion(q: ArrayLike) -> Floats:
    """(*batch, 4) q / |q|, of any length but zero.

    Raises:
        InputError: a quaternion is zero.
    """
    return _normalized.at(q)


def canonical(q: ArrayLike) -> Floats:
    """(*batch, 4) of q and -q the one whose first non-zero number is positive."""
    return _canonical.at(q)


def multiply(q: ArrayLike, p: ArrayLike) -> Floats:
    """(*batch, 4) q p of unit quaternions: R(q p) = R(q) R(p)."""
    return _multiply.at(q, p)


def conjugate(q: ArrayLike) -> Floats:
    """(*batch, 4) (w, -x, -y, -z), the inverse of a unit quaternion."""
    return _conjugate.at(q)


def rotate(q: ArrayLike, x: ArrayLike) -> Vector3:
    """(*batch, 3) R(q) x, without forming the matrix."""
    return _rotate.at(q, x)


def exp(r: ArrayLike) -> Floats:
    """(*batch, 4) (cos(theta/2), omega sin(theta/2)) of exponential coordinates r = omega theta (*batch, 3) [rad]."""
    return _exp.at(r)


def log(q: ArrayLike) -> Vector3:
    """(*batch, 3) exponential coordinates [rad], theta in [0, pi]; the same for q and -q."""
    return _log.at(q)


def slerp(p: ArrayLike, q: ArrayLike, t: ArrayLike) -> Floats:
    """(*batch, 4) p exp(t log(p* q)): constant angular velocity, the short way from p (t = 0) to +-q (t = 1)."""
    return _slerp.at(p, q, t)


def same_rotation(p: ArrayLike, q: ArrayLike, tolerance: float = 1e-12) -> Any:
    """(*batch) whether unit quaternions p and q are one rotation: equal up to sign within `tolerance`, by entries."""
    a, b = gate("p", p, (4,)), gate("q", q, (4,))
    return np.minimum(np.abs(a - b).max(-1), np.abs(a + b).max(-1)) <= tolerance


def to_su2(q: ArrayLike) -> np.ndarray[Any, np.dtype[np.complex128]]:
    """(*batch, 2, 2) complex matrix [[w + ix, y + iz], [-y + iz, w - ix]]; products go over into products."""
    parts = np.asarray(_to_su2.at(q))
    pairs = parts.reshape(*parts.shape[:-1], 2, 2, 2)
    return pairs[..., 0] + 1j * pairs[..., 1]


def from_su2(U: ArrayLike) -> Floats:
    """(*batch, 4) unit quaternion of SU(2) matrices (*batch, 2, 2).

    Raises:
        InputError: the matrix is not of the form [[a, b], [-b*, a*]] with |a|^2 + |b|^2 = 1, within `tolerance.UNIT`.
    """
    matrix = np.asarray(U, dtype=np.complex128)
    shape = matrix.shape[:-2]
    parts = np.stack([matrix.real, matrix.imag], axis=-1).reshape(*shape, 8)
    q, distance = _from_su2.at(parts)
    if np.any(distance > UNIT):
        raise InputError("geometry.su2", name="U", distance=float(np.max(distance)), limit=UNIT)
    return q


def to_gibbs(q: ArrayLike) -> Vector3:
    """(*batch, 3) Rodrigues (Cayley, Gibbs) parameters omega tan(theta/2); infinite at half turns."""
    return _to_gibbs.at(q)


def from_gibbs(g: ArrayLike) -> Floats:
    """(*batch, 4) unit quaternion (1, g) / sqrt(1 + g.g)."""
    return _from_gibbs.at(g)


def to_modified_rodrigues(q: ArrayLike) -> Vector3:
    """(*batch, 3) omega tan(theta/4), in the closed unit ball, of unit quaternions (-q is taken where w < 0)."""
    return _to_mrp.at(canonical(q))


def from_modified_rodrigues(m: ArrayLike) -> Floats:
    """(*batch, 4) unit quaternion (1 - m.m, 2 m) / (1 + m.m)."""
    return _from_mrp.at(m)
