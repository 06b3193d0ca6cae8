"""Arms as expressions: their numbers, constant or inputs, their joint axes, motions, configurations and sides.

What the sides mean stands in `mafsil.mechanics.arm_sides`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import mafsil.expression as ex
from mafsil.algebra.spatial import cross
from mafsil.algebra.subproblems import Turn
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.mechanics.arm_pattern import MERGED, ArmPattern, LockedJoint
from mafsil.mechanics.arm_sides import ArmSides, Carried, Elbow, Placing, PlaneElbow, Shoulder, Stroke


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


Motion: TypeAlias = Turn | ex.Expression
"""Of a revolute joint its turn, of a prismatic one its distance [m]."""


@dataclass(frozen=True, eq=False)
class Line:
    """A joint axis: unit direction w through r; the joint is prismatic along it or revolute about it."""

    prismatic: bool
    w: ex.Expression
    r: ex.Expression

    @property
    def opposite(self) -> Line:
        """The same axis in the other sense: what was q is now -q, moved backwards it is q again."""
        return Line(self.prismatic, -self.w, self.r)

    def point(self, x: ex.Expression, motion: Motion) -> ex.Expression:
        """(3,) point x carried by the joint."""
        return self.r + motion.about(self.w, x - self.r) if isinstance(motion, Turn) else x + motion * self.w

    def vector(self, x: ex.Expression, motion: Motion) -> ex.Expression:
        """(3,) vector x carried by the joint."""
        return motion.about(self.w, x) if isinstance(motion, Turn) else x

    def velocity(self, x: ex.Expression) -> ex.Expression:
        """(3,) velocity of a point x at unit rate of the joint."""
        return self.w if self.prismatic else cross(self.w, x - self.r)


@dataclass(frozen=True, eq=False)
class BranchSolution:
    """One branch.

    Attributes:
        motions: of every joint.
        free: one for every joint that may be chosen.
        subproblem_residual: residual of the worst subproblem.
        reason: number of that step, see `mafsil.mechanics.arm_pattern.FailedStep`; zero if none did.
        branch_margins: shoulder, elbow and wrist: numbers whose signs name the branch and which vanish where two
            branches
            merge, in units of the arm; None where there is no such choice.
    """

    motions: tuple[Motion, ...]
    free: tuple[ex.Expression, ...]
    subproblem_residual: ex.Expression
    reason: ex.Expression
    branch_margins: tuple[ex.Expression | None, ex.Expression | None, ex.Expression | None] = (None, None, None)

    def followed_by(
        self,
        motions: Sequence[Motion],
        free: Sequence[ex.Expression],
        subproblem_residual: ex.Expression,
        reason: ex.Expression | float,
    ) -> BranchSolution:
        """The branch with further joints, whose step missed by `subproblem_residual`."""
        worse = subproblem_residual > self.subproblem_residual
        return replace(
            self,
            motions=(*self.motions, *motions),
            free=(*self.free, *free),
            subproblem_residual=ex.fmax(self.subproblem_residual, subproblem_residual),
            reason=ex.if_else(worse, reason, self.reason),
        )

    def reverse(self) -> BranchSolution:
        """The same with its joints in the opposite order."""
        return replace(self, motions=self.motions[::-1], free=self.free[::-1])


def start_line(
    motions: Sequence[Motion],
    free: Sequence[ex.Expression],
    subproblem_residual: ex.Expression,
    reason: ex.Expression | float,
) -> BranchSolution:
    """A configuration of its first joints.

    Args:
        motions: of its joints.
        free: joints that any value fits.
        subproblem_residual: how far the pose is out of reach.
        reason: number of the cause, 0 if none.
    """
    none = BranchSolution((), (), ex.Expression(0), ex.Expression(0))
    return none.followed_by(motions, free, subproblem_residual, reason)


def forward(lines: Sequence[Line], motions: Sequence[Motion], x: ex.Expression) -> ex.Expression:
    """A point carried by all joints.

    Args:
        lines: axes of the joints, from the base.
        motions: of each.
        x: (3,) the point.
    """
    for line, motion in reversed(list(zip(lines, motions, strict=False))):
        x = line.point(x, motion)
    return x


def backward(lines: Sequence[Line], motions: Sequence[Motion], x: ex.Expression) -> ex.Expression:
    """A vector seen before the motions.

    Args:
        lines: axes of the joints, from the base.
        motions: of each.
        x: (3,) the point.
    """
    for line, motion in zip(lines, motions, strict=True):
        x = line.opposite.vector(x, motion)
    return x


def norm(x: ex.Expression) -> ex.Expression:
    """|x|."""
    return ex.sqrt(ex.dot(x, x))


def across(w: ex.Expression, x: ex.Expression) -> ex.Expression:
    """The part of x normal to the unit vector w."""
    return x - ex.dot(w, x) * w


def aside(w: ex.Expression, other: ex.Expression) -> ex.Expression:
    """(3,) a unit vector normal to both."""
    normal = cross(w, other)
    return normal / norm(normal)


def triple(a: ex.Expression, b: ex.Expression, c: ex.Expression) -> ex.Expression:
    """Triple product a . (b x c)."""
    return ex.dot(a, cross(b, c))


def sides_function(sides: ArmSides) -> ex.Function:
    """Of q to the sum of the digits of shoulder, elbow and wrist times 1, 3 and 9: 0 negative, 1 neither, 2 positive.

    Args:
        sides: of the arm.
    """
    q = ex.symbol("q", len(sides.prismatic))
    code = ex.Expression(0)
    for number, weight in zip(_Configuration(sides, q).numbers(), (1, 3, 9), strict=True):
        digit = 1 if number is None else ex.if_else(number > MERGED, 2, ex.if_else(number < -MERGED, 0, 1))
        code = code + weight * digit
    return ex.Function("branch_code", [q], [ex.cse(code)])


class _Configuration:
    """The joints of an arm at q."""

    def __init__(self, sides: ArmSides, q: ex.Expression) -> None:
        self.sides, self.size = sides, sides.size
        rows = zip(sides.prismatic, sides.axes, sides.points, strict=True)
        self.lines = [Line(sliding, ex.Expression(w), ex.Expression(r)) for sliding, w, r in rows]
        self.motions: list[Motion] = [
            q[i] if sliding else Turn(ex.cos(q[i]), ex.sin(q[i])) for i, sliding in enumerate(sides.prismatic)
        ]

    def numbers(self) -> Sequence[ex.Expression | None]:
        """Shoulder, elbow and wrist."""
        one, two, three = self.sides.shoulder, self.sides.elbow, self.sides.wrist
        return (
            None if one is None else self._shoulder(one),
            None if two is None else self._elbow(two),
            None if three is None else triple(*(self._vector(three[k]) for k in (1, 0, 2))),
        )

    def _point(self, point: Carried) -> ex.Expression:
        return forward(self.lines[: point.after], self.motions, ex.Expression(point.at))

    def _vector(self, direction: Carried) -> ex.Expression:
        x = ex.Expression(direction.at)
        for line, motion in reversed(list(zip(self.lines[: direction.after], self.motions, strict=False))):
            x = line.vector(x, motion)
        return x

    def _axis(self, k: int) -> ex.Expression:
        return self._vector(Carried(self.sides.axes[k], k))

    def _shoulder(self, one: Shoulder) -> ex.Expression:
        reach = self._point(one.end) - self._point(one.start)
        return triple(self._vector(one.axis), reach, self._vector(one.up)) / self.size

    def _elbow(self, elbow: Elbow) -> ex.Expression:
        if isinstance(elbow, Stroke):
            along = self._vector(elbow.axis)
            along = along if elbow.across is None else across(self._vector(elbow.across), along)
            return ex.dot(along, self._point(elbow.end) - self._point(elbow.start)) / self.size
        if isinstance(elbow, Placing):
            return self._determinant(elbow)
        S, E, W = (self._point(x) for x in (elbow.shoulder, elbow.elbow, elbow.wrist))
        if isinstance(elbow, PlaneElbow):
            left = ex.dot(E - S, cross(self._vector(elbow.normal), W - S)) / self.size**2
            return left if elbow.reach is None else ex.if_else(self._shoulder(elbow.reach) < 0, -left, left)
        line = W - S
        line = line / ex.fmax(norm(line), LEAST_DIVISOR)
        return ex.dot(E - S, across(line, self._vector(elbow.up))) / self.size

    def _determinant(self, placing: Placing) -> ex.Expression:
        place, revolute = self._point(placing.point), 0
        columns: list[ex.Expression] = []
        for k in placing.joints:
            axis, sliding = self._axis(k), self.sides.prismatic[k]
            revolute += not sliding
            columns.append(axis if sliding else cross(axis, place - self._point(Carried(self.sides.points[k], k))))
        one, two, three = columns
        return triple(one, two, three) / self.size**revolute
