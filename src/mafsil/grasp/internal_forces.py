"""Internal forces: sets of contact forces that squeeze a body without moving it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch
from mafsil.grasp.contact import Contact
from mafsil.grasp.tolerances import RANK


def internal_basis(contacts: Sequence[Contact]) -> Floats:
    """(q, contacts, d) basis of the forces at the contact points whose resultant force and moment are zero.

    For three points that are not on a line one member for each side: equal and opposite forces along it (q = 3). For
    others an orthonormal basis of the null space of the grasp map.

    Args:
        contacts: at least one; only their points matter.
    """
    points = np.array([c.point for c in contacts])
    n, d = points.shape
    resultant = _resultant(points)
    _, s, Vt = np.linalg.svd(resultant)
    rank = int((s > RANK * s[0]).sum())
    if n == 3 and n * d - rank == 3:
        basis = np.zeros((3, n, d))
        for row, (i, j) in enumerate(((0, 1), (1, 2), (2, 0))):
            u = (points[j] - points[i]) / np.linalg.norm(points[j] - points[i])
            basis[row, i], basis[row, j] = u, -u
        return basis
    return Vt[rank:].reshape(-1, n, d)


def split_forces(contacts: Sequence[Contact], forces: ArrayLike) -> tuple[Floats, Floats]:
    """Forces as the part of least norm with the same resultant, and the internal part.

    Args:
        contacts: of the grasp.
        forces: (contacts, d) [N].

    Returns:
        Two arrays (contacts, d) whose sum is `forces`.
    """
    points = np.array([c.point for c in contacts])
    given = as_batch("forces", forces, points.shape, finite=True)
    resultant = _resultant(points)
    external = (np.linalg.pinv(resultant, rcond=RANK) @ (resultant @ given.ravel())).reshape(points.shape)
    return external, given - external


def _resultant(points: Floats) -> Floats:
    """(m, n d) forces at the points to their resultant, moments about the middle and divided by the spread."""
    d = points.shape[1]
    arms = points - points.mean(axis=0)
    arms = arms / (float(np.linalg.norm(arms, axis=1).max()) or 1.0)
    blocks: list[Floats] = []
    for r in arms:
        turn = np.array([[-r[1], r[0]]]) if d == 2 else np.array([[0, -r[2], r[1]], [r[2], 0, -r[0]], [-r[1], r[0], 0]])
        blocks.append(np.vstack([turn, np.eye(d)]))
    return np.hstack(blocks)
