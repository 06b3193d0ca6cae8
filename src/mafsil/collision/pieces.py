"""Geometries as convex pieces in arrays, the form that the compiled loops read."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats, PoseMatrix
from mafsil.collision.shapes import (
    Cone,
    ConvexHull,
    Geometry,
    HeightMap,
    Plane,
    PointCloud,
    TriangleMesh,
)
from mafsil.collision.support_loops import (
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
from mafsil.collision.tree_loops import Surroundings, build_tree
from mafsil.errors import InputError
from mafsil.model.mesh.reader import read
from mafsil.model.mesh.surface import hull_corners
from mafsil.model.shape import Box, Capsule, Cylinder, Mesh, Sphere

ROUNDED = 1e-12
"""What boxes are larger by than their pieces, so that no rounding of either matters [m]."""


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

    Args:
        geometries: geometry, its pose (4, 4) in its body, index of the body.
    """
    rows = [(rows_of(geometry), T, body) for geometry, T, body in geometries]
    total = sum(len(r.radii) for r, _, _ in rows)
    table, poses, last = np.zeros((total, COLUMNS)), np.empty((total, 3, 4)), 0
    for r, T, body in rows:
        first, last = last, last + len(r.radii)
        part, centres = table[first:last], r.centres @ T[:3, :3].T + T[:3, 3]
        part[:, KIND], part[:, SIZE : SIZE + 3], part[:, ROUNDING] = r.kind, r.size, r.rounding
        part[:, CORNERS], part[:, BODY] = r.corners.shape[1], body
        part[:, BALL : BALL + 3], part[:, BALL + 3] = centres, r.radii
        poses[first:last] = T[:3]
        if r.kind != HULL:
            poses[first:last, :, 3] = centres
    table[:, FIRST] = np.cumsum(table[:, CORNERS]) - table[:, CORNERS]
    return Pieces(table, poses, np.concatenate([np.zeros((0, 3)), *(r.corners.reshape(-1, 3) for r, _, _ in rows)]))


def surroundings_of(pieces: Pieces) -> Surroundings:
    """Pieces posed in {s} with a tree over those that have bounds."""
    plane = pieces.rows[:, KIND] == PLANE
    bounded, corners = np.flatnonzero(~plane), boxes(pieces)
    nodes, leaves = build_tree(corners[bounded])
    order = np.concatenate([np.flatnonzero(plane), bounded[leaves]])
    low, high = corners[order, :3], corners[order, 3:]
    with np.errstate(invalid="ignore"):  # Half spaces have no middle.
        middles = np.where(np.isfinite(low), (low + high) / 2, 0.0)
        around = np.concatenate([middles, np.maximum(high - middles, middles - low) + ROUNDED], axis=1)
    return Surroundings(pieces._replace(rows=pieces.rows[order], T=pieces.T[order]), nodes, around, int(plane.sum()))


def rows_of(geometry: Geometry) -> Rows:
    """The convex pieces of one geometry."""
    match geometry:
        case Sphere(radius=radius):
            return _one(POINT, (0.0, 0.0, 0.0), radius, radius)
        case Capsule(radius=radius, length=length):
            return _one(SEGMENT, (0.0, 0.0, length / 2), radius, radius + length / 2)
        case Box(size=(x, y, z)):
            return _one(BOX, (x / 2, y / 2, z / 2), 0.0, float(np.linalg.norm([x, y, z])) / 2)
        case Cylinder(radius=radius, length=length):
            return _one(CYLINDER, (radius, 0.0, length / 2), 0.0, float(np.hypot(radius, length / 2)))
        case Cone(radius=radius, length=length):
            return _one(CONE, (radius, 0.0, length / 2), 0.0, float(np.hypot(radius, length / 2)))
        case Plane():
            return _one(PLANE, (0.0, 0.0, 0.0), 0.0, np.inf)
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


def _one(kind: int, size: tuple[float, float, float], rounding: float, radius: float) -> Rows:
    return Rows(kind, size, rounding, np.zeros((1, 0, 3)), np.zeros((1, 3)), np.array([radius]))


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


def boxes(pieces: Pieces) -> Floats:
    """(k, 6) lowest and highest coordinates of each piece in its body's frame; of a half space without bounds."""
    R, p, kinds = pieces.T[:, :, :3], pieces.T[:, :, 3], pieces.rows[:, KIND]
    sizes = pieces.rows[:, SIZE : SIZE + 3]
    reach = (np.abs(R) @ sizes[:, :, None]) * [-1.0, 1.0]
    for kind in (CYLINDER, CONE):
        rows = kinds == kind
        axis, radius, half = R[rows][:, :, 2], sizes[rows, 0], sizes[rows, 2]
        extent = np.sqrt(np.maximum(0.0, 1.0 - axis**2)) * radius[:, None] + np.abs(axis) * half[:, None]
        reach[rows] = extent[:, :, None] * [-1.0, 1.0]
    rows, counts = np.flatnonzero(kinds == HULL), pieces.rows[:, CORNERS].astype(np.int64)
    for count in np.unique(counts[rows]):
        same = rows[counts[rows] == count]
        at = pieces.rows[same, FIRST].astype(np.int64)
        corners = pieces.vertices[at[:, None] + np.arange(count)] @ R[same].transpose(0, 2, 1)
        reach[same] = np.stack([corners.min(axis=1), corners.max(axis=1)], axis=2)
    found = np.concatenate([p + reach[:, :, 0], p + reach[:, :, 1]], axis=1)
    grown = found + np.outer(np.maximum(pieces.rows[:, ROUNDING], 0.0), [-1.0, -1.0, -1.0, 1.0, 1.0, 1.0])
    grown[kinds == PLANE] = [-np.inf, -np.inf, -np.inf, np.inf, np.inf, np.inf]
    return grown
