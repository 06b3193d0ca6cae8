"""The numbers of an arm as expressions: constants of one arm, or inputs for all arms of the same structure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca

from mafsil.mechanics.arm_pattern import ArmPattern, HeldJoint


@dataclass(frozen=True, eq=False)
class Geometry:
    """What the closed form of an arm is made of, besides its structure.

    Attributes:
        axes, points: (m) directions and points of the joints at q = 0.
        home: (4, 4) pose of the tip at q = 0.
        centre, meeting: (3,) see `ArmPattern`.
        size: length that tells large from small [m].
        held: (k) direction and point of the joints whose values are given.
    """

    axes: Sequence[ca.SX]
    points: Sequence[ca.SX]
    home: ca.SX
    centre: ca.SX
    meeting: ca.SX
    size: ca.SX
    held: Sequence[tuple[HeldJoint, ca.SX, ca.SX]]


def constants(pattern: ArmPattern) -> Geometry:
    """The numbers of one arm, folded into the code."""
    return Geometry(
        [ca.SX(w) for w in pattern.axes],
        [ca.SX(r) for r in pattern.points],
        ca.SX(pattern.home),
        ca.SX(pattern.centre),
        ca.SX(pattern.meeting),
        ca.SX(pattern.size),
        [(held, ca.SX(held.axis), ca.SX(held.point)) for held in pattern.held],
    )


def inputs(pattern: ArmPattern, numbers: ca.SX) -> Geometry:
    """The numbers as slices of a vector in the order of `ArmPattern.numbers`."""
    m = len(pattern.slides)
    axes = [numbers[3 * i : 3 * i + 3] for i in range(m)]
    points = [numbers[3 * (m + i) : 3 * (m + i) + 3] for i in range(m)]
    rest = numbers[6 * m :]
    home = ca.reshape(rest[:16], 4, 4).T
    return Geometry(axes, points, home, rest[16:19], rest[19:22], rest[22], [])
