"""Triangles: the limits within which they are read, the convex hull of points, and primitives as triangles.

A hull is its corners alone, for what needs only its furthest points, or its triangles.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, frozen
from mafsil.code_store import digest_of, kept_array
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.model.link import Box, Capsule, Cylinder, Sphere
from mafsil.regular_file import FileStamps

Faces: TypeAlias = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class MeshLimits:
    """Sizes beyond which a mesh file is refused: bytes of the file, triangles."""

    bytes: int = 128 << 20
    faces: int = 1_000_000


DEFAULT_LIMITS = MeshLimits()


@dataclass(frozen=True, eq=False, slots=True)
class Surface:
    """Triangles in the unit of the file's own frame [m].

    Attributes:
        vertices: (v, 3) points.
        faces: (f, 3) indices into `vertices`, counter-clockwise seen from outside.
        colours: (f, 4) red, green, blue, opacity in 0..1 per triangle, or None.
        dropped: triangles left out because a corner is not finite or the area is zero.
    """

    vertices: Floats
    faces: Faces
    colours: Floats | None = None
    dropped: int = 0

    def scale(self, scale: tuple[float, float, float]) -> Surface:
        """The surface stretched along x, y, z; turned inside out again where the factors mirror it."""
        faces = self.faces[:, ::-1] if np.prod(np.sign(scale)) < 0 else self.faces
        return replace(self, vertices=self.vertices * np.array(scale), faces=faces)


def clean_surface(vertices: Floats, faces: Faces, colours: Floats | None = None) -> Surface:
    """A surface without triangles that have a corner that is not finite, or no area, and without such corners."""
    corners = vertices[faces]
    finite = np.isfinite(corners).all(axis=(1, 2))
    with np.errstate(invalid="ignore", over="ignore"):
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        good = finite & np.isfinite(normals).all(axis=1) & (np.abs(normals).max(axis=1, initial=0.0) > 0.0)
    kept = faces[good]
    if not np.isfinite(vertices).all():
        used, places = np.unique(kept, return_inverse=True)
        vertices, kept = vertices[used], places.reshape(-1, 3)
    return Surface(vertices, kept, None if colours is None else colours[good], int((~good).sum()))


FEW = 12
"""So many points are all kept: to look for the corners among them, and for a library that does, costs more."""
MOST_KEPT = 256
"""Hulls of robots' parts in memory."""
_CORNERS: dict[str, Floats] = {}
"""Corners by the digest of the points."""


def hull_corners(points: Floats) -> Floats:
    """Those of the points that are corners of their convex hull; of flat or few points all that differ.

    Args:
        points: (k, 3).

    Returns:
        (c, 3).
    """
    known = _CORNERS.get(digest_of(points)) if _CORNERS and len(points) > FEW else None
    return _corners_of(points) if known is None else known


def keep_hull_corners(points: Floats) -> None:
    """Have the corners of a hull ready for `hull_corners`, in this process and the next ones."""
    if len(points) <= FEW:
        return
    name = digest_of(points)
    if name not in _CORNERS:
        corners = kept_array(digest_of("hull", name, _scipy(), str(FEW)), lambda: _corners_of(points))
        _CORNERS[name] = frozen(corners)
        for oldest in list(_CORNERS)[:-MOST_KEPT]:
            _CORNERS.pop(oldest, None)


def _corners_of(points: Floats) -> Floats:
    distinct = np.unique(points, axis=0)
    if len(distinct) <= FEW:
        return distinct
    from scipy.spatial import ConvexHull, QhullError

    try:
        return distinct[np.sort(ConvexHull(distinct).vertices)]
    except QhullError:
        return distinct


@cache
def _scipy() -> str:
    """Which release of the library finds them: another one has other files."""
    spec = find_spec("scipy")
    return repr(FileStamps.of([Path(spec.origin).with_name("version.py")] if spec and spec.origin else ()).stamps)


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


SIDES = 24
_ARC = 7


def triangles(geometry: Box | Cylinder | Capsule | Sphere) -> Surface:
    """The surface of a primitive, in its own frame.

    Args:
        geometry: a primitive; round ones get SIDES sides.
    """
    match geometry:
        case Box(size=size):
            return _box(np.array(size) / 2)
        case Sphere(radius=radius):
            return _turn(np.concatenate([_arc(radius, 0.0, -90, 0), _arc(radius, 0.0, 0, 90)[1:]]))
        case Capsule(radius=radius, length=length):
            return _turn(np.concatenate([_arc(radius, -length / 2, -90, 0), _arc(radius, length / 2, 0, 90)]))
        case Cylinder(radius=radius, length=length):
            h = length / 2
            return _turn(np.array([[0.0, -h], [radius, -h], [radius, h], [0.0, h]]))


def _arc(radius: float, z: float, start: float, end: float) -> Floats:
    """(k, 2) points (r, z) of a circle about (0, z), from one latitude to another [deg]."""
    angles = np.radians(np.linspace(start, end, _ARC))
    return np.stack([radius * np.cos(angles), z + radius * np.sin(angles)], axis=1)


def _fine(profile: Floats) -> Floats:
    """The same line with a point at least every half of its largest radius: long thin triangles sort badly by depth."""
    step = max(float(profile[:, 0].max()) / 2, float(np.ptp(profile[:, 1])) / 100, LEAST_DIVISOR)
    rows = [profile[:1]]
    for start, end in pairwise(profile):
        count = max(1, int(np.ceil(np.linalg.norm(end - start) / step)))
        rows.append(start + (end - start) * np.arange(1, count + 1)[:, None] / count)
    return np.concatenate(rows)


def _turn(outline: Floats) -> Surface:
    """Surface of revolution of points (r, z) about z."""
    profile = _fine(outline)
    turns = 2 * np.pi * np.arange(SIDES) / SIDES
    rings = np.stack(
        [
            np.outer(np.cos(turns), profile[:, 0]),
            np.outer(np.sin(turns), profile[:, 0]),
            np.broadcast_to(profile[:, 1], (SIDES, len(profile))),
        ],
        axis=-1,
    )
    rows = len(profile)
    here = (np.arange(SIDES)[:, None] * rows + np.arange(rows - 1)[None]).reshape(-1)
    there = (here + rows) % (SIDES * rows)
    faces = np.concatenate([np.stack([here, there, there + 1], 1), np.stack([here, there + 1, here + 1], 1)])
    vertices = rings.reshape(-1, 3)
    corners = vertices[faces]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return Surface(vertices, faces[area > 0.0])


def _box(half: Floats) -> Surface:
    signs = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
    quads = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    return Surface(signs * half, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]))
