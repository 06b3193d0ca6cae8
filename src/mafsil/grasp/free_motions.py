"""The other side of statics: which motions the contacts leave to the body.

A twist y of the body, (omega, v), moves contact i with y . w_i along its normal, w_i the wrench of a unit push: the
rows of form closure are the columns of frictionless force closure.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Status
from mafsil.arrays import Floats
from mafsil.grasp.tolerances import RANK, TYPED


class ContactMotion(Status):
    """What a motion of the body does at a contact; all succeed but those by which the bodies penetrate."""

    BREAKING = ("grasp.breaking", True)
    ROLLING = ("grasp.rolling", True)
    SLIDING = ("grasp.sliding", True)
    PENETRATING = ("grasp.penetrating", False)


@dataclass(frozen=True, eq=False)
class FreeMotions:
    """All twists that no frictionless contact forbids: {y : A' y >= 0}.

    Attributes:
        reversible: (k, m) basis of the motions that keep every contact, both ways.
        rays: (r, m) one-way motions: with the reversible ones they span all others with positive weights.
    """

    reversible: Floats
    rays: Floats

    @property
    def form_closure(self) -> bool:
        """Whether no motion is left."""
        return not len(self.reversible) and not len(self.rays)


def point_velocity(twist: ArrayLike, point: ArrayLike) -> Floats:
    """V + omega x r of a point of the body.

    Args:
        twist: (3,) (omega, v_x, v_y) or (6,) (omega, v) [rad/s, m/s].
        point: (d,) [m].
    """
    y, r = np.asarray(twist, float), np.asarray(point, float)
    if len(r) == 2:
        return np.array([y[1] - r[1] * y[0], y[2] + r[0] * y[0]])
    return y[3:] + np.cross(y[:3], r)


def contact_motion(twist: ArrayLike, point: ArrayLike, normal: ArrayLike) -> ContactMotion:
    """Does the contact break, roll, slide, or would the bodies penetrate?

    Args:
        twist: (3,) or (6,) of the body against the finger at rest.
        point: (d,) [m].
        normal: (d,) into the body.
    """
    v = point_velocity(twist, point)
    n = np.asarray(normal, float)
    n = n / np.linalg.norm(n)
    away, size = float(v @ n), float(np.linalg.norm(v))
    if abs(away) > TYPED * max(size, float(np.linalg.norm(twist)) * TYPED):
        return ContactMotion.BREAKING if away > 0 else ContactMotion.PENETRATING
    return ContactMotion.SLIDING if size > TYPED * float(np.linalg.norm(twist)) else ContactMotion.ROLLING


def free_motions(A: Floats) -> FreeMotions:
    """Basis and extreme rays of the cone of twists that the contacts allow.

    1. Singular values part the twists that keep every contact (reversible) from the others.
    2. In the others the cone is pointed; its rays come from `extreme_rays`.

    Args:
        A: (m, n) wrenches of unit pushes of the frictionless contacts.

    Reference:
        T. S. Motzkin et al., The double description method, 1953.
    """
    W = A / np.linalg.norm(A, axis=0)  # 1
    _, s, Vt = np.linalg.svd(W.T)
    rank = int((s > RANK).sum())
    reversible, lines = Vt[rank:], Vt[:rank].T
    rays = extreme_rays(W.T @ lines)  # 2
    return FreeMotions(reversible, rays @ lines.T)


def extreme_rays(rows: Floats) -> Floats:
    """Extreme rays of the pointed cone {z : rows z >= 0}, one in each row: the double description method.

    1. As many independent rows as dimensions make a simplicial cone; its rays are columns of the inverse.
    2. Each further row keeps the rays on its side.
    3. Where it parts two adjacent rays (no third one is tight at all rows at which both are), the ray between them on
       the row's plane joins.

    Args:
        rows: (n, r) of full column rank.

    Reference:
        T. S. Motzkin et al., The double description method, 1953.
    """
    r = rows.shape[1]
    if r == 0:
        return np.zeros((0, 0))
    first = _independent_rows(rows)  # 1
    rays: Floats = np.asarray(np.linalg.inv(rows[first]).T, float)
    used = list(first)
    for i in range(len(rows)):
        if i in first:
            continue
        heights = rays @ rows[i]  # 2
        scale = TYPED * np.linalg.norm(rays, axis=1)
        plus, minus, zero = heights > scale, heights < -scale, np.abs(heights) <= scale
        tight = np.abs(rays @ rows[used].T) <= TYPED * np.linalg.norm(rays, axis=1)[:, None]
        fresh = [  # 3
            heights[a] * rays[b] - heights[b] * rays[a]
            for a in np.flatnonzero(plus)
            for b in np.flatnonzero(minus)
            if _adjacent(tight, int(a), int(b))
        ]
        used.append(i)
        rays = np.vstack([rays[plus | zero], *([np.array(fresh)] if fresh else [])])
        if not len(rays):
            return rays
        rays = rays / np.linalg.norm(rays, axis=1, keepdims=True)
    return rays / np.linalg.norm(rays, axis=1, keepdims=True)


def _adjacent(tight: Floats, a: int, b: int) -> bool:
    """No third ray is still at all the contacts at which both are."""
    both = tight[a] & tight[b]
    others = (tight[:, both]).all(axis=1)
    return int(others.sum()) == 2


def _independent_rows(rows: Floats) -> list[int]:
    chosen: list[int] = []
    rest = rows.copy()
    for _ in range(rows.shape[1]):
        i = int(np.argmax(np.linalg.norm(rest, axis=1)))
        chosen.append(i)
        u = rest[i] / np.linalg.norm(rest[i])
        rest = rest - np.outer(rest @ u, u)
    return chosen
