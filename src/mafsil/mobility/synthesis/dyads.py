"""Dyads that lead a coupler through poses: cranks, blocks on a line of the ground, slots of the coupler about a pin."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np

from mafsil.arrays import Floats
from mafsil.messages import say
from mafsil.mobility.synthesis.poses import Complexes, PoseConditions, as_complex, as_points
from mafsil.mobility.synthesis.tolerances import AT_INFINITY, NO_LENGTH, UNDETERMINED

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
