"""Points some of whose coordinates are angles, found by distance: a tree that knows that a full turn leads back."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats

if TYPE_CHECKING:
    from scipy.spatial import cKDTree


@dataclass(frozen=True, eq=False)
class PointsOnCircles:
    """Points (n, F), to be asked for neighbours.

    Attributes:
        points: coordinates.
        angular: (F,) which of them are angles [rad].
    """

    points: Floats
    angular: NDArray[np.bool_]

    def within(self, centres: Floats, radius: float | Floats) -> list[list[int]]:
        """Indices of the points within a radius of each centre (m, F)."""
        return self._tree.query_ball_point(self._in_box(centres), radius).tolist()

    def nearest(self, centres: Floats, count: int) -> NDArray[np.intp]:
        """(m, count) indices of the points nearest to centres (m, F), the nearest first; fewer if there are fewer."""
        most = min(count, len(self.points))
        ids = self._tree.query(self._in_box(centres), k=list(range(1, most + 1)))[1]
        return np.asarray(ids, dtype=np.intp).reshape(len(centres), most)

    @cached_property
    def _tree(self) -> cKDTree:
        from scipy.spatial import cKDTree

        return cKDTree(self._in_box(self.points), boxsize=np.where(self.angular, 2 * np.pi, 0.0))

    def _in_box(self, points: Floats) -> Floats:
        """(*batch, F) the same points with angles in [0, 2 pi)."""
        inside = np.remainder(points, 2 * np.pi)
        return np.where(self.angular, np.where(inside >= 2 * np.pi, 0.0, inside), points)
