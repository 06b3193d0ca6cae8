"""The convex hull of points: corners alone, for what needs only its furthest points, or its triangles."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats
from mafsil.model.mesh.surface import Surface

FEW = 12
"""So many points are all kept: to look for the corners among them, and for a library that does, costs more."""


def hull_corners(points: Floats) -> Floats:
    """Those of the points that are corners of their convex hull; of flat or few points all that differ.

    Args:
        points: (k, 3).

    Returns:
        (c, 3).
    """
    distinct = np.unique(points, axis=0)
    if len(distinct) <= FEW:
        return distinct
    from scipy.spatial import ConvexHull, QhullError

    try:
        return distinct[np.sort(ConvexHull(distinct).vertices)]
    except QhullError:
        return distinct


def hull_surface(points: Floats) -> Surface | None:
    """The triangles of the convex hull, counter-clockwise seen from outside; None of points in one plane.

    Args:
        points: (k, 3).
    """
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError):
        return None
    faces = np.array(hull.simplices, np.int64)
    a, b, c = (points[faces[:, k]] for k in range(3))
    inwards = (np.cross(b - a, c - a) * hull.equations[:, :3]).sum(axis=1) < 0.0
    faces[inwards] = faces[inwards][:, ::-1]
    return Surface(points, faces)
