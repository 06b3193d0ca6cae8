"""The largest ball about the origin inside a set of wrenches: its radius is the classic quality of a grasp.

The set is known by its support function h(u) = max over its wrenches of u . w, so a true friction cone costs no more
than a polyhedral one. A polytope grows inside: its facet nearest to the origin bounds the radius from below, the
support function in that facet's direction from above, and the support point is the next corner.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from mafsil.arrays import Floats

Support: TypeAlias = Callable[[Floats], tuple[float, Floats]]
"""Direction (m,) to h(u) and the wrenches (m, k) that may reach it, the best one among them."""
CANDIDATES = 12
"""Facets, nearest first, that are pushed outwards in one round."""
DUST = 1e-12


@dataclass(frozen=True, eq=False)
class Ball:
    """A ball about the origin.

    Attributes:
        radius: largest that is proven to fit; 0 if the origin is not strictly inside.
        upper: radius that is proven not to be exceeded; equal to `radius` for finitely many wrenches.
        weakest: (m,) unit direction in which the set reaches least far; the wrench against it is the hardest.
        corners: how many wrenches the polytope had.
    """

    radius: float
    upper: float
    weakest: Floats
    corners: int


def finite_ball(W: Floats) -> Ball:
    """The ball inside the convex hull of finitely many columns.

    Args:
        W: (m, n) wrenches, m >= 2.
    """
    facets = hull_facets(W)
    if facets is None:
        return Ball(0.0, 0.0, np.zeros(len(W)), W.shape[1])
    nearest = int(np.argmin(-facets[:, -1]))
    radius = max(0.0, float(-facets[nearest, -1]))
    return Ball(radius, radius, facets[nearest, :-1], W.shape[1])


def inscribed_ball(W: Floats, support: Support, tolerance: float = 1e-3, most: int = 60) -> Ball:
    """The ball inside a convex set known by its support function.

    Args:
        W: (m, n) wrenches of the set whose hull has the origin inside, or nearly.
        support: of the set.
        tolerance: wanted gap between the two bounds, relative to the radius.
        most: corners added at most; the bounds may then stand further apart, and both are told.

    Reference:
        Y. Zheng, An efficient algorithm for a grasp quality measure, IEEE Trans. Robotics 29(2), 2013.
    """
    points = W
    upper, weakest = np.inf, np.zeros(len(W))
    while True:
        facets = hull_facets(points)
        if facets is None:
            return Ball(0.0, 0.0, np.zeros(len(W)), W.shape[1])
        near = np.argsort(-facets[:, -1])[:CANDIDATES]
        radius = float(-facets[near[0], -1])
        fresh: list[Floats] = []
        for k in near:
            u = facets[k, :-1]
            reach, corner = support(u)
            if reach < upper:
                upper, weakest = reach, u
            if reach > -facets[k, -1] * (1 + 0.25 * tolerance) + DUST:
                fresh.append(corner[:, int(np.argmax(u @ corner))])
        if upper <= max(radius, 0.0) * (1 + tolerance) + DUST or not fresh or points.shape[1] >= W.shape[1] + most:
            return Ball(max(0.0, radius), max(0.0, upper, radius), weakest, points.shape[1])
        points = np.column_stack([points, *_distinct(fresh)])


def _distinct(points: list[Floats]) -> list[Floats]:
    kept: list[Floats] = []
    for point in points:
        if all(np.abs(point - other).max() > DUST for other in kept):
            kept.append(point)
    return kept


def hull_facets(W: Floats) -> Floats | None:
    """Facets of the convex hull of columns, one row (u, -d) each with u . w <= d on the hull; None if it is flat.

    Args:
        W: (m, n) columns.
    """
    hull = _hull(W)
    return None if hull is None else np.asarray(hull.equations)


def hull_volume(W: Floats) -> float:
    """Volume of the convex hull of columns (m, n); 0 if it is flat."""
    hull = _hull(W)
    return 0.0 if hull is None else float(hull.volume)


def distance_to_hull(W: Floats) -> tuple[float, Floats]:
    """Distance from the origin to the convex hull of columns, and the hull's nearest point.

    The point of least norm is the direction of the least squares answer of [W; 1'] x = (0, 1), x >= 0.

    Args:
        W: (m, n).
    """
    from scipy.optimize import nnls

    size = float(np.abs(W).max()) or 1.0
    rows = np.vstack([W / size, np.ones(W.shape[1])])
    x, _ = nnls(rows, np.concatenate([np.zeros(len(W)), [1.0]]))
    nearest = W @ (x / x.sum())
    return float(np.linalg.norm(nearest)), nearest


def _hull(W: Floats) -> Any:
    """Qhull's convex hull; where merging of nearly coplanar facets fails, points are joggled within rounding."""
    from scipy.spatial import ConvexHull, QhullError

    if W.shape[1] <= len(W) or np.linalg.matrix_rank(W - W[:, :1]) < len(W):
        return None
    for options in (None, "QJ"):
        try:
            return ConvexHull(W.T, qhull_options=options)
        except QhullError:
            continue
    return None
