"""The numbers of an arm as expressions: constants of one arm, or inputs for all arms of the same structure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import mafsil.expression as ex
from mafsil.mechanics.arm_pattern import ArmPattern, LockedJoint


@dataclass(frozen=True, eq=False)
class Geometry:
    """What the closed form of an arm is made of, besides its structure.

    Attributes:
        axes, points: (m) directions and points of the joints at q = 0.
        home: (4, 4) pose of the tip at q = 0.
        centre, meeting: (3,) see `ArmPattern`.
        size: length that tells large from small [m].
        locked: (k) direction and point of the joints whose values are given.
    """

    axes: Sequence[ex.Expression]
    points: Sequence[ex.Expression]
    home: ex.Expression
    centre: ex.Expression
    meeting: ex.Expression
    size: ex.Expression
    locked: Sequence[tuple[LockedJoint, ex.Expression, ex.Expression]]


def constants(pattern: ArmPattern) -> Geometry:
    """The numbers of one arm, folded into the code."""
    return Geometry(
        [ex.Expression(w) for w in pattern.axes],
        [ex.Expression(r) for r in pattern.points],
        ex.Expression(pattern.home),
        ex.Expression(pattern.centre),
        ex.Expression(pattern.meeting),
        ex.Expression(pattern.size),
        [(locked, ex.Expression(locked.axis), ex.Expression(locked.point)) for locked in pattern.locked],
    )


def inputs(pattern: ArmPattern, numbers: ex.Expression) -> Geometry:
    """The numbers as slices of a vector in the order of `ArmPattern.numbers`."""
    m = len(pattern.prismatic)
    axes = [numbers[3 * i : 3 * i + 3] for i in range(m)]
    points = [numbers[3 * (m + i) : 3 * (m + i) + 3] for i in range(m)]
    rest = numbers[6 * m :]
    home = ex.reshape(rest[:16], 4, 4).T
    return Geometry(axes, points, home, rest[16:19], rest[19:22], rest[22], [])
