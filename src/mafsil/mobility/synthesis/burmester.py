"""Burmester's curves of four poses: all fixed pivots (centre points) and moving pivots (circle points) of dyads.

Four poses give three bilinear equations p^T M_j q = 0. A fixed pivot p has a moving one if the three rows p^T M_j
depend on each other: det [M_2^T p, M_3^T p, M_4^T p] = 0, a circular cubic. The pole of the first two poses lies on it
(there the first row vanishes), so that a line through the pole meets the curve in two more points, by a quadratic.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, whole
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.mobility.synthesis.poses import PoseConditions, checked_poses, in_plane


@dataclass(frozen=True, eq=False)
class BurmesterCurves:
    """Points of both curves that belong together, two or none for each line through the pole.

    Attributes:
        centre_points: (k, 2) fixed pivots, in the order of the lines; infinite along their direction where far off [m].
        circle_points: (k, 2) moving pivots in the first pose, in the world, likewise [m].
        p, q: (k, 3) the same homogeneous, of size one.
    """

    centre_points: Floats
    circle_points: Floats
    p: Floats
    q: Floats


def burmester_curves(poses: ArrayLike, samples: int = 181) -> BurmesterCurves:
    """Centre-point and circle-point curve of four poses.

    Args:
        poses: (4, 3) poses (x, y, phi) of the coupler [m, rad].
        samples: lines through the pole of the first two poses.

    Raises:
        InputError: not four poses, or two of them coincide.

    Reference: L. Burmester, Lehrbuch der Kinematik, 1888; as a cubic: J. M. McCarthy, Geometric Design of Linkages.
    """
    given = PoseConditions.of(checked_poses(poses, 4, 4))
    return curves_of(given, whole("samples", samples, 3, 100_000))


def curves_of(given: PoseConditions, samples: int) -> BurmesterCurves:
    """The curves of four checked poses.

    Args:
        given: four poses.
        samples: lines through the pole.
    """
    M = given.M
    start = np.linalg.svd(M[0].T)[2][-1]  # the pole, homogeneous: M[0]^T start = 0
    angle = np.linspace(0.0, np.pi, samples, endpoint=False) + 0.5 * np.pi / samples
    first, second = np.linalg.svd(start[None])[2][1:]
    Q = np.cos(angle)[:, None] * first + np.sin(angle)[:, None] * second
    last, plus, minus = (_cubic(M, shift * start + Q) for shift in (0.0, 1.0, -1.0))
    square, linear = (plus + minus) / 2 - last, (plus - minus) / 2
    inside = linear**2 - 4 * square * last
    root = np.sqrt(np.maximum(inside, 0.0))
    stable = -(linear + np.copysign(root, linear)) / 2
    above, below = np.stack([stable, last], axis=-1), np.stack([square, stable], axis=-1)
    real = (inside >= 0.0)[:, None] & (np.maximum(np.abs(above), np.abs(below)) > 0.0)
    # Without a division: a root at infinity is the pole itself.
    p = (above[..., None] * start + below[..., None] * Q[:, None])[real]
    p /= np.linalg.norm(p, axis=-1, keepdims=True)
    q = np.linalg.svd(np.einsum("ai,jik->ajk", p, M))[2][:, -1, :]
    centre, circle = (in_plane(points, given.middle, given.size) for points in (p, q))
    return BurmesterCurves(centre, circle, p, q)


def block_of(given: PoseConditions) -> tuple[Floats, Floats]:
    """(1, 3), (1, 3) the pair whose fixed pivot is at infinity: the one coupler point with four places on a line.

    At infinity the cubic is (x^2 + y^2) (a x + b y), with a and b its values at (1, 0, 0) and (0, 1, 0).
    """
    a, b = _cubic(given.M, np.eye(3)[:2]).tolist()
    p = np.array([-b, a, 0.0]) / max(float(np.hypot(a, b)), LEAST_DIVISOR)
    rows = np.einsum("i,jik->jk", p, given.M)
    return p[None], np.linalg.svd(rows)[2][-1:]


def _cubic(M: Floats, p: Floats) -> Floats:
    """(k,) the determinant of the three rows p^T M_j at points (k, 3)."""
    return np.linalg.det(np.einsum("ai,jik->ajk", p, M))
