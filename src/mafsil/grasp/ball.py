"""The largest ball about the origin inside a set of wrenches: its radius is the classic quality of a grasp.

The set is the hull of points or of discs (round cones), so a true friction cone costs no more than a polyhedral one.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import Any

import numpy as np

from mafsil.arrays import Floats
from mafsil.grasp.minima import minimum
from mafsil.grasp.symmetries import symmetries, walls

MOST_ROWS = 6
"""Of wrenches for which the compiled growth has room; larger sets go to Qhull."""
CORNERS, FACETS = 1000, 60_000
"""Room for the growth, kept for the next one; most searches touch little of it."""
TRIES = 3
GAP = 1e-6
"""Wanted gap between the bounds of a round set's radius, relative."""
CLOSE = 1e-12
"""Wanted gap between the bounds of a distance, relative."""
CONES = 1_000_000
"""Of directions looked at in a proof at most: about five seconds."""
DESCENTS, WIDE, NARROW = 5, 0.5, 1e-6
"""Random starts of descents, and the first and last width of their steps."""
NEAR = 1e-7
"""Points within it of the nearest facet, relative to the largest, may lie on it."""


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

    @property
    def met(self) -> bool:
        """Whether the bounds are within a millionth of each other; if not, the radius is only known to lie between."""
        return agree(self.radius, self.upper)


def agree(lower: float, upper: float) -> bool:
    """Whether two bounds are within a millionth of each other."""
    return upper - lower <= GAP * abs(upper) * (1.0 + NEAR)


def finite_ball(W: Floats) -> Ball:
    """The ball inside the convex hull of finitely many columns, to rounding.

    Args:
        W: (m, n) wrenches, m >= 2.
    """
    if len(W) > MOST_ROWS:
        return hull_ball(W)
    found = inscribed_ball(point_discs(W), tolerance=0.0)
    if found is not None and found.upper == 0.0:
        return found
    facet = None if found is None else _facet(W, found.weakest)
    if found is None or facet is None:
        return hull_ball(W)
    radius = 1.0 / float(np.linalg.norm(facet))
    if found.radius <= 0.0 or radius > found.upper * (1 + NEAR):
        return hull_ball(W)
    return Ball(radius, radius, facet * radius, W.shape[1])


def inscribed_ball(discs: Floats, *, together: bool = False, tolerance: float = GAP) -> Ball | None:
    """The ball inside the hull (or the sum) of discs, between two bounds; radius 0 if the origin is not inside.

    Args:
        discs: (k, parts, m) as in `solvers.hull_growth_loops`.
        together: sum of the sets instead of the hull of their union.
        tolerance: wanted gap of the bounds, relative; growth aims at half of it.

    Returns:
        The ball, or None if rounding spoilt the search.

    Reference:
        Y. Zheng, An efficient algorithm for a grasp quality measure, IEEE Trans. Robotics 29(2), 2013.
    """
    from mafsil.solvers import hull_growth_loops as growth

    D = np.ascontiguousarray(discs)
    for seed in range(1, TRIES + 1):
        state, lower, upper, weakest, corners = _grown(D, together, 0.5 * tolerance, seed)
        if state == growth.FLAT or (state == growth.MET and lower <= 0.0):
            return Ball(0.0, max(0.0, upper), weakest, corners)
        if state in (growth.MET, growth.FULL):
            grown = Ball(max(0.0, lower), max(0.0, lower, upper), weakest, corners)
            return grown if grown.met or together or D.shape[1] == 1 else _covered(D, grown)
    return None


def _grown(D: Floats, together: bool, tolerance: float, seed: int) -> tuple[int, float, float, Floats, int]:
    """How the growth ended, its two bounds, its direction and how many corners it had."""
    from mafsil.solvers import hull_growth_loops as growth

    m = D.shape[2]
    weakest, (P, R) = np.zeros(m), _workspace(m)
    state, lower, upper, corners = growth.inscribed((0,) * m, D, together, tolerance, P, R, seed, weakest)
    return state, lower, upper, weakest, corners


def _covered(D: Floats, grown: Ball) -> Ball:
    """What growth left open: the least minimum that descents find, and a proof by cones that none reaches less far.

    Where the proof meets a direction that reaches less far, the search goes on from there.
    """
    from mafsil.solvers import direction_cover_loops as cover

    padded = np.zeros((len(D), 4, D.shape[2]))
    padded[:, : D.shape[1]] = D
    m = D.shape[2]
    group, miss = symmetries(padded) if m == MOST_ROWS else (np.eye(m)[None], 0.0)
    wall, stack, u = walls(group), np.empty((cover.STACK, m, m)), np.zeros(m)
    starts = [grown.weakest, *np.random.default_rng(0).normal(size=(DESCENTS, m))]
    upper, weakest = min((_descended(padded, start) for start in starts), key=lambda found: found[0])
    waiting, left, state = cover.begin(m, stack), CONES, cover.LOWER
    while state == cover.LOWER:
        b = upper * (1.0 - 0.5 * GAP)
        state, _, waiting, left = cover.covered(padded, b, wall, stack, waiting, left, u)
        if state == cover.LOWER:
            upper, weakest = min((upper, weakest), _descended(padded, u), key=lambda found: found[0])
    if state != cover.PROVEN:
        return Ball(grown.radius, max(grown.radius, upper), weakest, grown.corners)
    return Ball(max(0.0, upper * (1.0 - 0.5 * GAP) - miss), upper, weakest, grown.corners)


def _descended(D: Floats, start: Floats) -> tuple[float, Floats]:
    """The minimum below a direction, how far the set reaches there and where: downhill, then by Newton's method."""
    from mafsil.solvers import direction_cover_loops as cover

    u = start / np.linalg.norm(start)
    reach = cover.descend(D, u, WIDE, NARROW)
    found = minimum(D, u)
    return (reach, u) if found is None or found.value > reach else (found.value, found.u)


_rooms = threading.local()


def _workspace(m: int) -> Any:
    """The room of this thread for growth in m dimensions."""
    from mafsil.solvers import hull_growth_loops as growth

    kept: dict[str, Any] = _rooms.__dict__
    if str(m) not in kept:
        kept[str(m)] = growth.make_polytope(m, CORNERS, FACETS), growth.make_ridges()
    return kept[str(m)]


def point_discs(W: Floats) -> Floats:
    """Columns (m, n) as discs without extent."""
    return np.ascontiguousarray(W.T[:, None, :])


def _facet(W: Floats, u: Floats) -> Floats | None:
    """The facet that points nearly along u, as v with v . w = 1 on it; None if the points nearby do not make one."""
    from mafsil.solvers.facet_loops import facet_through

    exact = np.empty(len(W))
    if facet_through((0,) * len(W), np.ascontiguousarray(W), u, exact):
        return exact
    heights = u @ W
    near = heights >= heights.max() - NEAR * np.linalg.norm(W, axis=0).max()
    v, _, rank, _ = np.linalg.lstsq(W[:, near].T, np.ones(int(near.sum())), rcond=NEAR)
    if rank < len(W) or (v @ W).max() > 1 + NEAR or np.abs(v @ W[:, near] - 1).max() > NEAR:
        return None
    return np.asarray(v, float)


def hull_ball(W: Floats) -> Ball:
    """The same ball from all facets of the hull: the slow, independent way.

    Args:
        W: (m, n).
    """
    facets = hull_facets(W)
    if facets is None:
        return Ball(0.0, 0.0, np.zeros(len(W)), W.shape[1])
    nearest = int(np.argmin(-facets[:, -1]))
    radius = max(0.0, float(-facets[nearest, -1]))
    return Ball(radius, radius, facets[nearest, :-1], W.shape[1])


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


def distance_to_hull(discs: Floats) -> tuple[float, float, Floats]:
    """Distance from the origin to the hull of discs between two bounds, and the hull's nearest point.

    Args:
        discs: (k, parts, m) as in `solvers.disc_loops`.

    Returns:
        Lower bound, upper bound, nearest point (m,) as long as the upper bound; all 0 if the origin is inside.
    """
    from mafsil.solvers.nearest_point_loops import nearest_point

    nearest = np.empty(discs.shape[2])
    lower, upper = nearest_point(discs, CLOSE, nearest, np.empty_like(nearest))
    return lower, upper, nearest


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
