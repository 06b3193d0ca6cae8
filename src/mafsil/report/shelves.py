"""What things lie on in the replay where the job describes nothing below them: thin trays, each on a post.

They are drawn so that nothing hangs in the air; no planner and no check knows of them.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from mafsil.arrays import Floats, PoseMatrix
from mafsil.scene import Body, Solid

COLOUR = (0.80, 0.80, 0.77, 1.0)
THIN, RIM, POST = 6e-3, 0.03, 0.01
"""Thickness of a tray, what it has beside things, radius of its post, as shares of the scene."""
SEEN = 0.02
"""Height above the floor below which a thing lies on it, as share of the scene."""
SAME = 1e-3
"""Difference of heights at which things lie on one tray or on one another [m]."""


def shelves(
    lying: Iterable[tuple[Body, PoseMatrix]], others: Iterable[tuple[Body, PoseMatrix]], floor: float, size: float
) -> list[tuple[Body, PoseMatrix]]:
    """Trays below boxes that would hang in the air: one for all that lie side by side at one height.

    Args:
        lying: boxes where they lie, with their poses (4, 4).
        others: solids that stand around, with theirs; what reaches up to a box carries it.
        floor: its height [m].
        size: radius of the scene [m].
    """
    boxes = [_extent(body, T) for body, T in lying]
    carriers = [*boxes, *(_extent(body, T) for body, T in others)]
    trays: list[Floats] = []
    for box in boxes:
        low = box[0, 2]
        if low - floor < SEEN * size or any(_carries(other, box) for other in carriers):
            continue
        rim = RIM * size * np.array([1.0, 1.0, 0.0])
        tray, apart = np.stack([box[0] - rim, [*(box[1, :2] + rim[:2]), low]]), list[Floats]()
        for other in trays:
            if abs(other[0, 2] - low) < SAME and _overlap(other, tray):
                tray = np.stack([np.minimum(tray[0], other[0]), np.maximum(tray[1], other[1])])
            else:
                apart.append(other)
        trays = [*apart, tray]
    return [_drawn(tray, floor, size) for tray in trays]


def _extent(body: Body, T: PoseMatrix) -> Floats:
    """(2, 3) lowest and highest coordinates of solids that are not turned in their body."""
    corners = np.concatenate([_corners(solid) @ T[:3, :3].T + T[:3, 3] for solid in body.solids])
    return np.stack([corners.min(axis=0), corners.max(axis=0)])


def _corners(solid: Solid) -> Floats:
    if solid.surface is not None:
        return solid.surface.vertices
    half = np.array(_edges(solid.kind, solid.size)) / 2.0
    signs = np.array(np.meshgrid(*[[-1.0, 1.0]] * 3)).reshape(3, 8).T
    return signs * half + np.array(solid.pose[:3])


def _edges(kind: str, size: Sequence[float]) -> Sequence[float]:
    """Edges of the box around a solid."""
    width = 2.0 * size[0]
    if kind == "box":
        return size
    return (width, width, width if kind == "sphere" else size[1] + (width if kind == "capsule" else 0.0))


def _overlap(a: Floats, b: Floats) -> bool:
    """Whether two extents lie over one another, seen from above."""
    return bool((a[0, :2] < b[1, :2]).all() and (b[0, :2] < a[1, :2]).all())


def _carries(other: Floats, box: Floats) -> bool:
    """Whether something reaches from below to the underside of a box, or around it."""
    low = box[0, 2]
    return bool(other[0, 2] < low - SAME and other[1, 2] > low - SAME and _overlap(other, box))


def _drawn(tray: Floats, floor: float, size: float) -> tuple[Body, PoseMatrix]:
    """A tray whose upper side is as wide as said, and its post down to the floor."""
    (x, y, top), (width, depth, _) = tray.mean(axis=0).tolist(), (tray[1] - tray[0]).tolist()
    T, height = np.eye(4), top - floor
    T[:3, 3] = x, y, top
    plate = Solid("box", (width, depth, THIN * size), (0.0, 0.0, -THIN * size / 2.0, 1.0, 0.0, 0.0, 0.0), COLOUR)
    post = Solid("cylinder", (POST * size, height), (0.0, 0.0, -height / 2.0, 1.0, 0.0, 0.0, 0.0), COLOUR)
    return Body("shelf", (plate, post)), T
