"""Epsilon quality of a grasp: the radius of the largest ball about the origin inside its set of wrenches.

The set is the hull of points or of discs (round cones), so a true friction cone costs no more than a polyhedral one.
Rotations and mirrors that map the contacts of a grasp onto each other act on wrenches, too; what they map onto each
other need be searched only once: of all images of a direction the one that reaches furthest along a fixed vector z
stands for the others.

Reference:
    C. Ferrari, J. Canny, Planning optimal grasps, IEEE ICRA 1992.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats
from mafsil.grasp import loops
from mafsil.grasp.hull import minimum
from mafsil.grasp.tolerances import DISTANCE_GAP, ON_FACET, QUALITY_GAP, SYMMETRIC

if TYPE_CHECKING:
    from mafsil.solvers.hull_growth_loops import Polytope, Ridges


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


MOST_ROWS = 6
"""Dimension of wrenches for which the compiled growth has buffers; larger sets go to Qhull."""
VERTICES, FACETS = 1000, 60_000
"""Sizes of the buffers of the growth, kept for the next one; most searches touch little of them."""
TRIES = 3
CONES = 1_000_000
"""Of directions looked at in a proof at most: about five seconds."""
DESCENTS, WIDE, NARROW = 5, 0.5, 1e-6
"""Random starts of descents, and the first and last width of their steps."""


class QualityStatus(Status):
    """How well the epsilon quality is known."""

    CONVERGED = ("grasp.epsilon", True)
    BOUNDED = ("grasp.epsilon_between", True)
    ZERO = ("grasp.epsilon_zero", False)
    UNKNOWN = ("grasp.epsilon_below", False)


@dataclass(frozen=True, eq=False, repr=False)
class GraspQuality(Answer, data="epsilon upper converged weakest_direction"):
    """Ferrari and Canny's epsilon quality; true if it is proven to be positive.

    Attributes:
        epsilon: radius of the largest ball about the origin that is proven to fit; 0 if the origin is not strictly
            inside.
        upper: radius that is proven not to be exceeded; equal to `epsilon` for finitely many wrenches.
        weakest_direction: (m,) unit direction in which the set reaches least far; the wrench against it is the hardest.
        vertices: how many wrenches the polytope had.
    """

    epsilon: float
    upper: float
    weakest_direction: Floats
    vertices: int

    @property
    def converged(self) -> bool:
        """Whether the bounds are within a millionth of each other; if not, epsilon is only known to lie between."""
        return agree(self.epsilon, self.upper)

    @property
    def status(self) -> QualityStatus:
        """Whether epsilon is positive, and whether its bounds have met."""
        if self.epsilon > 0.0:
            return QualityStatus.CONVERGED if self.converged else QualityStatus.BOUNDED
        return QualityStatus.ZERO if self.converged else QualityStatus.UNKNOWN


def agree(lower: float, upper: float) -> bool:
    """Whether two bounds are within a millionth of each other."""
    return upper - lower <= QUALITY_GAP * abs(upper) * (1.0 + ON_FACET)


def quality_of_wrenches(W: Floats) -> GraspQuality:
    """The quality of finitely many wrenches, to rounding.

    Args:
        W: (m, n) wrenches, m >= 2.
    """
    if len(W) > MOST_ROWS:
        return quality_by_facets(W)
    found = quality_of_discs(point_discs(W), tolerance=0.0)
    if found is not None and found.upper == 0.0:
        return found
    facet = None if found is None else _facet(W, found.weakest_direction)
    if found is None or facet is None:
        return quality_by_facets(W)
    radius = 1.0 / float(np.linalg.norm(facet))
    if found.epsilon <= 0.0 or radius > found.upper * (1 + ON_FACET):
        return quality_by_facets(W)
    return GraspQuality(radius, radius, facet * radius, W.shape[1])


def quality_of_discs(discs: Floats, *, together: bool = False, tolerance: float = QUALITY_GAP) -> GraspQuality | None:
    """The quality of the hull (or the sum) of discs, between two bounds; epsilon 0 if the origin is not inside.

    Args:
        discs: (k, parts, m) as in `solvers.hull_growth_loops`.
        together: sum of the sets instead of the hull of their union.
        tolerance: largest gap of the bounds, relative; growth aims at half of it.

    Returns:
        The quality, or None if rounding spoilt the search.

    Reference:
        Y. Zheng, An efficient algorithm for a grasp quality measure, IEEE Trans. Robotics 29(2), 2013.
    """
    growth, D = loops.hull_growth_loops, np.ascontiguousarray(discs)
    for seed in range(1, TRIES + 1):
        state, lower, upper, weakest, vertices = _grown(D, together, 0.5 * tolerance, seed)
        if state == growth.FLAT or (state == growth.CONVERGED and lower <= 0.0):
            return GraspQuality(0.0, max(0.0, upper), weakest, vertices)
        if state in (growth.CONVERGED, growth.FULL):
            grown = GraspQuality(max(0.0, lower), max(0.0, lower, upper), weakest, vertices)
            return grown if grown.converged or together or D.shape[1] == 1 else _cover(D, grown)
    return None


def _grown(D: Floats, together: bool, tolerance: float, seed: int) -> tuple[int, float, float, Floats, int]:
    """How the growth ended, its two bounds, its direction and how many vertices it had."""
    m = D.shape[2]
    weakest, (polytope, ridges) = np.zeros(m), _workspace(m)
    state, lower, upper, vertices = loops.hull_growth_loops.inscribed_ball(
        (0,) * m, D, together, tolerance, polytope, ridges, seed, weakest
    )
    return state, lower, upper, weakest, vertices


def _cover(D: Floats, grown: GraspQuality) -> GraspQuality:
    """What growth left open: the least minimum that descents find, and a proof by cones that none reaches less far.

    1. Discs that symmetries map onto each other are searched once, within the walls of one region.
    2. Descents from the direction that growth left and from random ones give the least reach known.
    3. Cones of directions are proven to reach as far, less half the gap (`solvers.direction_cover_loops`).
    4. Where a direction reaches less far, a descent from there gives the next least reach, and 3 goes on.
    """
    cover = loops.direction_cover_loops
    padded = np.zeros((len(D), 4, D.shape[2]))
    padded[:, : D.shape[1]] = D
    m = D.shape[2]
    group, deviation = symmetries(padded) if m == MOST_ROWS else (np.eye(m)[None], 0.0)  # 1
    wall, stack, u = walls(group), np.empty((cover.STACK, m, m)), np.zeros(m)
    starts = [grown.weakest_direction, *np.random.default_rng(0).normal(size=(DESCENTS, m))]
    upper, weakest = min((_descend(padded, start) for start in starts), key=lambda found: found[0])  # 2
    waiting, left, state = cover.begin(m, stack), CONES, cover.LOWER  # 3
    while state == cover.LOWER:
        b = upper * (1.0 - 0.5 * QUALITY_GAP)
        state, _, waiting, left = cover.prove_cover(padded, b, wall, stack, waiting, left, u)
        if state == cover.LOWER:
            upper, weakest = min((upper, weakest), _descend(padded, u), key=lambda found: found[0])  # 4
    if state != cover.PROVEN:
        return GraspQuality(grown.epsilon, max(grown.epsilon, upper), weakest, grown.vertices)
    return GraspQuality(max(0.0, upper * (1.0 - 0.5 * QUALITY_GAP) - deviation), upper, weakest, grown.vertices)


def _descend(D: Floats, start: Floats) -> tuple[float, Floats]:
    """The minimum below a direction, how far the set reaches there and where: downhill, then by Newton's method."""
    u = start / np.linalg.norm(start)
    reach = loops.direction_cover_loops.descend(D, u, WIDE, NARROW)
    found = minimum(D, u)
    return (reach, u) if found is None or found.value > reach else (found.value, found.u)


_buffers = threading.local()


def _workspace(m: int) -> tuple[Polytope, Ridges]:
    """The buffers of this thread for growth in m dimensions."""
    kept: dict[str, tuple[Polytope, Ridges]] = _buffers.__dict__
    if str(m) not in kept:
        growth = loops.hull_growth_loops
        kept[str(m)] = growth.make_polytope(m, VERTICES, FACETS), growth.make_ridges()
    return kept[str(m)]


def point_discs(W: Floats) -> Floats:
    """Columns (m, n) as discs without extent."""
    return np.ascontiguousarray(W.T[:, None, :])


def _facet(W: Floats, u: Floats) -> Floats | None:
    """The facet that points nearly along u, as v with v . w = 1 on it; None if the points nearby do not make one."""
    exact = np.empty(len(W))
    if loops.nearest_point_loops.facet_through((0,) * len(W), np.ascontiguousarray(W), u, exact):
        return exact
    heights = u @ W
    near = heights >= heights.max() - ON_FACET * np.linalg.norm(W, axis=0).max()
    v, _, rank, _ = np.linalg.lstsq(W[:, near].T, np.ones(int(near.sum())), rcond=ON_FACET)
    if rank < len(W) or (v @ W).max() > 1 + ON_FACET or np.abs(v @ W[:, near] - 1).max() > ON_FACET:
        return None
    return np.asarray(v, float)


def quality_by_facets(W: Floats) -> GraspQuality:
    """The same quality from all facets of the hull: the slow, independent method.

    Args:
        W: (m, n).
    """
    facets = hull_facets(W)
    if facets is None:
        return GraspQuality(0.0, 0.0, np.zeros(len(W)), W.shape[1])
    nearest = int(np.argmin(-facets[:, -1]))
    radius = max(0.0, float(-facets[nearest, -1]))
    return GraspQuality(radius, radius, facets[nearest, :-1], W.shape[1])


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
    nearest = np.empty(discs.shape[2])
    lower, upper = loops.nearest_point_loops.nearest_point(discs, DISTANCE_GAP, nearest, np.empty_like(nearest))
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
