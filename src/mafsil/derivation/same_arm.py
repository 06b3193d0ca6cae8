"""Whether lists of screws are the same arm, and the change of base frame between them; many lists at once."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats
from mafsil.derivation.tolerances import ALMOST_PARALLEL, NEAREST, PSEUDOINVERSE

_REFINEMENTS = 3


def misfit(S: Floats, other: Floats, B: Floats) -> Floats:
    """(m, n, 6) how far Ad(B) S is from the other axes.

    Args:
        S: (m, n, 6) lists of screw axes (omega, v).
        other: (n, 6) the axes they should be.
        B: (m, 4, 4) poses.
    """
    R, p = B[:, None, :3, :3], B[:, None, :3, 3]
    omega = (R @ S[..., :3, None])[..., 0]
    v = (R @ S[..., 3:, None])[..., 0] + np.cross(p, omega)
    return np.concatenate([omega, v], axis=-1) - other


def base_between(S: Floats, other: Floats) -> Floats:
    """The poses B (m, 4, 4) that bring every list of axes nearest to the other one.

    1. The rotation between the directions (Kabsch). Where all are parallel, or almost, it leaves a turn about them
       free: there the turn that fits the places of the axes in the plane across them is tried too.
    2. The origin by linear least squares: p x omega' = v' - R v for every revolute axis.
    3. Where the misfit is small, all six freedoms together by Gauss-Newton: places also tell directions.

    Args:
        S: (m, n, 6) lists of screw axes.
        other: (n, 6) axes.

    Reference: Kabsch, Acta Crystallographica A 32, 1976.
    """
    revolute = np.abs(S[..., :3]).max(axis=-1) > 0.5
    before = np.where(revolute[..., None], S[..., :3], S[..., 3:])
    after = np.where((np.abs(other[:, :3]).max(axis=1) > 0.5)[:, None], other[:, :3], other[:, 3:])
    U, sizes, Vt = np.linalg.svd(np.einsum("nj,mnk->mjk", after, before))
    U[..., 2] *= np.linalg.det(U @ Vt)[:, None]
    R = U @ Vt
    B = _with_origin(R, S, other, revolute)
    flat = sizes[:, 1] < ALMOST_PARALLEL * sizes[:, 0]
    if flat.any():
        spun = _spun(R[flat], S[flat], other, after[0], revolute[flat])
        B[flat] = _better(S[flat], other, B[flat], _with_origin(spun, S[flat], other, revolute[flat]))
    return _refine(S, other, B)


def _with_origin(R: Floats, S: Floats, other: Floats, revolute: Floats) -> Floats:
    """Poses (m, 4, 4) with those rotations, and p with R v + p x R omega = v' as nearly as possible."""
    omega = (R[:, None] @ S[..., :3, None])[..., 0] * revolute[..., None]
    missing = other[:, 3:] - (R[:, None] @ S[..., 3:, None])[..., 0]
    square = np.einsum("mni,mni->m", omega, omega)[:, None, None] * np.eye(3) - np.einsum("mni,mnj->mij", omega, omega)
    right = np.cross(omega, missing).sum(axis=1)
    B = np.broadcast_to(np.eye(4), (len(S), 4, 4)).copy()
    B[:, :3, :3] = R
    B[:, :3, 3] = (np.linalg.pinv(square, rcond=PSEUDOINVERSE, hermitian=True) @ right[..., None])[..., 0]
    return B


def _spun(R: Floats, S: Floats, other: Floats, z: Floats, revolute: Floats) -> Floats:
    """Rotations turned further about z, the direction of all axes, so that the axes' places fit."""
    weight = revolute[..., None].astype(np.float64)
    count = np.maximum(weight.sum(axis=1, keepdims=True), 1.0)
    mine = np.cross(S[..., :3], S[..., 3:]) @ R.transpose(0, 2, 1)
    theirs = np.broadcast_to(np.cross(other[:, :3], other[:, 3:]), mine.shape)
    mine, theirs = ((x - (weight * x).sum(axis=1, keepdims=True) / count) * weight for x in (mine, theirs))
    angle = np.arctan2((np.cross(mine, theirs) @ z).sum(axis=1), (mine * theirs).sum(axis=(1, 2)))
    c, s = np.cos(angle)[:, None, None], np.sin(angle)[:, None, None]
    Z = np.cross(z, np.eye(3)).T
    return (np.eye(3) + s * Z + (1 - c) * (Z @ Z)) @ R


def _better(S: Floats, other: Floats, one: Floats, two: Floats) -> Floats:
    """Of two poses for every list, the one with the smaller misfit."""
    sizes = [np.abs(misfit(S, other, B)).max(axis=(1, 2), initial=0.0) for B in (one, two)]
    return np.where((sizes[0] <= sizes[1])[:, None, None], one, two)


def _refine(S: Floats, other: Floats, B: Floats) -> Floats:
    scale = max(1.0, float(np.abs(other).max(initial=0.0)))
    for _ in range(_REFINEMENTS):
        size = np.abs(misfit(S, other, B)).max(axis=(1, 2), initial=0.0)
        near = (size < 1e-2 * scale) & (size > NEAREST * scale)
        if not near.any():
            break
        B[near] = _better(S[near], other, B[near], _step(S[near], other, B[near]))
    return B


def _step(S: Floats, other: Floats, B: Floats) -> Floats:
    """One Gauss-Newton step: B moved by the small twist that takes most of the misfit away."""
    error = misfit(S, other, B)
    omega, v = error[..., :3] + other[:, :3], error[..., 3:] + other[:, 3:]
    J = np.zeros((*error.shape, 6))
    J[..., :3, :3] = J[..., 3:, 3:] = -_skew(omega)
    J[..., 3:, :3] = -_skew(v)
    rows = J.reshape(len(S), -1, 6)
    twist = -(np.linalg.pinv(rows, rcond=PSEUDOINVERSE / 10) @ error.reshape(len(S), -1, 1))[..., 0]
    U, _, Vt = np.linalg.svd(np.eye(3) + _skew(twist[:, :3]))
    moved = np.broadcast_to(np.eye(4), B.shape).copy()
    moved[:, :3, :3], moved[:, :3, 3] = U @ Vt, twist[:, 3:]
    return moved @ B


def _skew(w: Floats) -> Floats:
    """(..., 3, 3) matrices [w] with [w] x = w x x."""
    out = np.zeros((*w.shape, 3))
    out[..., 0, 1], out[..., 0, 2], out[..., 1, 2] = -w[..., 2], w[..., 1], -w[..., 0]
    out[..., 1, 0], out[..., 2, 0], out[..., 2, 1] = w[..., 2], -w[..., 1], w[..., 0]
    return out
