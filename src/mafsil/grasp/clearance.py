"""What clearance at the fingers leaves to a body: how far it moves, and where a load brings it to rest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, as_batch
from mafsil.errors import InputError, MafsilError
from mafsil.grasp.quality import hull_facets
from mafsil.grasp.tolerances import OPTIMUM, TYPED
from mafsil.solvers.linear_program import minimise


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
