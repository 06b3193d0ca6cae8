"""Dyads that lead a coupler through poses: cranks, blocks on a line of the ground, slots of the coupler about a pin.

Poses of a coupler as conditions on dyads: bilinear forms in a fixed and a moving pivot, homogeneous, of size one.

A dyad is a link from a fixed pivot m to a moving pivot W of the coupler. It is possible if |W_j - m| is one length in
all poses j. With W_j = d_j + E_j w, w being the moving pivot where the first pose puts it, the squares of m and w
cancel in |W_j - m|^2 - |w - m|^2, and what is left is p^T M_j q = 0 with p = (m, 1) and q = (w, 1). As p and q are
homogeneous, points at infinity count: p = (n, 0) lets W run on a straight line across n (a slider on the ground),
q = (n, 0) leads a line of the coupler through a fixed point (a slider on the coupler).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, as_batch, radians
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.messages import say
from mafsil.mobility.spaces.planar_positions import wrap_angle
from mafsil.mobility.tolerances import AT_INFINITY, NO_LENGTH, SAME_POSE, UNDETERMINED

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


DIRECTIONS = 12
"""Directions of lines that are tried for blocks through three poses."""


class DyadKind(Enum):
    """How a dyad holds the coupler to the ground; the value is the key of its sentence."""

    CRANK = "dyad_crank"
    BLOCK = "dyad_block"
    SLOT = "dyad_slot"

    def sentence(self, language: str | None = None) -> str:
        """What the dyad is made of."""
        return say(f"synthesis.{self.value}", language=language)


@dataclass(frozen=True, eq=False)
class Dyad:
    """One dyad, as far as it can be built.

    Attributes:
        kind: crank (two hinges), block (hinge on a line of the ground), slot (line of the coupler about a fixed pin).
        pivot: (2,) the fixed pivot [m]; of a block the direction across its line, of length one.
        point: (2,) the moving pivot on the coupler [m]; of a slot the direction across its line on the coupler.
        places: (N, 2) places of the moving pivot in the poses [m]; of a slot the fixed pin, which stands still.
        length: of the crank [m]; of a block the line's distance from the origin, along `pivot`; of a slot that of its
            line from the coupler's origin, along `point`.
        residual: largest error of the length, or of the line, between the poses [m].
    """

    kind: DyadKind
    pivot: Floats
    point: Floats
    places: Floats
    length: float
    residual: float

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "kind": self.kind.name.lower(), "pivot": self.pivot, "point": self.point, "length": self.length,
            "residual": self.residual,
        }  # fmt: skip


def dyad_of(given: PoseConditions, p: Floats, q: Floats) -> Dyad | None:
    """The dyad of a pair of homogeneous points of size one; None if it has no length or both are at infinity.

    Args:
        given: one list of poses.
        p, q: (3,) fixed and moving pivot.
    """
    lengths = float(np.linalg.norm(p)), float(np.linalg.norm(q))
    if min(lengths) < UNDETERMINED:
        return None
    p, q = p / lengths[0], q / lengths[1]
    far_p, far_q = abs(p[2]) < AT_INFINITY, abs(q[2]) < AT_INFINITY
    if far_p and far_q:
        return None
    if far_q:
        pin = given.in_world(np.complex128(complex(p[0], p[1]) / p[2]))
        across = complex(q[0], q[1]) * np.exp(-1j * given.poses[0, 2])
        across /= abs(across)
        # The pin as the coupler sees it in each pose runs along the line.
        seen = (pin - as_complex(given.poses[:, :2])) * np.exp(-1j * given.poses[:, 2])
        along: Floats = (np.conj(across) * seen).real
        error = float(np.abs(along - along.mean()).max())
        places = np.tile(as_points(pin), (len(seen), 1))
        return Dyad(DyadKind.SLOT, as_points(pin), as_points(np.complex128(across)), places, float(along.mean()), error)
    w = np.complex128(complex(q[0], q[1]) / q[2])
    W = given.in_world(given.places(np.asarray(w)))
    point = as_points(given.on_body(w))
    if far_p:
        n = complex(p[0], p[1]) / abs(complex(p[0], p[1]))
        along = (np.conj(n) * W).real
        error = float(np.abs(along - along.mean()).max())
        return Dyad(DyadKind.BLOCK, as_points(np.complex128(n)), point, as_points(W), float(along.mean()), error)
    m = given.in_world(np.complex128(complex(p[0], p[1]) / p[2]))
    arms: Floats = np.abs(W - m)
    if arms.mean() < NO_LENGTH * float(given.size):
        return None
    error = float(np.abs(arms - arms.mean()).max())
    return Dyad(DyadKind.CRANK, as_points(m), point, as_points(W), float(arms.mean()), error)


def dyads_of(given: PoseConditions, p: Floats, q: Floats) -> list[Dyad]:
    """The dyads of pairs of points (k, 3); those that are NaN or cannot be built are left out.

    Args:
        given: one list of poses.
        p, q: fixed and moving pivots, homogeneous.
    """
    finite = np.isfinite(p).all(axis=-1) & np.isfinite(q).all(axis=-1)
    found = [dyad_of(given, one, other) for one, other in zip(p[finite], q[finite], strict=True)]
    return [one for one in found if one is not None]


def homogeneous(unit: Complexes) -> Floats:
    """(*batch, 3) points of the plane with a third coordinate 1."""
    return np.stack([unit.real, unit.imag, np.ones(unit.shape)], axis=-1)


def fixed_pivots_of(given: PoseConditions, moving: Floats) -> Floats:
    """(k, 3) fixed pivots for points of the coupler (k, 2) [m] in three poses: the middles of their circles."""
    q = homogeneous(given.from_body(as_complex(moving)))
    return np.asarray(np.cross(q @ given.M[0].T, q @ given.M[1].T), dtype=np.float64)


def moving_pivots_of(given: PoseConditions, fixed: Floats) -> Floats:
    """(k, 3) moving pivots, where the first pose puts them, for fixed ones (k, 2) [m] in three poses."""
    p = homogeneous(given.to_unit(as_complex(fixed)))
    return np.asarray(np.cross(p @ given.M[0], p @ given.M[1]), dtype=np.float64)


def three_pose_dyads(given: PoseConditions, fixed: Floats | None, moving: Floats | None, samples: int) -> list[Dyad]:
    """Dyads through three poses, from fixed pivots, from moving ones, or from a grid of moving ones.

    Args:
        given: three poses.
        fixed: (k, 2) fixed pivots [m], or None.
        moving: (k, 2) points of the coupler [m], or None.
        samples: points of the grid.
    """
    if fixed is not None:
        p = homogeneous(given.to_unit(as_complex(fixed)))
        return dyads_of(given, p, moving_pivots_of(given, fixed))
    points = grid(given, samples) if moving is None else moving
    q = homogeneous(given.from_body(as_complex(points)))
    cranks = dyads_of(given, fixed_pivots_of(given, points), q)
    return cranks if moving is not None else cranks + blocks_along(given)


def blocks_along(given: PoseConditions) -> list[Dyad]:
    """Blocks through three poses on lines of several directions: each direction has one point that stays on a line."""
    angle = np.pi * (np.arange(DIRECTIONS) + 0.5) / DIRECTIONS
    p = np.stack([np.cos(angle), np.sin(angle), np.zeros(DIRECTIONS)], axis=1)
    return dyads_of(given, p, np.asarray(np.cross(p @ given.M[0], p @ given.M[1]), dtype=np.float64))


def grid(given: PoseConditions, samples: int) -> Floats:
    """(k, 2) points of the coupler on a square of two sizes about the first pose's middle of the task [m]."""
    side = max(2, int(np.sqrt(samples)))
    line = np.linspace(-2.0, 2.0, side) + 0.03  # off symmetric places, where poles and frame origins tend to lie
    x, y = np.meshgrid(line, line)
    return as_points(given.on_body((x + 1j * y).ravel()))


def cranks_and_blocks(dyads: Sequence[Dyad]) -> tuple[list[Dyad], list[Dyad]]:
    """Those that are cranks, and those that are blocks."""
    cranks = [one for one in dyads if one.kind is DyadKind.CRANK]
    return cranks, [one for one in dyads if one.kind is DyadKind.BLOCK]
