"""The convex hull of any finite point set: a point, a segment, a flat polygon or a body, of whatever dimension."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, require_finite
from mafsil.errors import InputError
from mafsil.grasp.tolerances import RANK


@dataclass(frozen=True, eq=False)
class Hull:
    """The convex hull.

    Attributes:
        points: (n, m) as given.
        vertices: indices of its corners, ascending; of polygons counter-clockwise in their own plane.
        dimension: of the hull: 0 a point, 1 a segment, 2 a flat polygon, up to m.
        basis: (dimension, m) orthonormal directions that span it.
        facets: (f, dimension + 1) rows (u, -d): in coordinates z along `basis` from the first point, u . z <= d.
    """

    points: Floats
    vertices: NDArray[np.int64]
    dimension: int
    basis: Floats
    facets: Floats

    def contains(self, point: ArrayLike, *, strictly: bool = False) -> bool:
        """Whether a point is in the hull; strictly: inside of it, which a flat hull has for no point of the space.

        Args:
            point: (m,).
            strictly: the boundary does not count.
        """
        p = np.asarray(point, float) - self.points[0]
        size = float(np.abs(self.points - self.points[0]).max()) or 1.0
        z = self.basis @ p
        if np.abs(p - z @ self.basis).max() > RANK * size or (strictly and self.dimension < len(p)):
            return False
        heights = self.facets[:, :-1] @ z + self.facets[:, -1]
        worst = float(heights.max()) if len(heights) else 0.0
        return worst < -RANK * size if strictly else worst <= RANK * size


def convex_hull(points: ArrayLike) -> Hull:
    """The convex hull of points in m dimensions, flat sets too.

    Args:
        points: (n, m), n >= 1.

    Raises:
        InputError: no points, or numbers that are not finite.
    """
    P = require_finite("points", np.asarray(points, float))
    if P.ndim != 2 or not P.size:
        raise InputError("grasp.no_hull", got=P.shape)
    offsets = P - P[0]
    _, s, Vt = np.linalg.svd(offsets)
    rank = int((s > RANK * s[0]).sum()) if s[0] > 0 else 0
    basis = Vt[:rank]
    z = offsets @ basis.T
    if rank == 0:
        return Hull(P, np.zeros(1, np.int64), 0, basis, np.zeros((0, 1)))
    if rank == 1:
        low, high = int(np.argmin(z[:, 0])), int(np.argmax(z[:, 0]))
        facets = np.array([[1.0, -z[high, 0]], [-1.0, z[low, 0]]])
        return Hull(P, np.array(sorted((low, high)), np.int64), 1, basis, facets)
    from scipy.spatial import ConvexHull

    found = ConvexHull(z)
    vertices = np.asarray(found.vertices, np.int64)
    return Hull(P, vertices if rank == 2 else np.sort(vertices), rank, basis, np.unique(found.equations, axis=0))
