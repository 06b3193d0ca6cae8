"""Rotations and mirrors that map the contacts of a grasp onto each other, seen in the space of wrenches.

What they map onto each other need be searched only once: of all images of a direction the one that reaches furthest
along a fixed vector z stands for the others.
"""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats
from mafsil.grasp.tolerances import SYMMETRIC

SLANT = 1e-3
"""Sine of the angle between two normals, from which they make a frame."""


def symmetries(discs: Floats) -> tuple[Floats, float]:
    """Orthogonal maps of wrenches that permute the discs, closed under products, and by how much they deviate.

    A rotation or mirror R about the point of the moments takes a wrench (m, f) to (det R R m, R f).

    Args:
        discs: (k, 4, 6) as in `solvers.disc_loops`, wrenches (m, f).

    Returns:
        (n, 6, 6) with the identity; at most how far an image is from the disc that it should be.
    """
    alone = np.eye(6)[None], 0.0
    normals = discs[:, 0, 3:]
    normals = normals / np.linalg.norm(normals, axis=1)[:, None]
    cosines = normals @ normals.T
    i, j = np.unravel_index(np.argmin(np.abs(cosines)), cosines.shape)
    if 1.0 - cosines[i, j] ** 2 < SLANT**2:
        return alone
    frame, size = _frame(normals[i], normals[j]), float(np.linalg.norm(discs, axis=2).max())
    found: list[Floats] = []
    worst = 0.0
    for k, n in zip(*np.nonzero(np.abs(cosines - cosines[i, j]) < SYMMETRIC), strict=True):
        for side in (1.0, -1.0):
            R = _frame(normals[k], normals[n]) @ np.diag([1.0, 1.0, side]) @ frame.T
            Q = np.zeros((6, 6))
            Q[:3, :3], Q[3:, 3:] = side * R, R
            deviation = _deviation(discs, discs @ Q.T)
            if deviation < SYMMETRIC * size:
                found.append(Q)
                worst = max(worst, deviation)
    group = np.array(found)
    return (group, worst) if len(group) > 1 and _is_group(group) else alone


def walls(group: Floats) -> Floats:
    """(n, m) vectors x with x . u >= 0 for the directions that stand for their images.

    Args:
        group: (n, m, m) with the identity.
    """
    m: int = group.shape[1]
    z = np.random.default_rng(0).normal(size=m)
    x: Floats = z - group @ z
    return np.ascontiguousarray(x[np.linalg.norm(x, axis=1) > SLANT])


def _frame(a: Floats, b: Floats) -> Floats:
    """Right-handed orthonormal columns: a, b made square to a, and across."""
    y = b - a * (a @ b)
    y = y / np.linalg.norm(y)
    return np.column_stack([a, y, np.cross(a, y)])


def _deviation(discs: Floats, images: Floats) -> float:
    """How far images are from the discs that they permute; infinite if they do not permute them."""
    apart = np.linalg.norm(images[:, None, 0] - discs[None, :, 0], axis=2)
    order = np.argmin(apart, axis=1)
    if len(set(order.tolist())) < len(discs):
        return np.inf
    theirs = discs[order]
    U, _, Vt = np.linalg.svd(np.einsum("kpm,kqm->kpq", theirs[:, 1:3], images[:, 1:3]))
    turned = np.einsum("kpr,krq,kqm->kpm", U, Vt, images[:, 1:3])
    rims = np.linalg.norm(turned - theirs[:, 1:3], axis=(1, 2))
    torsion = np.minimum(*(np.linalg.norm(images[:, 3] - s * theirs[:, 3], axis=1) for s in (1.0, -1.0)))
    return float((apart.min(axis=1) + rims + torsion).max())


def _is_group(group: Floats) -> bool:
    """Whether every product of two maps is one of them."""
    products = np.einsum("aij,bjk->abik", group, group)
    apart = np.abs(products[:, :, None] - group[None, None]).max(axis=(3, 4))
    return bool((apart.min(axis=2) < 1e3 * SYMMETRIC).all())
