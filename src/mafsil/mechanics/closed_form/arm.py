"""An arm's closed form: its family's configurations for the displacement that the joints shall make."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeAlias

import mafsil.expression as ex
from mafsil.algebra.subproblem_quartics import linked_circles
from mafsil.algebra.subproblems import (
    Pair,
    Root,
    Turn,
    turn_between,
    turn_onto,
    turns_about_two_axes,
    turns_to_distance,
    turns_to_height,
    zero_turn,
)
from mafsil.mechanics.arm_pattern import MISSED, ArmPattern, FailedStep, Family, LockedJoint
from mafsil.mechanics.closed_form.line import (
    BranchSolution,
    Geometry,
    Line,
    Motion,
    across,
    aside,
    backward,
    forward,
    norm,
    start_line,
    triple,
)
from mafsil.mechanics.closed_form.positioning import Placing, far_or_near, position_solutions, to_height, to_radius


class Arm:
    """A pattern as expressions: lines and places at q = 0, and the displacement R, p that they shall make.

    `patient` asks for members of families whose preferred member is out of reach, at the price of longer code.
    """

    def __init__(
        self, pattern: ArmPattern, geometry: Geometry, R: ex.Expression, p: ex.Expression, *, patient: bool
    ) -> None:
        self.pattern, self.size, self.R, self.p = pattern, geometry.size, R, p
        self.lines = [
            Line(prismatic, w, r)
            for prismatic, w, r in zip(pattern.prismatic, geometry.axes, geometry.points, strict=True)
        ]
        if pattern.shifted:
            # e_1 .. e_m = P  is  (P e_m P^-1) e_1 .. e_m-1 = P
            last = self.lines[0]
            self.lines[0] = Line(last.prismatic, R @ last.w, R @ last.r + p)
        self.centre, self.meeting = geometry.centre, geometry.meeting
        self.patient = patient

    def lock(self, locked: LockedJoint, axis: ex.Expression, point: ex.Expression, motion: Motion) -> None:
        """Carry all that comes after a locked joint along with it, and take its motion off the displacement.

        e_1 .. E e_k .. e_m = P  becomes  e_1 .. (E e_k E^-1) .. (E e_m E^-1) = P E^-1
        """
        line = Line(locked.prismatic, axis, point)
        for i in range(locked.at, len(self.lines)):
            old = self.lines[i]
            self.lines[i] = Line(old.prismatic, line.vector(old.w, motion), line.point(old.r, motion))
        family = self.pattern.family
        last = 2 if family is Family.PLANAR else 5
        if locked.at <= last and not (family is Family.POINT and self.pattern.reversed):
            self.centre = line.point(self.centre, motion)
        if locked.at <= 1:
            self.meeting = line.point(self.meeting, motion)
        columns = [line.opposite.vector(ex.Expression(column), motion) for column in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]
        start = line.opposite.point(ex.zeros(3), motion) if isinstance(motion, Turn) else -motion * line.w
        self.p = self.R @ start + self.p
        self.R = self.R @ ex.horzcat(*columns)


Solved: TypeAlias = tuple[list[BranchSolution], list[ex.Expression]]
"""The branches of a family, and the error of the forward kinematics of each."""


def branch_solutions(arm: Arm, preferred: list[Turn]) -> Solved:
    """All branches of an arm.

    Args:
        arm: with the displacement to be made.
        preferred: turns that free joints take.
    """
    return _FAMILIES[arm.pattern.family](arm, preferred)


def _spherical_wrist(arm: Arm, preferred: list[Turn]) -> Solved:
    """Three joints place the wrist's centre, the wrist turns the tip."""
    lines, R, centre = arm.lines, arm.R, arm.centre
    target = R @ centre + arm.p
    w4, w5, w6 = (line.w for line in lines[3:])
    side = aside(w6, w5)
    found: list[BranchSolution] = []
    residuals: list[ex.Expression] = []
    for one in _arms(arm, centre, target, preferred[:3]):
        tip, beside = (backward(lines[:3], one.motions, R @ x) for x in (w6, side))
        for pair in turns_about_two_axes(w4, w5, w6, tip, (preferred[3], preferred[4])):
            turns = (pair.first.turn, pair.second.turn)
            turned = turns[1].back().about(w5, turns[0].back().about(w4, beside))
            last = turn_between(w6, side, turned)
            free = (pair.first.free, pair.second.free, ex.Expression(0))
            solution = one.followed_by((*turns, last), free, pair.first.residual, FailedStep.ORIENTATION.value)
            wrist = triple(w5, w4, turns[1].about(w5, w6))
            found.append(replace(solution, branch_margins=(*solution.branch_margins[:2], wrist)))
            residuals.append(_residual(arm, solution, (centre, w6, side), (target, R @ w6, R @ side), at=3))
    return found, residuals


def _three_parallel(arm: Arm, preferred: list[Turn]) -> Solved:
    """The height along the parallel axes gives the first joint, directions the wrist, a triangle the rest."""
    one, two, _, four, five, six = arm.lines
    h, w5, w6 = two.w, five.w, six.w
    target = arm.R @ arm.centre + arm.p
    found: list[BranchSolution] = []
    residuals: list[ex.Expression] = []
    for motion, free, short, why in to_height(one, h, arm.centre, target, preferred[0], arm.size):
        tip = one.opposite.vector(arm.R @ w6, motion)
        hub = one.opposite.point(target, motion)
        shoulder = None if one.prismatic else triple(one.w, h, hub - one.r) / arm.size
        begun = start_line((motion,), (free,), short, why)
        for pair in turns_about_two_axes(h, w5, w6, tip, (preferred[1], preferred[4])):
            if arm.patient:
                total = _within_reach(arm, pair.first.turn, pair.first.free, hub, arm.centre)
                pair = pair._replace(first=pair.first._replace(turn=total))
            wrist = triple(w5, four.w, pair.second.turn.about(w5, w6))
            _complete(arm, preferred, begun, pair, (shoulder, wrist), (found, residuals))
    return found, residuals


def _link(arm: Arm, preferred: list[Turn]) -> Solved:
    """Heights along the parallel axes and along axis 6 tie joints 1 and 5, directions and a triangle give the rest.

    w6 . Rot(w5, -q5) h = (R w6) . Rot(w1, q1) h,    h . E1^-1 (P c) = h . E5 c,  c a point of axis 6
    """
    one, two, _, _, five, six = arm.lines
    h, w5, w6 = two.w, five.w, six.w
    target = arm.R @ arm.centre + arm.p
    seen = arm.R @ w6
    found: list[BranchSolution] = []
    residuals: list[ex.Expression] = []
    for first, fifth, branch_margin, short, why in _pairs(arm, seen, target, (preferred[0], preferred[4])):
        motion = first.turn if isinstance(first, Root) else first
        free = first.free if isinstance(first, Root) else ex.Expression(0)
        begun = start_line((motion,), (free,), short, why)
        # Joints 1 and 5 are known to the square root of the rounding where axis 6 comes to be parallel to the three.
        total = turn_onto(h, fifth.turn.about(w5, w6), one.opposite.vector(seen, motion), preferred[1], 30.0)
        if arm.patient:
            hub = one.opposite.point(target, motion)
            turn = _within_reach(arm, total.turn, total.free, hub, five.point(arm.centre, fifth.turn))
            total = total._replace(turn=turn)
        pair = Pair(total, fifth)
        _complete(arm, preferred, begun, pair, (None, branch_margin), (found, residuals))
    return found, residuals


def _pairs(
    arm: Arm, seen: ex.Expression, target: ex.Expression, preferred: tuple[Turn, Turn]
) -> list[tuple[Root | ex.Expression, Root, ex.Expression, ex.Expression, ex.Expression | float]]:
    """Joints 1 and 5, a branch margin that vanishes where two solutions merge, subproblem residual and reason."""
    one, two, _, _, five, six = arm.lines
    h, w1, w5, w6, size = two.w, one.w, five.w, six.w, arm.size
    k = arm.centre - five.r
    if one.prismatic:
        pairs: list[tuple[Root | ex.Expression, Root, ex.Expression, ex.Expression, ex.Expression | float]] = []
        for root in turns_to_height(-w5, w6, h, ex.dot(seen, h), preferred[1]):
            d = ex.dot(h, target - five.r - root.turn.about(w5, k)) / ex.dot(h, w1)
            branch_margin = triple(w6, w5, root.turn.back().about(w5, h))
            pairs.append((d, root, branch_margin, root.residual, FailedStep.ORIENTATION.value))
        return pairs
    g = target - one.r
    A = ex.vertcat(_turned_form(w1, seen, h), _turned_form(-w1, h, g) / size)
    B = ex.vertcat(_turned_form(-w5, w6, h), _turned_form(w5, h, k) / size)
    constant = ex.vertcat(
        ex.dot(w5, h) * ex.dot(w5, w6) - ex.dot(w1, h) * ex.dot(seen, w1),
        (ex.dot(h, five.r - one.r) + ex.dot(h, w5) * ex.dot(w5, k) - ex.dot(h, w1) * ex.dot(w1, g)) / size,
    )
    linked: list[tuple[Root | ex.Expression, Root, ex.Expression, ex.Expression, ex.Expression | float]] = []
    for first, fifth in linked_circles(A, -B, constant, preferred):
        x1, x5 = (ex.vertcat(root.turn.c, root.turn.s) for root in (first, fifth))
        t1, t5 = A @ ex.vertcat(-x1[1], x1[0]), B @ ex.vertcat(-x5[1], x5[0])
        residual = ex.fmax(*ex.vertsplit(ex.fabs(A @ x1 - B @ x5 - constant)))
        short = ex.if_else(residual > MISSED, residual, 0)
        linked.append((first, fifth, t1[0] * t5[1] - t1[1] * t5[0], short, FailedStep.ORIENTATION.value))
    return linked


def _turned_form(w: ex.Expression, a: ex.Expression, x: ex.Expression) -> ex.Expression:
    """(1, 2) coefficients of cos q and sin q in a . Rot(w, q) x."""
    return ex.horzcat(ex.dot(a, x) - ex.dot(w, a) * ex.dot(w, x), triple(a, w, x))


def _complete(
    arm: Arm,
    preferred: list[Turn],
    begun: BranchSolution,
    pair: Pair,
    branch_margins: tuple[ex.Expression | None, ex.Expression],
    out: tuple[list[BranchSolution], list[ex.Expression]],
) -> None:
    """Joints 6, 3, 2 and 4 of an arm with three parallel axes: the sum of the turns about them, and joint 5, are known.

    Adds to `out` the branches and their residuals.
    """
    one, two, three, four, five, six = arm.lines
    h, w5, w6, R = two.w, five.w, six.w, arm.R
    side = aside(w6, w5)
    s3, s4 = (_same_sense(h, line.w) for line in (three, four))
    total, fifth = pair.first.turn, pair.second.turn
    motion = begun.motions[0]
    beside = one.opposite.vector(R @ side, motion)
    last = turn_between(w6, side, fifth.back().about(w5, total.back().about(h, beside)))
    inner = six.opposite.point(five.opposite.point(four.r, fifth), last)
    place = one.opposite.point(R @ inner + arm.p, motion)
    shoulder, wrist = branch_margins
    sense = ex.Expression(1) if shoulder is None else ex.if_else(shoulder < 0, -1, 1)
    for bend in to_radius(three, four.r, two, place, preferred[2], arm.size):
        reached = three.point(four.r, bend.turn)
        second = turn_onto(h, reached - two.r, place - two.r, preferred[1], arm.size)
        rest = total.then(second.turn.back()).then(_sign(bend.turn, -s3))
        solution = begun.followed_by(
            (second.turn, bend.turn), (second.free, bend.free), bend.residual, far_or_near(bend)
        )
        solution = solution.followed_by(
            (_sign(rest, s4), fifth, last),
            (ex.Expression(0), pair.second.free, pair.first.free),
            pair.first.residual,
            FailedStep.ORIENTATION.value,
        )
        elbow = -sense * triple(h, three.r - two.r, reached - three.r) / arm.size**2
        out[0].append(replace(solution, branch_margins=(shoulder, elbow, wrist)))
        starts, goals = (arm.centre, w6, side), (R @ arm.centre + arm.p, R @ w6, R @ side)
        # The chosen point is on axis 6, and where 5 and 6 meet on both.
        at = 5 if arm.pattern.family is Family.LINKED else 4
        out[1].append(_residual(arm, solution, starts, goals, at=at))


def _within_reach(arm: Arm, total: Turn, free: ex.Expression, hub: ex.Expression, centre: ex.Expression) -> Turn:
    """Where the sixth axis is parallel to the three and the turn of joint 4's link is free: one that can be reached.

    The link turns about `hub`, the placed point of axis 6, `centre` before; if joint 4 comes too far from axis 2 or too
    near, back within.
    """
    two, three, four = arm.lines[1:4]
    h = two.w
    hinge = hub + total.about(h, across(h, four.r - centre))
    distance = norm(across(h, hinge - two.r))
    upper, lower = (norm(across(h, x)) for x in (three.r - two.r, four.r - three.r))
    least, most = ex.fabs(upper - lower), upper + lower
    # Not to the margin itself, where the elbow is straight and the link's turn no longer a coordinate of the family.
    inset = 0.1 * (most - least)
    goal_distance = ex.fmin(ex.fmax(distance, least + inset), most - inset)
    root = turns_to_distance(h, hinge - hub, two.r - hub, goal_distance**2, zero_turn(), arm.size)[0]
    moved = ex.logic_and(free, ex.logic_or(distance < least, distance > most))
    turned = total.then(root.turn)
    return Turn(ex.if_else(moved, turned.c, total.c), ex.if_else(moved, turned.s, total.s))


def _planar(arm: Arm, preferred: list[Turn]) -> Solved:
    """Joints 1 to 3 turn about parallel axes, the fourth is prismatic along them."""
    lines, R, p = arm.lines, arm.R, arm.p
    one, two, three, four = lines
    h, point = one.w, three.r
    s2, s3 = (_same_sense(h, line.w) for line in (two, three))
    along = aside(h, _far_from(h))
    target = R @ point + p
    distance = ex.dot(h, target - point) / ex.dot(h, four.w)
    total = turn_onto(h, along, R @ along, preferred[2])
    found: list[BranchSolution] = []
    residuals: list[ex.Expression] = []
    for bend in to_radius(two, point, one, target, preferred[1], arm.size):
        # With a third joint that does not exist the orientation chooses the first where its place leaves it free.
        preferred_first = total.turn.then(_sign(bend.turn, -s2)) if arm.pattern.joints[2] == -1 else preferred[0]
        reached = two.point(point, bend.turn)
        first = turn_onto(h, reached - one.r, target - one.r, preferred_first, arm.size)
        rest = _sign(total.turn.then(first.turn.back()).then(_sign(bend.turn, -s2)), s3)
        solution = start_line(
            (first.turn, bend.turn, rest, distance),
            (first.free, bend.free, ex.Expression(0), ex.Expression(0)),
            bend.residual,
            far_or_near(bend),
        )
        elbow = -triple(h, two.r - one.r, reached - two.r) / arm.size**2
        found.append(replace(solution, branch_margins=(None, elbow, None)))
        residuals.append(_residual(arm, solution, (point, h, along), (target, R @ h, R @ along), at=4))
    return found, residuals


def _point(arm: Arm, preferred: list[Turn]) -> Solved:
    """Only the place of the tip counts."""
    target = arm.R @ arm.centre + arm.p
    found = _arms(arm, arm.centre, target, preferred)
    return found, [norm(_carried(arm, arm.lines, one, arm.centre) - target) for one in found]


_FAMILIES = {
    Family.SPHERICAL_WRIST: _spherical_wrist,
    Family.THREE_PARALLEL: _three_parallel,
    Family.LINKED: _link,
    Family.PLANAR: _planar,
    Family.POINT: _point,
}


def _arms(arm: Arm, start: ex.Expression, goal: ex.Expression, preferred: list[Turn]) -> list[BranchSolution]:
    """Motions of the first three joints that carry a point from start to goal."""
    one, two, three = arm.lines[:3]
    task = Placing((one, two, three), start, goal, tuple(preferred), arm.meeting, arm.size)
    return position_solutions(arm.pattern.positioning, task, reverse=arm.pattern.positioning_reversed)


def _residual(
    arm: Arm,
    solution: BranchSolution,
    starts: tuple[ex.Expression, ex.Expression, ex.Expression],
    goals: tuple[ex.Expression, ex.Expression, ex.Expression],
    at: int,
) -> ex.Expression:
    """Forward kinematics of a point on the axes of the joints after `at`, and of two unit vectors, against the pose."""
    point, first, second = starts
    still = any(j == -1 for j in arm.pattern.joints[at:])
    place = _carried(arm, arm.lines if still else arm.lines[:at], solution, point)
    moved = [_turn(arm, solution, x) for x in (first, second)]
    squares = [ex.sumsqr(x - goal) for x, goal in zip((place, *moved), goals, strict=True)]
    return ex.sqrt(ex.fmax(squares[0], ex.fmax(squares[1], squares[2])))


def _carried(arm: Arm, lines: list[Line], solution: BranchSolution, x: ex.Expression) -> ex.Expression:
    """A point carried by the joints that exist (and by added ones that may turn)."""
    real = [k for k in range(len(lines)) if arm.pattern.joints[k] != -1]
    return forward([lines[k] for k in real], [solution.motions[k] for k in real], x)


def _turn(arm: Arm, solution: BranchSolution, x: ex.Expression) -> ex.Expression:
    for line, motion, joint in reversed(list(zip(arm.lines, solution.motions, arm.pattern.joints, strict=True))):
        x = x if joint == -1 else line.vector(x, motion)
    return x


def _sign(turn: Turn, sense: ex.Expression) -> Turn:
    """The turn, or its opposite where the sense is negative."""
    return Turn(turn.c, sense * turn.s)


def _same_sense(h: ex.Expression, w: ex.Expression) -> ex.Expression:
    """One if two parallel axes point the same way, else minus one."""
    return ex.sign(ex.dot(h, w))


def _far_from(w: ex.Expression) -> ex.Expression:
    """A coordinate direction far from a unit vector."""
    x, y = ex.fabs(w[0]), ex.fabs(w[1])
    first = ex.logic_and(x <= y, x <= 0.7)
    return ex.vertcat(first, ex.if_else(first, 0, 1), 0)
