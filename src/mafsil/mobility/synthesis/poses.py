"""Poses of a coupler as conditions on dyads: bilinear forms in a fixed and a moving pivot, homogeneous, of size one.

A dyad is a link from a fixed pivot m to a moving pivot W of the coupler. It is possible if |W_j - m| is one length in
all poses j. With W_j = d_j + E_j w, w being the moving pivot where the first pose puts it, the squares of m and w
cancel in |W_j - m|^2 - |w - m|^2, and what is left is p^T M_j q = 0 with p = (m, 1) and q = (w, 1). As p and q are
homogeneous, points at infinity count: p = (n, 0) lets W run on a straight line across n (a slider on the ground),
q = (n, 0) leads a line of the coupler through a fixed point (a slider on the coupler).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, as_batch, radians
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.mobility.spaces.planar_positions import wrap_angle
from mafsil.mobility.synthesis.tolerances import AT_INFINITY, SAME_POSE

Complexes = NDArray[np.complex128]
"""Points and vectors of the plane as complex numbers x + i y."""


def as_complex(points: Floats) -> Complexes:
    """(*batch, 2) points as (*batch,) complex numbers."""
    return points[..., 0] + 1j * points[..., 1]


def as_points(numbers: Complexes | complex) -> Floats:
    """(*batch,) complex numbers as (*batch, 2) points."""
    z = np.asarray(numbers, dtype=np.complex128)
    return np.stack([z.real, z.imag], axis=-1)


def unit_numbers(angles: Floats) -> Complexes:
    """(*batch,) complex numbers of size one at angles (*batch,) [rad]."""
    return np.asarray(np.exp(1j * angles), dtype=np.complex128)


def in_plane(points: Floats, middle: Complexes, size: Floats, turn: Complexes | complex = 1.0) -> Floats:
    """(*batch, 2) homogeneous points (*batch, 3) of size one in the plane [m]; infinite along their direction if far.

    Args:
        points: (*batch, 3) of length one.
        middle: of what has the size.
        size: length that is one [m].
        turn: unit numbers by which the plane is rotated.
    """
    far = np.abs(points[..., 2]) < AT_INFINITY
    direction = (points[..., 0] + 1j * points[..., 1]) * turn
    near = as_points(middle * turn + size * direction / np.where(far, 1.0, points[..., 2]))
    along = as_points(direction)
    return np.where(far[..., None], np.copysign(np.where(np.abs(along) < AT_INFINITY, 0.0, np.inf), along), near)


def checked_poses(poses: ArrayLike, least: int, most: int) -> Floats:
    """(*batch, N, 3) poses (x, y, phi) as they may be synthesised.

    Args:
        poses: (*batch, N, 3) [m, rad].
        least, most: of N.

    Raises:
        InputError: another shape, numbers that are not finite, too few or too many, two that coincide.
    """
    given = as_batch("poses", poses, (3,), finite=True)
    if given.ndim < 2 or not least <= given.shape[-2] <= most:
        raise InputError("synthesis.pose_count", got=given.shape, least=least, most=most)
    radians("poses", given[..., 2])
    size = np.maximum(spread(as_complex(given[..., :2])), LEAST_DIVISOR)
    for first in range(given.shape[-2]):
        for second in range(first):
            step = given[..., first, :] - given[..., second, :]
            near = np.hypot(step[..., 0], step[..., 1]) <= SAME_POSE * size
            if np.any(near & (np.abs(wrap_angle(step[..., 2])) <= SAME_POSE)):
                raise InputError("synthesis.same_pose", first=second + 1, second=first + 1)
    return given


def spread(z: Complexes) -> Floats:
    """(*batch,) root mean square distance of points (*batch, N) from their middle; 1 where they all coincide."""
    size = np.sqrt(np.mean(np.abs(z - z.mean(axis=-1, keepdims=True)) ** 2, axis=-1))
    return np.where(size > 1e-12 * np.abs(z).max(axis=-1, initial=LEAST_DIVISOR), size, 1.0)


@dataclass(frozen=True, eq=False)
class PoseConditions:
    """Poses (*batch, N) of size one and their bilinear forms.

    Attributes:
        poses: (*batch, N, 3) as given [m, rad].
        middle: (*batch,) the place that becomes the origin [m].
        size: (*batch,) the length that becomes 1 [m].
        d, E: (*batch, N) of W_j = d_j + E_j w, of size one, w in the first pose; complex.
        M: (*batch, N - 1, 3, 3) the forms of the poses after the first.
    """

    poses: Floats
    middle: Complexes
    size: Floats
    d: Complexes
    E: Complexes
    M: Floats

    @staticmethod
    def of(poses: Floats) -> PoseConditions:
        """From checked poses (*batch, N, 3)."""
        z = as_complex(poses[..., :2])
        middle, size = z.mean(axis=-1), spread(z)
        unit = (z - middle[..., None]) / size[..., None]
        E = np.exp(1j * (poses[..., 2] - poses[..., :1, 2]))
        d = unit - E * unit[..., :1]
        return PoseConditions(poses, middle, size, d, E, forms(d[..., 1:], E[..., 1:]))

    def places(self, w: Complexes) -> Complexes:
        """(*batch, N) places of a moving pivot (*batch,), both of size one."""
        return self.d + self.E * w[..., None]

    def in_world(self, unit: Complexes | complex) -> Complexes:
        """Points of size one as points of the world [m]."""
        return self.middle + self.size * unit

    def to_unit(self, world: Complexes) -> Complexes:
        """Points of the world [m] as points of size one."""
        return (world - self.middle) / self.size

    def on_body(self, unit: Complexes | complex) -> Complexes:
        """Moving pivots of size one, where the first pose puts them, in the coordinates of the coupler [m]."""
        origin, angle = as_complex(self.poses[..., 0, :2]), self.poses[..., 0, 2]
        return (self.in_world(unit) - origin) * np.exp(-1j * angle)

    def from_body(self, body: Complexes) -> Complexes:
        """Points of the coupler [m] as points of size one, where the first pose puts them."""
        origin, angle = as_complex(self.poses[..., 0, :2]), self.poses[..., 0, 2]
        return self.to_unit(origin + np.exp(1j * angle) * body)


def forms(d: Complexes, E: Complexes) -> Floats:
    """(*batch, 3, 3) the matrices M of p^T M q = |d + E w - m|^2 - |w - m|^2 for displacements (*batch,)."""
    e, u = E - 1, np.conj(d) * E
    rows = [
        np.stack([-2 * e.real, 2 * e.imag, -2 * d.real], axis=-1),
        np.stack([-2 * e.imag, -2 * e.real, -2 * d.imag], axis=-1),
        np.stack([2 * u.real, -2 * u.imag, np.abs(d) ** 2], axis=-1),
    ]
    return np.stack(rows, axis=-2)


def pole(d: complex, E: complex) -> complex | None:
    """The point that a displacement leaves in place, or None if it is a translation."""
    return None if abs(E - 1) <= SAME_POSE else d / (1 - E)


def common_pole(given: PoseConditions) -> complex | None:
    """The point of size one about which all poses are rotations, or None; for one list of poses."""
    poles = [pole(complex(d), complex(E)) for d, E in zip(given.d[1:], given.E[1:], strict=True)]
    first = poles[0]
    if first is None or any(one is None or abs(one - first) > APART_POLES * (1 + abs(first)) for one in poles):
        return None
    return first


APART_POLES = 1e-8
"""Poles nearer than it are one: displacements typed with nine digits."""


def is_translation(given: PoseConditions) -> bool:
    """Whether no pose of one list turns against the first."""
    return bool((np.abs(given.E - 1) <= SAME_POSE).all())
