"""Primitives as triangles."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from mafsil.arrays import Floats
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.model.mesh.surface import Surface
from mafsil.model.shape import Box, Capsule, Cylinder, Sphere

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
