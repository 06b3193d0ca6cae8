"""Whether two lists of screws are the same arm, and the change of base frame between them."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats, PoseMatrix, Vector3
from mafsil.model.placement import adjoint


def same_screws(S: Floats, other: Floats, *, base_free: bool, tolerance: float) -> PoseMatrix | None:
    """The base pose B with Ad(B) S_i = other_i for all i, or None if there is none.

    Args:
        S, other: (n, 6) screw axes.
        base_free: whether any B is allowed; otherwise only the identity.
        tolerance: of every entry.
    """
    B = base_between(S, other) if base_free else np.eye(4)
    return B if float(np.abs(S @ adjoint(B).T - other).max(initial=0.0)) <= tolerance else None


def base_between(S: Floats, other: Floats) -> PoseMatrix:
    """The pose B that brings the axes S nearest to the other axes: rotation from directions, then the origin."""
    turning = np.abs(S[:, :3]).max(axis=1) > 0.5
    before = np.where(turning[:, None], S[:, :3], S[:, 3:])
    after = np.where((np.abs(other[:, :3]).max(axis=1) > 0.5)[:, None], other[:, :3], other[:, 3:])
    U, sizes, Vt = np.linalg.svd(after.T @ before)
    R = U @ np.diag([1.0, 1.0, np.linalg.det(U @ Vt)]) @ Vt
    if sizes[1] < 1e-6 * sizes[0]:
        R = _turned(R, after[0], S[turning], other[turning])
    B = np.eye(4)
    B[:3, :3], B[:3, 3] = R, _origin(R, S[turning], other[turning])
    return B


def _origin(R: Floats, S: Floats, other: Floats) -> Vector3:
    """P with R v + p x R omega = v' as nearly as possible."""
    if not len(S):
        return np.zeros(3)
    # p x w = -[w] p for every axis.
    A = np.concatenate([np.cross(np.eye(3), w).T for w in S[:, :3] @ R.T])
    b = (other[:, 3:] - S[:, 3:] @ R.T).ravel()
    return np.asarray(np.linalg.lstsq(A, b, rcond=None)[0], dtype=np.float64)


def _turned(R: Floats, z: Vector3, S: Floats, other: Floats) -> Floats:
    """All axes parallel to z: the turn about z that fits their places; R itself where any would do."""
    if len(S) < 2:
        return R
    v, sense = S[:, 3:] @ R.T, (S[:, :3] @ R.T) @ z
    across = np.cross(np.eye(3), z).T
    rows = [np.column_stack([u, np.cross(z, u), s * across]) for u, s in zip(v, sense, strict=True)]
    x = np.linalg.lstsq(np.concatenate(rows), other[:, 3:].ravel(), rcond=None)[0]
    length = float(np.hypot(x[0], x[1]))
    if length < 1e-9:
        return R
    c, s = x[0] / length, x[1] / length
    Z = np.cross(np.eye(3), z).T
    return (np.eye(3) + s * Z + (1 - c) * (Z @ Z)) @ R
