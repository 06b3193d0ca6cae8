"""Where do rays leave a triangle mesh? Compiled: every ray against every triangle (Moeller and Trumbore).

For a triangle with corner a and edges u, v:

1. det = u . (d x v) is negative where the ray's direction d leaves through the outer side; the others are passed over.
2. Barycentric coordinates of the ray's point in the triangle's plane: outside of 0 .. 1, the ray goes by.
3. The distance along the ray; the nearest beyond the start wins.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.kernels.loops.loop import compiled
from mafsil.solvers.tolerances import PARALLEL


@compiled
def exits(
    corners: Floats, origins: Floats, directions: Floats, least: float, distance: Floats, face: NDArray[np.int64]
) -> None:
    """The nearest triangle beyond `least` that each ray crosses from inside to outside.

    Args:
        corners: (f, 3, 3) corners, counter-clockwise from outside.
        origins, directions: (r, 3) rays, directions of length 1.
        least: distances up to it are the start itself.
        distance: (r,) out: infinite if the ray meets none.
        face: (r,) out: index of the triangle, or -1.

    Reference:
        T. Moeller, B. Trumbore, Fast, minimum storage ray/triangle intersection, J. Graphics Tools 2(1), 1997.
    """
    for r in range(len(origins)):
        ox, oy, oz = origins[r, 0], origins[r, 1], origins[r, 2]
        dx, dy, dz = directions[r, 0], directions[r, 1], directions[r, 2]
        best, found = np.inf, -1
        for k in range(len(corners)):
            ax, ay, az = corners[k, 0, 0], corners[k, 0, 1], corners[k, 0, 2]
            ux, uy, uz = corners[k, 1, 0] - ax, corners[k, 1, 1] - ay, corners[k, 1, 2] - az
            vx, vy, vz = corners[k, 2, 0] - ax, corners[k, 2, 1] - ay, corners[k, 2, 2] - az
            px, py, pz = dy * vz - dz * vy, dz * vx - dx * vz, dx * vy - dy * vx
            det = ux * px + uy * py + uz * pz  # 1
            if det > -PARALLEL * (abs(ux) + abs(uy) + abs(uz)) * (abs(px) + abs(py) + abs(pz)):
                continue
            tx, ty, tz = ox - ax, oy - ay, oz - az
            a = (tx * px + ty * py + tz * pz) / det  # 2
            if a < 0.0 or a > 1.0:
                continue
            qx, qy, qz = ty * uz - tz * uy, tz * ux - tx * uz, tx * uy - ty * ux
            b = (dx * qx + dy * qy + dz * qz) / det
            if b < 0.0 or a + b > 1.0:
                continue
            t = (vx * qx + vy * qy + vz * qz) / det  # 3
            if least < t < best:
                best, found = t, k
        distance[r], face[r] = best, found
