"""Points of a rigid body: frames from points, distances that a motion keeps, and the motion between two point sets."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix, gate
from mafsil.errors import InputError
from mafsil.geometry import pose, rotation

COLLINEAR = 1e-9
"""Sine of the angle at the first of three points below which they count as lying on a line."""


def body_coordinates(dimension: int) -> int:
    """Independent coordinates of a rigid body: n(n + 1)/2, that is 3 in the plane and 6 in space.

    In space: three points have 9 coordinates, and 3 distances between them are fixed.
    """
    return dimension * (dimension + 1) // 2


def pairwise_distances(points: ArrayLike) -> Floats:
    """(*batch, k, k) distances [m] between the k points (*batch, k, 3)."""
    p = np.asarray(points, dtype=np.float64)
    return np.linalg.norm(p[..., :, None, :] - p[..., None, :, :], axis=-1)


def rigidity_residual(before: ArrayLike, after: ArrayLike) -> Any:
    """(*batch) largest change of a distance [m] between points (*batch, k, 3): zero for a rigid body."""
    return np.abs(pairwise_distances(after) - pairwise_distances(before)).max((-1, -2))


def frame_from_points(origin: ArrayLike, on_x: ArrayLike, beside_x: ArrayLike) -> PoseMatrix:
    """Pose of the frame attached to three points of a body.

    Args:
        origin: (*batch, 3) origin of the frame [m].
        on_x: (*batch, 3) a point of its x axis, on the positive side [m].
        beside_x: (*batch, 3) a point of its x-y plane with y > 0 [m].

    Returns:
        (*batch, 4, 4).

    Raises:
        InputError: the points lie on one line.
    """
    o, a, b = gate("origin", origin, (3,)), gate("on_x", on_x, (3,)), gate("beside_x", beside_x, (3,))
    along, beside = a - o, b - o
    normal = np.cross(along, beside)
    size = np.linalg.norm(along, axis=-1) * np.linalg.norm(beside, axis=-1)
    sine = np.linalg.norm(normal, axis=-1) / np.where(size > 0, size, 1.0)
    if np.any(sine <= COLLINEAR):
        raise InputError("geometry.collinear", name="points", sine=float(np.min(sine)))
    x = along / np.linalg.norm(along, axis=-1, keepdims=True)
    z = normal / np.linalg.norm(normal, axis=-1, keepdims=True)
    return pose.from_rotation_translation(rotation.project(np.stack([x, np.cross(z, x), z], axis=-1)), o)


def fit(points_b: ArrayLike, points_a: ArrayLike) -> PoseMatrix:
    """The pose T_ab that best takes points seen from {b} to the same points seen from {a}, in least squares.

    Args:
        points_b, points_a: (*batch, k, 3) [m], k >= 3 and not on one line.

    Returns:
        (*batch, 4, 4).

    Reference: Horn, Closed-form solution of absolute orientation using unit quaternions, J. Opt. Soc. Am. A 4, 1987.
    """
    b, a = np.asarray(points_b, dtype=np.float64), np.asarray(points_a, dtype=np.float64)
    mean_b, mean_a = b.mean(-2), a.mean(-2)
    correlation = np.einsum("...ki,...kj->...ij", a - mean_a[..., None, :], b - mean_b[..., None, :])
    R = rotation.project(correlation)
    return pose.from_rotation_translation(R, mean_a - rotation.apply(R, mean_b))
