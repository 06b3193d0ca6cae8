"""How three joints bring a point to a place: all motions, by methods that differ in what is eliminated first."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeAlias

import mafsil.expression as ex
from mafsil.algebra import subproblem_quartics as quartics
from mafsil.algebra.subproblems import (
    Root,
    Turn,
    turn_onto,
    turns_about_two_axes,
    turns_to_distance,
    turns_to_height,
)
from mafsil.mechanics.arm_pattern import MISSED, FailedStep, PositioningMethod
from mafsil.mechanics.closed_form.line import BranchSolution, Line, Motion, across, norm, start_line, triple

Moved: TypeAlias = tuple[Motion, ex.Expression, ex.Expression, ex.Expression]
"""A motion, whether it is free, its subproblem residual and the reason of that."""


@dataclass(frozen=True, eq=False)
class Placing:
    """Three joints and a point that they shall carry from start to goal.

    Attributes:
        lines: of the joints.
        start, goal: (3,) [m].
        preferred: turns that free joints take.
        meeting: (3,) where the first two axes meet, for PositioningMethod.MEET [m].
        size: of the arm [m].
        reverse: whether start is the place that was asked for.
    """

    lines: tuple[Line, Line, Line]
    start: ex.Expression
    goal: ex.Expression
    preferred: tuple[Turn, ...]
    meeting: ex.Expression
    size: ex.Expression
    reverse: bool = False

    def backwards(self) -> Placing:
        """The same seen from the placed point."""
        one, two, three = self.lines
        return replace(
            self,
            lines=(three.opposite, two.opposite, one.opposite),
            start=self.goal,
            goal=self.start,
            preferred=self.preferred[::-1],
            reverse=not self.reverse,
        )


def position_solutions(method: PositioningMethod, task: Placing, *, reverse: bool) -> list[BranchSolution]:
    """All motions of three joints that carry the point from start to goal.

    Args:
        method: which elimination.
        task: joints and point.
        reverse: whether the method starts from the placed point.
    """
    walk = _METHODS[method]
    return [one.reverse() for one in walk(task.backwards())] if reverse else walk(task)


def _by_height(task: Placing) -> list[BranchSolution]:
    """The last two joints keep the height along the second's axis, so the first must give it."""
    one, two, three = task.lines
    arms: list[BranchSolution] = []
    for motion, free, short, why in to_height(one, two.w, task.start, task.goal, task.preferred[0], task.size):
        place = one.opposite.point(task.goal, motion)
        shoulder = None if one.prismatic else triple(one.w, two.w, place - one.r) / task.size
        side = ex.Expression(1) if shoulder is None else ex.if_else(shoulder < 0, -1, 1)
        for third, free3, short3, why3 in _to_radius_any(task, place):
            reached = three.point(task.start, third)
            second = turn_onto(two.w, reached - two.r, place - two.r, task.preferred[1], task.size)
            if three.prismatic:
                elbow = ex.dot(across(two.w, three.w), reached - two.r) / task.size
            else:
                elbow = -side * triple(two.w, three.r - two.r, reached - three.r) / task.size**2
            first = start_line((motion, second.turn), (free, second.free), short, why)
            arm = first.followed_by((third,), (free3,), short3, why3)
            arms.append(replace(arm, branch_margins=(shoulder, elbow, None)))
    return arms


def _by_distance(task: Placing) -> list[BranchSolution]:
    """The first two joints keep the distance from where their axes meet, so the third must give it."""
    one, two, three = task.lines
    arms: list[BranchSolution] = []
    offset = task.goal - task.meeting
    square = ex.dot(offset, offset)
    for third, free, short, why in _to_distance(task, square):
        reached = three.point(task.start, third) - task.meeting
        bend = ex.dot(reached, three.velocity(reached + task.meeting))
        pairs = turns_about_two_axes(one.w, two.w, reached, offset, (task.preferred[0], task.preferred[1]), task.size)
        for pair in pairs:
            shoulder = triple(one.w, two.w, pair.second.turn.about(two.w, reached)) / task.size
            if three.prismatic:
                elbow = bend / task.size
            else:
                sense = ex.if_else(ex.dot(two.w, three.w) < -MISSED, -1, 1)
                elbow = ex.if_else(shoulder < 0, -1, 1) * sense * bend / task.size**2
            arm = start_line((pair.first.turn, pair.second.turn), (pair.first.free, pair.second.free), short, why)
            arm = arm.followed_by((third,), (free,), pair.first.residual, FailedStep.DIRECTION.value)
            arms.append(replace(arm, branch_margins=(shoulder, elbow, None)))
    return arms


def _by_three_prismatic(task: Placing) -> list[BranchSolution]:
    """Three prismatic joints: linear equations."""
    d = ex.solve(ex.horzcat(*(line.w for line in task.lines)), task.goal - task.start)
    return [start_line((d[0], d[1], d[2]), (ex.Expression(0),) * 3, ex.Expression(0), 0.0)]


def _by_perpendicular_prismatic(task: Placing) -> list[BranchSolution]:
    """The second joint is prismatic across the first's axis, so the third must give the height along that."""
    one, two, three = task.lines
    offset = task.goal - one.r
    arms: list[BranchSolution] = []
    back = three.opposite
    for motion, free, short, why in to_height(back, one.w, task.goal, task.start, task.preferred[2], task.size):
        reached = three.point(task.start, motion) - one.r
        shoulder = None if three.prismatic else ex.dot(one.w, three.velocity(reached + one.r)) / task.size
        for d, short2 in _strokes_to_distance(two.w, reached, ex.dot(offset, offset)):
            first = turn_onto(one.w, reached + d * two.w, offset, task.preferred[0], task.size)
            arm = start_line((first.turn, d, motion), (first.free, ex.Expression(0), free), short, why)
            elbow = ex.dot(two.w, reached + d * two.w) / task.size
            arm = arm.followed_by((), (), short2, FailedStep.TOO_NEAR.value)
            arms.append(replace(arm, branch_margins=(shoulder, elbow, None)))
    return arms


def _by_quartic(task: Placing) -> list[BranchSolution]:
    """Nothing special: one equation of fourth degree for the third joint."""
    one, two, three = task.lines
    preferred = (task.preferred[0], task.preferred[1], task.preferred[2])
    hub = two.r if not two.prismatic else (one.r if not one.prismatic else ex.zeros(3))
    if three.prismatic:
        course = quartics.prismatic_point(three.w, task.start - hub)
    else:
        course = quartics.revolute_point(three.w, task.start - three.r, three.r - hub)
    if one.prismatic and two.prismatic:
        found = quartics.two_prismatics(one.w, two.w, task.goal - hub, course, preferred)
    elif one.prismatic:
        found = quartics.prismatic_then_revolute(one.w, two.w, task.goal - hub, course, preferred, task.size)
    elif two.prismatic:
        found = quartics.revolute_then_prismatic(-one.w, two.w, task.goal - one.r, course, preferred, task.size)
    else:
        # one.r - two.r + Rot(-w1) (goal - one.r) = Rot(w2) v
        found = quartics.two_revolutes(-one.w, two.w, one.r - two.r, task.goal - one.r, course, preferred, task.size)
    arms: list[BranchSolution] = []
    revolute = sum(not line.prismatic for line in task.lines)
    for each in found:
        first, second = _split(each.first), _split(each.second)
        motions, free = (first[0], second[0], each.third), (first[1], second[1], each.free)
        reached = three.point(task.start, motions[2])
        middle = two.point(reached, motions[1])
        columns = (one.velocity(middle), two.velocity(middle), two.vector(three.velocity(reached), motions[1]))
        determinant = triple(*columns) / task.size**revolute
        residual = norm(one.point(middle, motions[0]) - task.goal)
        short = ex.if_else(residual > MISSED * task.size, residual, 0)
        arm = start_line(motions, free, short, FailedStep.TOO_FAR.value)
        arms.append(replace(arm, branch_margins=(None, determinant, None)))
    return arms


def _split(found: Root | ex.Expression) -> tuple[Motion, ex.Expression]:
    return (found.turn, found.free) if isinstance(found, Root) else (found, ex.Expression(0))


_METHODS: dict[PositioningMethod, Callable[[Placing], list[BranchSolution]]] = {
    PositioningMethod.PARALLEL: _by_height,
    PositioningMethod.MEET: _by_distance,
    PositioningMethod.LINEAR: _by_three_prismatic,
    PositioningMethod.ACROSS: _by_perpendicular_prismatic,
    PositioningMethod.QUARTIC: _by_quartic,
}


def to_height(
    line: Line, h: ex.Expression, start: ex.Expression, goal: ex.Expression, preferred: Turn, size: ex.Expression
) -> list[Moved]:
    """Motions of a joint whose inverse brings `goal` to the height of `start` along h.

    Args:
        line: axis about which the point turns.
        preferred: angle where every one fits.
        size: length by which the arm is measured.
    """
    if line.prismatic:
        return [(ex.dot(h, goal - start) / ex.dot(h, line.w), ex.Expression(0), ex.Expression(0), ex.Expression(0))]
    roots = turns_to_height(-line.w, h, goal - line.r, ex.dot(h, start - line.r), preferred, size)
    return [(root.turn, root.free, root.residual, ex.Expression(FailedStep.SHOULDER.value)) for root in roots]


def to_radius(
    line: Line, start: ex.Expression, axis: Line, goal: ex.Expression, preferred: Turn, size: ex.Expression
) -> tuple[Root, Root]:
    """Turns that bring `start` as far from a parallel axis as `goal` is.

    Args:
        line: axis about which the point turns.
        preferred: angle where every one fits.
        size: length by which the arm is measured.
    """
    radius = across(axis.w, goal - axis.r)
    return turns_to_distance(line.w, start - line.r, axis.r - line.r, ex.dot(radius, radius), preferred, size)


def far_or_near(root: Root, *, reverse: bool = False) -> ex.Expression:
    """The reason of a subproblem residual in distance.

    Args:
        root: of the distance.
        reverse: whether the place that is too far or too near is that of the point that is turned, not the distance.
    """
    too_near = root.inside < 2 if reverse else root.inside > 0
    return ex.if_else(too_near, FailedStep.TOO_NEAR.value, FailedStep.TOO_FAR.value)


def _to_radius_any(task: Placing, place: ex.Expression) -> list[Moved]:
    """Motions of a parallel revolute or a perpendicular prismatic joint that bring the point as far from axis 2."""
    _, axis, line = task.lines
    if not line.prismatic:
        roots = to_radius(line, task.start, axis, place, task.preferred[2], task.size)
        return [(root.turn, root.free, root.residual, far_or_near(root, reverse=task.reverse)) for root in roots]
    radius = across(axis.w, place - axis.r)
    found = _strokes_to_distance(across(axis.w, line.w), across(axis.w, task.start - axis.r), ex.dot(radius, radius))
    return [(d, ex.Expression(0), short, ex.Expression(FailedStep.TOO_NEAR.value)) for d, short in found]


def _to_distance(task: Placing, square: ex.Expression) -> list[Moved]:
    """Motions of the third joint that bring the point to a distance from where the first two axes meet."""
    line, offset = task.lines[2], task.start - task.meeting
    if line.prismatic:
        return [
            (d, ex.Expression(0), short, ex.Expression(FailedStep.TOO_NEAR.value))
            for d, short in _strokes_to_distance(line.w, offset, square)
        ]
    height = ex.dot(line.w, offset)
    centre, rest = task.meeting - line.r, square - height**2
    roots = turns_to_distance(line.w, task.start - line.r, centre, rest, task.preferred[2], task.size)
    return [(root.turn, root.free, root.residual, far_or_near(root, reverse=task.reverse)) for root in roots]


def _strokes_to_distance(
    w: ex.Expression, offset: ex.Expression, square: ex.Expression
) -> list[tuple[ex.Expression, ex.Expression]]:
    """Both d with |offset + d w|^2 = square, the farther along w first, and their residuals."""
    middle = ex.dot(w, offset)
    rest = offset - middle * w
    half = ex.sqrt(ex.fmax(square - ex.dot(rest, rest), 0))
    short = ex.fmax(norm(rest) - ex.sqrt(ex.fmax(square, 0)), 0)
    return [(half - middle, short), (-half - middle, short)]
