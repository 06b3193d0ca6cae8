"""Dyads of five poses that have only two angles: the general elimination is singular there, a construction is not.

Three poses at least have one angle, so that every point of the coupler has its three places on equal circles: the fixed
pivot is the moving one moved by the vector to their middle. Two poses of another angle then say two circles of equal
radius for the moving pivot, which meet in two points. Three places on one line leave none, or infinitely many.
"""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Booleans, Floats
from mafsil.mobility.spaces.planar_positions import circle_crossings, circle_gap
from mafsil.mobility.synthesis.poses import PoseConditions, as_complex, as_points
from mafsil.mobility.synthesis.tolerances import AT_INFINITY, EXACT, SAME_POSE


def larger_group(given: PoseConditions) -> Booleans | None:
    """(5,) which poses have the angle of most; None if there are three angles or more."""
    same = np.abs(given.E[:, None] - given.E[None]) <= SAME_POSE
    group = same[int(same.sum(axis=1).argmax())]
    others = np.flatnonzero(~group)
    if len(others) and not same[others[0], others].all():
        return None
    return np.asarray(group, dtype=np.bool_)


def two_angle_pairs(given: PoseConditions, group: Booleans) -> tuple[Floats, Floats, bool]:
    """Homogeneous fixed pivots (k, 3), moving pivots in the first pose (k, 3), and whether there are infinitely many.

    Args:
        given: one list of five poses.
        group: the poses that have the angle of most: three or four.
    """
    none = np.zeros((0, 3))
    inside, outside = np.flatnonzero(group), np.flatnonzero(~group)
    start = int(inside[0])
    E = given.E / given.E[start]
    d = given.d - E * given.d[start]  # W_j = d_j + E_j w with w in the pose `start`
    first, second = complex(d[inside[1]]), complex(d[inside[2]])
    area = (np.conj(first) * second).imag
    if abs(area) <= AT_INFINITY * abs(first) * abs(second):
        # A point may run on a line only; both poses of the other angle then ask for parallel lines in the coupler.
        step = complex(d[outside[0]] - d[outside[-1]])
        return none, none, abs((np.conj(first) * step).imag) <= AT_INFINITY * abs(first) * (1 + abs(step))
    middle = 1j * (first * abs(second) ** 2 - second * abs(first) ** 2) / (2 * area)
    if len(outside) < 2:
        fits = abs(abs(complex(d[inside[3]]) - middle) - abs(middle)) <= EXACT * abs(middle)
        return none, none, bool(fits)
    e = complex(E[outside[0]]) - 1
    centres = as_points((middle - d[outside]) / e)
    radius = abs(middle) / abs(e)
    meet = circle_gap(centres[0], radius, centres[1], radius) == 0.0
    w = as_complex(circle_crossings(centres[0], radius, centres[1], radius)[: 2 if meet else 0])
    q = given.d[0] + given.E[0] * (w - given.d[start]) / given.E[start]
    return _homogeneous(w + middle), _homogeneous(q), False


def _homogeneous(z: np.ndarray[tuple[int, ...], np.dtype[np.complex128]]) -> Floats:
    return np.stack([z.real, z.imag, np.ones(len(z))], axis=1)
