"""The convex hull of points: corners alone, for what needs only its furthest points."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats


def hull_corners(points: Floats) -> Floats:
    """Those of the points that are corners of their convex hull; of flat or few points all that differ.

    Args:
        points: (k, 3).

    Returns:
        (c, 3).
    """
    from scipy.spatial import ConvexHull, QhullError

    distinct = np.unique(points, axis=0)
    if len(distinct) < 5:
        return distinct
    try:
        return distinct[np.sort(ConvexHull(distinct).vertices)]
    except QhullError:
        return distinct
