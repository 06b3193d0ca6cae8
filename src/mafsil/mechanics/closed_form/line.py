"""Joint axes as expressions, their motions, and configurations: one motion for every joint."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import mafsil.expression as ex
from mafsil.algebra.spatial import cross
from mafsil.algebra.subproblems import Turn

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
