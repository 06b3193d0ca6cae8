"""Angles as points of a torus: differences, distances and means that know that a turn leads back; charts; a picture."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, real_array
from mafsil.errors import InputError
from mafsil.mobility.spaces.planar_positions import finite_numbers, wrap_angle


def chart(q: ArrayLike) -> Floats:
    """(*batch, n) angles in [0, 2 pi): the flat square, with its seam counted once."""
    angle = np.remainder(finite_numbers("q", q), 2 * np.pi)
    return np.where(angle == 2 * np.pi, 0.0, angle)


def difference(a: ArrayLike, b: ArrayLike) -> Floats:
    """(*batch, n) shortest way b - a of each angle in (-pi, pi] [rad]."""
    start, end = finite_numbers("a", a), finite_numbers("b", b)
    try:
        return wrap_angle(end - start)
    except ValueError:
        raise InputError("input.shape", name="b", expected=start.shape, got=end.shape, hint="") from None


def distance(a: ArrayLike, b: ArrayLike) -> Floats:
    """(*batch,) length of the shortest way on the flat torus [rad]."""
    return np.linalg.norm(difference(a, b), axis=-1)


def between(a: ArrayLike, b: ArrayLike, s: float) -> Floats:
    """(*batch, n) the point at share s of the shortest way from a to b, in [0, 2 pi)."""
    return chart(finite_numbers("a", a) + s * difference(a, b))


def embed_in_space(q: ArrayLike, radius: float = 2.0, tube: float = 0.7) -> Floats:
    """(*batch, 3) two angles (a, b) as a point of a torus in space.

    ((R + r cos b) cos a, (R + r cos b) sin a, r sin b)

    Args:
        q: (*batch, 2) angles about the axis and about the tube [rad].
        radius, tube: R and r [m].
    """
    angles = finite_numbers("q", q)
    a, b = angles[..., 0], angles[..., 1]
    out = radius + tube * np.cos(b)
    return np.stack([out * np.cos(a), out * np.sin(a), tube * np.sin(b)], axis=-1)


def angles_of(point: ArrayLike, radius: float = 2.0) -> Floats:
    """(*batch, 2) angles in (-pi, pi] of points (*batch, 3) of a torus with axis z and radius R: the way back."""
    p = real_array("point", point)
    a = np.arctan2(p[..., 1], p[..., 0])
    return np.stack([a, np.arctan2(p[..., 2], np.hypot(p[..., 0], p[..., 1]) - radius)], axis=-1)


def cut_at_seams(path: ArrayLike) -> tuple[Floats, ...]:
    """Pieces (k, n) of a path (m, n) of angles that do not cross the seams of the square [0, 2 pi)."""
    q = chart(path)
    steps = np.abs(np.diff(q, axis=0)) > np.pi
    places = np.flatnonzero(steps.any(axis=-1)) + 1
    return tuple(np.split(q, places))
