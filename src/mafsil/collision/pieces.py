"""Geometries as convex pieces in arrays, the form that the compiled loops read."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain
from math import hypot, inf

import numpy as np

from mafsil.arrays import Floats, PoseMatrix
from mafsil.collision.piece_loops import (
    BALL,
    BODY,
    BOX,
    COLUMNS,
    CONE,
    CORNERS,
    CYLINDER,
    FIRST,
    HULL,
    KIND,
    PLANE,
    POINT,
    ROUNDING,
    SEGMENT,
    SIZE,
    Pieces,
)
from mafsil.collision.shapes import (
    Cone,
    ConvexHull,
    Geometry,
    HeightMap,
    Plane,
    PointCloud,
    TriangleMesh,
)
from mafsil.errors import InputError
from mafsil.model.link import Box, Capsule, Cylinder, Mesh, Sphere
from mafsil.model.mesh.reader import read
from mafsil.model.mesh.surface import hull_corners


@dataclass(frozen=True, eq=False, slots=True)
class Rows:
    """Pieces of one geometry, all of one kind.

    Attributes:
        kind, size, rounding: as in `Pieces`.
        corners: (k, c, 3) of hulls, in the geometry's frame; c = 0 for other kinds.
        centres: (k, 3) of the balls around the pieces, and where pieces that are no hulls stand.
        radii: (k,) of the balls.
    """

    kind: int
    size: tuple[float, float, float]
    rounding: float
    corners: Floats
    centres: Floats
    radii: Floats


def pieces_of(geometries: Sequence[tuple[Geometry, PoseMatrix, int]]) -> Pieces:
    """Convex pieces of placed geometries.

    1. Those of one piece that stands where they stand, all at once.
    2. The others: hulls, and clouds of balls.

    Args:
        geometries: geometry, its pose (4, 4) in its body, index of the body.
    """
    lone = [_numbers(each[0]) for each in geometries]
    rows = {k: _rows_of(geometries[k][0]) for k, one in enumerate(lone) if one is None}
    counts = [len(rows[k].radii) if k in rows else 1 for k in range(len(lone))] if rows else []
    total = sum(counts) if rows else len(lone)
    ends = np.cumsum(counts) if rows else np.zeros(0, np.int64)
    table, poses = np.zeros((total, COLUMNS)), np.empty((total, 3, 4))
    if len(rows) < len(lone):  # 1
        here = ends[[one is not None for one in lone]] - 1 if rows else slice(None)
        placed = [each for each, one in zip(geometries, lone, strict=True) if one is not None]
        numbers = np.fromiter(chain.from_iterable(one for one in lone if one is not None), np.float64).reshape(-1, 6)
        T = np.array([each[1] for each in placed])[:, :3]
        table[here, : ROUNDING + 1], table[here, BALL + 3] = numbers[:, :5], numbers[:, 5]
        table[here, BODY], table[here, BALL : BALL + 3] = [each[2] for each in placed], T[:, :, 3]
        poses[here] = T
    if not rows:
        return Pieces(table, poses, np.zeros((0, 3)))
    for k, r in rows.items():  # 2
        _, T, body = geometries[k]
        part, centres = slice(int(ends[k]) - len(r.radii), int(ends[k])), r.centres @ T[:3, :3].T + T[:3, 3]
        table[part, KIND], table[part, SIZE : SIZE + 3], table[part, ROUNDING] = r.kind, r.size, r.rounding
        table[part, CORNERS], table[part, BODY] = r.corners.shape[1], body
        table[part, BALL : BALL + 3], table[part, BALL + 3], poses[part] = centres, r.radii, T[:3]
        if r.kind != HULL:
            poses[part, :, 3] = centres
    table[:, FIRST] = np.cumsum(table[:, CORNERS]) - table[:, CORNERS]
    return Pieces(table, poses, np.concatenate([r.corners.reshape(-1, 3) for r in rows.values()]))


def _numbers(geometry: Geometry) -> tuple[float, ...] | None:
    """Kind, size (3), rounding of a geometry of one piece, and the radius of the ball around it; None for others."""
    match geometry:
        case Sphere(radius=radius):
            return POINT, 0.0, 0.0, 0.0, radius, radius
        case Capsule(radius=radius, length=length):
            return SEGMENT, 0.0, 0.0, length / 2, radius, radius + length / 2
        case Box(size=(x, y, z)):
            return BOX, x / 2, y / 2, z / 2, 0.0, hypot(x, y, z) / 2
        case Cylinder(radius=radius, length=length):
            return CYLINDER, radius, 0.0, length / 2, 0.0, hypot(radius, length / 2)
        case Cone(radius=radius, length=length):
            return CONE, radius, 0.0, length / 2, 0.0, hypot(radius, length / 2)
        case Plane():
            return PLANE, 0.0, 0.0, 0.0, 0.0, inf
        case _:
            return None


def _rows_of(geometry: Geometry) -> Rows:
    """The convex pieces of a geometry of many, or of a hull."""
    match geometry:
        case ConvexHull(points=points, rounding=rounding):
            return _hulls(hull_corners(points)[None], rounding)
        case TriangleMesh(vertices=vertices, faces=faces):
            return _hulls(vertices[faces], 0.0)
        case PointCloud(points=points, radius=radius):
            none = np.zeros((len(points), 0, 3))
            return Rows(POINT, (0.0, 0.0, 0.0), radius, none, points, np.full(len(points), radius))
        case HeightMap():
            return _hulls(_prisms(geometry), 0.0)
        case Mesh(path=path, scale=scale):
            if path is None:
                raise InputError("collision.no_mesh", reference=geometry.reference)
            surface = read(path).scale(scale)
            return _hulls(surface.vertices[surface.faces], 0.0)
        case _:
            raise TypeError(type(geometry).__name__)


def _hulls(corners: Floats, rounding: float) -> Rows:
    """Hulls of (k, c, 3) corners, each in a ball about the middle of its extent: around the corners, at least."""
    centres = (corners.min(axis=1) + corners.max(axis=1)) / 2
    radii = np.sqrt(((corners - centres[:, None]) ** 2).sum(axis=2).max(axis=1)) + max(rounding, 0.0)
    return Rows(HULL, (0.0, 0.0, 0.0), rounding, corners, centres, radii)


def _prisms(ground: HeightMap) -> Floats:
    """(k, 6, 3) corners of the prisms below the two triangles of each cell."""
    heights, (width, depth) = ground.heights, ground.size
    rows, columns = heights.shape
    x, y = np.meshgrid(np.linspace(-width / 2, width / 2, columns), np.linspace(-depth / 2, depth / 2, rows))
    top = np.stack([x, y, heights], axis=2)
    a, b, c, d = top[:-1, :-1], top[:-1, 1:], top[1:, 1:], top[1:, :-1]
    triangles = np.concatenate([np.stack(t, axis=2).reshape(-1, 3, 3) for t in ((a, b, c), (a, c, d))])
    under = triangles.copy()
    under[..., 2] = ground.base
    return np.concatenate([triangles, under], axis=1)
