"""The other side of statics: which motions the contacts leave to the body, and how far it can wiggle.

A twist y of the body, (omega, v), moves contact i with y . w_i along its normal, w_i the wrench of a unit push: the
rows of form closure are the columns of frictionless force closure.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.messages import say
from mafsil.solvers.linear_program import minimise

STILL = 1e-9


class ContactMotion(Enum):
    """What a motion of the body does at a contact; the values are keys of sentences."""

    BREAKING = "grasp.breaking"
    ROLLING = "grasp.rolling"
    SLIDING = "grasp.sliding"
    PENETRATING = "grasp.penetrating"

    def sentence(self, language: str | None = None) -> str:
        """The motion in words."""
        return say(self.value, language=language)


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


@dataclass(frozen=True, eq=False)
class Wiggle:
    """Small displacements that a clearance at every contact leaves: {y : A' y >= -clearance}.

    Attributes:
        clearance: distance between body and each finger [m].
        bounded: whether the fixture holds at all (form closure).
        greatest: (m,) greatest displacement along each coordinate (theta in radians, then metres); inf if free.
        greatest_norm: of the twist, with moments and lengths as they are; clearance / ball radius.
        corners: (k, m) corners of the set, or None if unbounded.
    """

    clearance: float
    bounded: bool
    greatest: Floats
    greatest_norm: float
    corners: Floats | None


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
    if abs(away) > STILL * max(size, float(np.linalg.norm(twist)) * STILL):
        return ContactMotion.BREAKING if away > 0 else ContactMotion.PENETRATING
    return ContactMotion.SLIDING if size > STILL * float(np.linalg.norm(twist)) else ContactMotion.ROLLING


def free_motions(A: Floats) -> FreeMotions:
    """Basis and extreme rays of the cone of twists that the contacts allow.

    Every ray makes at least m - 1 - k independent contacts still, k the number of reversible motions: rays are found
    by the double description method, one contact after the other.

    Args:
        A: (m, n) wrenches of unit pushes of the frictionless contacts.

    Reference:
        T. S. Motzkin et al., The double description method, 1953.
    """
    W = A / np.linalg.norm(A, axis=0)
    _, s, Vt = np.linalg.svd(W.T)
    rank = int((s > 1e-10).sum())
    reversible, lines = Vt[rank:], Vt[:rank].T
    rays = extreme_rays(W.T @ lines)
    return FreeMotions(reversible, rays @ lines.T)


def extreme_rays(rows: Floats) -> Floats:
    """Extreme rays of the pointed cone {z : rows z >= 0}, one in each row.

    Args:
        rows: (n, r) of full column rank.
    """
    r = rows.shape[1]
    if r == 0:
        return np.zeros((0, 0))
    first = _independent_rows(rows)
    rays: Floats = np.asarray(np.linalg.inv(rows[first]).T, float)
    used = list(first)
    for i in range(len(rows)):
        if i in first:
            continue
        heights = rays @ rows[i]
        scale = STILL * np.linalg.norm(rays, axis=1)
        plus, minus, zero = heights > scale, heights < -scale, np.abs(heights) <= scale
        tight = np.abs(rays @ rows[used].T) <= STILL * np.linalg.norm(rays, axis=1)[:, None]
        fresh = [
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


def wiggle(A: Floats, clearance: float) -> Wiggle:
    """How far the body moves if every finger stands off by a small clearance (first order).

    Args:
        A: (m, n) wrenches of unit pushes of the frictionless contacts.
        clearance: [m], positive.

    Raises:
        InputError: the clearance is not positive.
    """
    if not clearance > 0:
        raise InputError("input.positive", name="clearance", value=clearance)
    m, n = A.shape
    greatest = np.array([_extent(A, clearance, k) for k in range(m)])
    if not np.isfinite(greatest).all() or n <= m:
        return Wiggle(clearance, False, greatest, np.inf, None)
    from mafsil.grasp.ball import hull_facets

    facets = hull_facets(A)
    if facets is None or (facets[:, -1] >= 0).any():
        return Wiggle(clearance, False, greatest, np.inf, None)
    corners = clearance * facets[:, :-1] / facets[:, -1:]
    return Wiggle(clearance, True, greatest, float(np.linalg.norm(corners, axis=1).max()), np.unique(corners, axis=0))


def _extent(A: Floats, clearance: float, k: int) -> float:
    """Max |y_k| with A' y >= -clearance; infinite where the program has no bound."""
    from mafsil.errors import MafsilError

    m, n = A.shape
    best = 0.0
    for sign in (1.0, -1.0):
        cost = np.zeros(m)
        cost[k] = sign
        try:
            found = minimise(cost, None, None, -A.T, np.full(n, clearance), free=m)
        except MafsilError:
            return np.inf
        best = max(best, -found.value if found else 0.0)
    return best
