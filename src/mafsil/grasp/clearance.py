"""What contacts leave to a body: motions of first order, and with clearance at the fingers how far it moves.

A twist y of the body, (omega, v), moves contact i with y . w_i along its normal, w_i the wrench of a unit push: the
rows of form closure are the columns of frictionless force closure. Within clearance a load brings the body to rest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, as_batch
from mafsil.errors import InputError, MafsilError
from mafsil.grasp.quality import hull_facets
from mafsil.grasp.tolerances import OPTIMUM, RANK, TYPED
from mafsil.solvers.linear_program import minimise


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


class ClearanceStatus(Status):
    """Whether clearance leaves the body within bounds."""

    BOUNDED = ("grasp.clearance_bounded", True)
    UNBOUNDED = ("grasp.clearance_unbounded", False)


@dataclass(frozen=True, eq=False, repr=False)
class ClearanceMotion(Answer, data="bounded range largest_norm"):
    """Small displacements that a clearance at every contact leaves: {y : A' y >= -clearance}; true if bounded.

    Attributes:
        clearance: distance between body and each finger [m], one for all or (n,).
        bounded: whether the fixture holds at all (form closure).
        largest: (m,) largest displacement along each coordinate (theta in radians, then metres); inf if free.
        range: (m, 2) least and largest displacement along each coordinate.
        largest_norm: of the twist, radians and metres as they are; for one clearance clearance / epsilon.
        corners: (k, m) corners of the set, or None if unbounded.
    """

    clearance: float | Floats
    bounded: bool
    largest: Floats
    range: Floats
    largest_norm: float
    corners: Floats | None

    @property
    def status(self) -> ClearanceStatus:
        """Bounded or not."""
        return ClearanceStatus.BOUNDED if self.bounded else ClearanceStatus.UNBOUNDED

    def explain(self, language: str | None = None) -> str:
        """Whether the body stays within bounds, and which."""
        least, largest = (", ".join(f"{v:.4g}" for v in column) for column in self.range.T)
        clearance = ", ".join(f"{v:g}" for v in np.atleast_1d(self.clearance))
        return self.status.sentence(language, clearance=clearance, least=least, largest=largest)


def motion_within_clearance(A: Floats, clearance: ArrayLike) -> ClearanceMotion:
    """How far the body moves if the fingers stand off by small clearances (first order).

    Args:
        A: (m, n) wrenches of unit pushes of the frictionless contacts.
        clearance: [m], positive, one for all or (n,).

    Raises:
        InputError: a clearance that is not positive, or another number of them.
    """
    d = _clearances(clearance, A.shape[1])
    given = float(d[0]) if not np.ndim(clearance) else d
    m, n = A.shape
    extent = np.array([[_extent(A, d, k, 1.0), _extent(A, d, k, -1.0)] for k in range(m)])
    largest = np.abs(extent).max(axis=1)
    if not np.isfinite(largest).all() or n <= m:
        return ClearanceMotion(given, False, largest, extent, np.inf, None)
    facets = hull_facets(A / d)
    if facets is None or (facets[:, -1] >= 0).any():
        return ClearanceMotion(given, False, largest, extent, np.inf, None)
    corners = facets[:, :-1] / facets[:, -1:]
    furthest = float(np.linalg.norm(corners, axis=1).max())
    return ClearanceMotion(given, True, largest, extent, furthest, _distinct(corners, TYPED * furthest))


def _distinct(points: Floats, near: float) -> Floats:
    """Rows without repetition, in order."""
    kept: list[Floats] = []
    for p in points[np.lexsort(points.T[::-1])]:
        if all(np.abs(p - other).max() > near for other in kept):
            kept.append(p)
    return np.array(kept)


def _clearances(clearance: ArrayLike, n: int) -> Floats:
    d = as_batch("clearance", clearance, (), finite=True)
    if d.ndim > 1 or (d.ndim == 1 and len(d) != n):
        raise InputError("input.shape", name="clearance", expected=(n,), got=d.shape, hint="")
    if not (d > 0).all():
        raise InputError("input.positive", name="clearance", value=float(d.min()))
    return np.broadcast_to(d, (n,)).astype(float)


def _extent(A: Floats, d: Floats, k: int, sign: float) -> float:
    """The least (sign 1) or largest (-1) y_k with A' y >= -d; infinite where the program has no bound."""
    m = len(A)
    cost = np.zeros(m)
    cost[k] = sign
    try:
        found = minimise(cost, None, None, -A.T, d, free=m)
    except MafsilError:
        return -sign * np.inf
    return sign * found.value if found else 0.0


class RestStatus(Status):
    """Whether the contacts bring a loaded body to rest."""

    AT_REST = ("grasp.at_rest", True)
    NOT_RESISTED = ("grasp.not_resisted", False)


@dataclass(frozen=True, eq=False, repr=False)
class RestPosition(Answer, data="displacement work touching pushes"):
    """Where a load pushes a body that has clearance; true if it comes to rest.

    Attributes:
        displacement: (m,) small displacement (theta, then metres) at rest; NaN if the load is not resisted.
        work: of the load until then [J]; infinite if it is not resisted.
        touching: indices of contacts whose gap is closed and that push.
        pushes: (n,) of the contacts at rest [N].
    """

    displacement: Floats
    work: float
    touching: tuple[int, ...]
    pushes: Floats

    @property
    def resisted(self) -> bool:
        """Whether the body comes to rest."""
        return bool(np.isfinite(self.work))

    @property
    def status(self) -> RestStatus:
        """At rest, or not resisted."""
        return RestStatus.AT_REST if self.resisted else RestStatus.NOT_RESISTED

    def explain(self, language: str | None = None) -> str:
        """Whether it comes to rest, by which contacts and after what work."""
        touching = ", ".join(map(str, self.touching)) or "-"
        return self.status.sentence(language, contacts=touching, work=self.work)


def rest_position(A: Floats, wrench: ArrayLike, clearance: ArrayLike) -> RestPosition:
    """Where a load moves a body between fingers that stand off: max y . w with A' y >= -d.

    By duality the work is min sum d_i x_i with A x = -w, x >= 0; the contacts with x_i > 0 have closed their gaps.

    Args:
        A: (m, n) wrenches of unit pushes of the frictionless contacts.
        wrench: (m,) external (m, f) [N m, N].
        clearance: [m], positive, one for all or (n,).

    Raises:
        InputError: shapes do not fit, or a clearance is not positive.
    """
    m: int = A.shape[0]
    n: int = A.shape[1]
    w, d = as_batch("wrench", wrench, (m,), finite=True), _clearances(clearance, n)
    size = float(np.abs(w).max()) or 1.0
    balance = minimise(d / d.max(), A, -w / size)
    if balance is None:
        return RestPosition(np.full(m, np.nan), np.inf, (), np.zeros(n))
    found = minimise(-w / size, None, None, -A.T, d / d.max(), free=m)
    assert found is not None, "no displacement at all is allowed"
    pushes = size * balance.x
    touching = tuple(int(i) for i in np.flatnonzero(balance.x > OPTIMUM))
    return RestPosition(d.max() * found.x, float(d @ pushes), touching, pushes)
