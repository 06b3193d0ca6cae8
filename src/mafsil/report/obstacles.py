"""What stands around the arm of a run, as solids to draw."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from mafsil.arrays import Floats, Integers
from mafsil.collision import Cone, ConvexHull, HeightMap, Obstacle, PointCloud, TriangleMesh
from mafsil.model.mesh import Surface
from mafsil.model.mesh.decimation import decimated
from mafsil.model.mesh.primitives import SIDES
from mafsil.model.mesh.surface import hull_surface
from mafsil.model.shape import Box, Capsule, Cylinder, Sphere
from mafsil.scene import Body, Solid
from mafsil.scene.inline import patch

OBSTACLE_COLOUR = (0.72, 0.66, 0.58, 1.0)
MOST_TRIANGLES = 20_000
"""Of one obstacle in a picture; what is checked keeps all of them."""
MOST_POINTS = 2_000
"""Of one cloud in a picture."""
MOST_ROWS = 96
"""Of one grid of heights in a picture, along each side."""
WIDE, THIN = 1.5, 2e-3
"""What the plate of a half space has beside the scene, and its thickness, as shares of the scene."""
FLAT = 1e-3
"""Thickness of what is flat, in a picture [m]."""
OCTAHEDRON = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], np.float64)
EIGHT_FACES = np.array([[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])


def drawn(obstacles: Iterable[Obstacle], size: float, seen: Floats) -> list[tuple[Body, Floats]]:
    """Each obstacle with its pose; a half space is a flat plate under the scene, wider than it.

    Args:
        obstacles: of the run.
        size: radius of the scene [m].
        seen: (k, 3) points of the scene.
    """
    return [(Body(each.name, (_solid(each, size, seen),)), np.asarray(each.T_so)) for each in obstacles]


def _solid(obstacle: Obstacle, size: float, seen: Floats) -> Solid:
    """One obstacle in its own frame."""
    match obstacle.geometry:
        case Box(size=edges):
            return Solid("box", edges, colour=OBSTACLE_COLOUR)
        case Sphere(radius=radius):
            return Solid("sphere", (radius,), colour=OBSTACLE_COLOUR)
        case Cylinder(radius=radius, length=length):
            return Solid("cylinder", (radius, length), colour=OBSTACLE_COLOUR)
        case Capsule(radius=radius, length=length):
            return Solid("capsule", (radius, length), colour=OBSTACLE_COLOUR)
        case Cone(radius=radius, length=length):
            return _hull(_points_of_cone(radius, length))
        case ConvexHull(points=points):
            return _hull(points)
        case TriangleMesh(vertices=vertices, faces=faces):
            return _surface(Surface(vertices, faces))
        case PointCloud(points=points, radius=radius):
            return _surface(_balls(points, radius))
        case HeightMap() as ground:
            return _surface(_ground(ground))
        case _:
            thin = THIN * size
            (x, y), (a, b) = (each.tolist() for each in patch(np.asarray(obstacle.T_so), seen, WIDE * size))
            return Solid("box", (a, b, thin), (x, y, -thin / 2, 1.0, 0.0, 0.0, 0.0), OBSTACLE_COLOUR)


def _surface(surface: Surface) -> Solid:
    return Solid("surface", (), colour=OBSTACLE_COLOUR, surface=decimated(surface, MOST_TRIANGLES))


def _hull(points: Floats) -> Solid:
    """The hull of points; of flat ones, which have none, the box around them."""
    surface = hull_surface(points)
    if surface is not None:
        return _surface(surface)
    low, high = points.min(axis=0), points.max(axis=0)
    x, y, z = ((low + high) / 2).tolist()
    a, b, c = np.maximum(high - low, FLAT).tolist()
    return Solid("box", (a, b, c), (x, y, z, 1.0, 0.0, 0.0, 0.0), OBSTACLE_COLOUR)


def _points_of_cone(radius: float, length: float) -> Floats:
    """(k, 3) of its base and its apex [m]."""
    angles = np.linspace(0.0, 2.0 * np.pi, SIDES, endpoint=False)
    base = np.stack([radius * np.cos(angles), radius * np.sin(angles), np.full(SIDES, -length / 2.0)], axis=1)
    return np.concatenate([base, [[0.0, 0.0, length / 2.0]]])


def _balls(points: Floats, radius: float) -> Surface:
    """An octahedron for each ball of a cloud, of a large one for some of them."""
    some = points[_some(len(points), MOST_POINTS)]
    corners = some[:, None] + radius * OCTAHEDRON
    faces = EIGHT_FACES + len(OCTAHEDRON) * np.arange(len(some))[:, None, None]
    return Surface(corners.reshape(-1, 3), faces.reshape(-1, 3))


def _ground(ground: HeightMap) -> Surface:
    """Top and sides of a height map, of a fine one every few rows and columns."""
    (rows, columns), (width, depth) = ground.heights.shape, ground.size
    i, j = _some(rows, MOST_ROWS), _some(columns, MOST_ROWS)
    x, y = np.meshgrid(np.linspace(-width / 2, width / 2, columns)[j], np.linspace(-depth / 2, depth / 2, rows)[i])
    top = np.stack([x, y, ground.heights[np.ix_(i, j)]], axis=2)
    number = np.arange(len(i) * len(j)).reshape(len(i), len(j))
    faces = _quads(number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1])
    rim = np.concatenate([number[0, :-1], number[:-1, -1], number[-1, :0:-1], number[:0:-1, 0]])
    after, low = np.roll(rim, -1), number.size + np.arange(len(rim))
    under = top.reshape(-1, 3)[rim] * [1.0, 1.0, 0.0] + [0.0, 0.0, ground.base]
    sides = _quads(rim, low, np.roll(low, -1), after)
    return Surface(np.concatenate([top.reshape(-1, 3), under]), np.concatenate([faces, sides]))


def _some(count: int, most: int) -> Integers:
    """Numbers below a count, evenly, the first and the last among them."""
    found: Floats = np.linspace(0.0, count - 1.0, min(count, most))
    return found.round().astype(np.int64)


def _quads(
    *corners: np.ndarray[tuple[int, ...], np.dtype[np.int64]],
) -> np.ndarray[tuple[int, ...], np.dtype[np.int64]]:
    """(2 k, 3) triangles of quadrilaterals whose corners go round."""
    a, b, c, d = (np.ravel(each) for each in corners)
    return np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
