"""All postures of an arm for a pose in closed form, as one expression without branches.

References: Paden, Kinematics and Control of Robot Manipulators, 1986; Elias and Wen, IK-Geo, 2022; Pieper, 1968.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import casadi as ca

from mafsil.algebra.spatial import cross
from mafsil.algebra.subproblems import (
    Root,
    Turn,
    turn_onto,
    turns_about_two_axes,
    turns_to_distance,
    turns_to_height,
    unturned,
)
from mafsil.mechanics.arm_pattern import ArmPattern, Family, HeldJoint, PointRoad

Motion: TypeAlias = Turn | ca.SX
"""Of a turning joint its turn, of a sliding one its distance [m]."""


@dataclass(frozen=True, eq=False)
class Line:
    """A joint axis: unit direction w through r; the joint slides along it or turns about it."""

    slides: bool
    w: ca.SX
    r: ca.SX

    @property
    def opposite(self) -> Line:
        """The same axis in the other sense: what was q is now -q, moved backwards it is q again."""
        return Line(self.slides, -self.w, self.r)

    def point(self, x: ca.SX, motion: Motion) -> ca.SX:
        """(3,) point x carried by the joint."""
        return self.r + motion.about(self.w, x - self.r) if isinstance(motion, Turn) else x + motion * self.w

    def vector(self, x: ca.SX, motion: Motion) -> ca.SX:
        """(3,) vector x carried by the joint."""
        return motion.about(self.w, x) if isinstance(motion, Turn) else x


@dataclass(frozen=True, eq=False)
class Posture:
    """One branch: the motion of every joint, which of them are free, and by how much a step missed."""

    motions: tuple[Motion, ...]
    free: tuple[ca.SX, ...]
    shortfall: ca.SX

    def followed_by(self, motions: Sequence[Motion], free: Sequence[ca.SX], shortfall: ca.SX) -> Posture:
        """The posture with further joints."""
        worst = ca.fmax(self.shortfall, shortfall)
        return Posture((*self.motions, *motions), (*self.free, *free), worst)


def closed_form(pattern: ArmPattern, T: ca.SX, near: ca.SX | None) -> ca.SX:
    """(branches, n + 3) rows (q, residual, shortfall, free) of every branch.

    The residual is the larger of the distances by which the branch's forward kinematics misses the pose: of the placed
    point [m], and of two unit vectors of the tip [rad]. Free is the sum of 2^i over the free coordinates i.

    Args:
        pattern: of the arm; its numbers become constants.
        T: (4, 4) wanted pose of the tip in {s}.
        near: (n,) coordinates that free joints take; zero if None.
    """
    arm = _Arm(pattern, *_displacement(pattern, T))
    arm.patient = near is not None
    for held in reversed(pattern.held):
        assert near is not None
        arm.hold(held, near[held.joint])
    preferred = [_preferred(j, near) for j in pattern.joints]
    postures, misses = _FAMILIES[pattern.family](arm, preferred)
    return ca.vertcat(*(_row(pattern, a, miss, near) for a, miss in zip(postures, misses, strict=True)))


class _Arm:
    """A pattern as expressions: lines and places at q = 0, and the displacement R, p that they shall make.

    `patient` asks for members of families whose preferred member is out of reach, at the price of longer code.
    """

    def __init__(self, pattern: ArmPattern, R: ca.SX, p: ca.SX) -> None:
        self.pattern, self.size, self.R, self.p = pattern, pattern.size, R, p
        self.lines = [_line(pattern, i) for i in range(len(pattern.slides))]
        self.centre, self.meeting = ca.SX(pattern.centre), ca.SX(pattern.meeting)
        self.patient = False

    def hold(self, held: HeldJoint, value: ca.SX) -> None:
        """Carry all that comes after a held joint along with it, and take its motion off the displacement.

        e_1 .. E e_k .. e_m = P  becomes  e_1 .. (E e_k E^-1) .. (E e_m E^-1) = P E^-1
        """
        line = Line(held.slides, ca.SX(held.axis), ca.SX(held.point))
        motion: Motion = value if held.slides else Turn(ca.cos(value), ca.sin(value))
        for i in range(held.at, len(self.lines)):
            old = self.lines[i]
            self.lines[i] = Line(old.slides, line.vector(old.w, motion), line.point(old.r, motion))
        family = self.pattern.family
        last = 2 if family is Family.PLANAR else 5
        if held.at <= last and not (family is Family.POINT and self.pattern.reversed):
            self.centre = line.point(self.centre, motion)
        if held.at <= 1:
            self.meeting = line.point(self.meeting, motion)
        columns = [line.opposite.vector(ca.SX(column), motion) for column in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]
        start = line.opposite.point(ca.SX.zeros(3), motion) if isinstance(motion, Turn) else -motion * line.w
        self.p = self.R @ start + self.p
        self.R = self.R @ ca.horzcat(*columns)


Solved: TypeAlias = tuple[list[Posture], list[ca.SX]]
"""The branches of a family, and by how much the forward kinematics of each misses."""


def _spherical_wrist(arm: _Arm, preferred: list[Turn]) -> Solved:
    """Three joints place the wrist's centre, the wrist turns the tip."""
    pattern, lines, R, p, centre = arm.pattern, arm.lines, arm.R, arm.p, arm.centre
    target = R @ centre + p
    w4, w5, w6 = (line.w for line in lines[3:])
    aside = _aside(w6, w5)
    postures: list[Posture] = []
    misses: list[ca.SX] = []
    for placed in _arms(arm, centre, target, preferred[:3]):
        tip, side = (_back(lines[:3], placed.motions, R @ x) for x in (w6, aside))
        for pair in turns_about_two_axes(w4, w5, w6, tip, (preferred[3], preferred[4])):
            turns = (pair.first.turn, pair.second.turn)
            turned = turns[1].back().about(w5, turns[0].back().about(w4, side))
            last = turn_onto(w6, aside, turned, preferred[5])
            free = (pair.first.free, pair.second.free, last.free)
            posture = placed.followed_by((*turns, last.turn), free, pair.first.shortfall)
            postures.append(posture)
            misses.append(_miss(pattern, lines, posture, (centre, w6, aside), (target, R @ w6, R @ aside), at=3))
    return postures, misses


def _three_parallel(arm: _Arm, preferred: list[Turn]) -> Solved:
    """The height along the parallel axes gives the first joint, directions the wrist, a triangle the rest."""
    pattern, lines, R, p, centre = arm.pattern, arm.lines, arm.R, arm.p, arm.centre
    one, two, three, four, five, six = lines
    h, w5, w6 = two.w, five.w, six.w
    aside = _aside(w6, w5)
    target = R @ centre + p
    s3, s4 = (_same_sense(h, line.w) for line in (three, four))
    postures: list[Posture] = []
    misses: list[ca.SX] = []
    for motion, free, short in _to_height(one, h, centre, target, preferred[0], pattern.size):
        tip, side = (one.opposite.vector(R @ x, motion) for x in (w6, aside))
        for pair in turns_about_two_axes(h, w5, w6, tip, (preferred[1], preferred[4])):
            total, fifth = pair.first.turn, pair.second.turn
            if arm.patient:
                hub = one.opposite.point(target, motion)
                total = _within_reach(arm, total, pair.first.free, hub)
            last = turn_onto(w6, aside, fifth.back().about(w5, total.back().about(h, side)), preferred[5])
            inner = six.opposite.point(five.opposite.point(four.r, fifth), last.turn)
            place = one.opposite.point(R @ inner + p, motion)
            for elbow in _to_radius(three, four.r, two, place, preferred[2], pattern.size):
                second = turn_onto(
                    h, three.point(four.r, elbow.turn) - two.r, place - two.r, preferred[1], pattern.size
                )
                rest = total.then(second.turn.back()).then(_signed(elbow.turn, -s3))
                motions = (motion, second.turn, elbow.turn, _signed(rest, s4), fifth, last.turn)
                freedoms = (free, second.free, elbow.free, ca.SX(0), pair.second.free, pair.first.free)
                shortfall = ca.fmax(ca.fmax(short, pair.first.shortfall), elbow.shortfall)
                posture = Posture(motions, freedoms, shortfall)
                postures.append(posture)
                goals = (target, R @ w6, R @ aside)
                misses.append(_miss(pattern, lines, posture, (centre, w6, aside), goals, at=4))
    return postures, misses


def _within_reach(arm: _Arm, total: Turn, free: ca.SX, hub: ca.SX) -> Turn:
    """Where the sixth axis is parallel to the three and the turn of joint 4's link is free: one that can be reached.

    The link turns about `hub`, the placed meeting point; if joint 4 comes too far from axis 2 or too near, back within.
    """
    two, three, four = arm.lines[1:4]
    h = two.w
    hinge = hub + total.about(h, _across(h, four.r - arm.centre))
    distance = _norm(_across(h, hinge - two.r))
    upper, lower = (_norm(_across(h, x)) for x in (three.r - two.r, four.r - three.r))
    least, most = ca.fabs(upper - lower), upper + lower
    # Not to the margin itself, where the elbow is straight and the link's turn no longer a coordinate of the family.
    inset = 0.1 * (most - least)
    wanted = ca.fmin(ca.fmax(distance, least + inset), most - inset)
    root = turns_to_distance(h, hinge - hub, two.r - hub, wanted**2, unturned(), arm.size)[0]
    moved = ca.logic_and(free, ca.logic_or(distance < least, distance > most))
    turned = total.then(root.turn)
    return Turn(ca.if_else(moved, turned.c, total.c), ca.if_else(moved, turned.s, total.s))


def _planar(arm: _Arm, preferred: list[Turn]) -> Solved:
    """Joints 1 to 3 turn about parallel axes, the fourth slides along them."""
    pattern, lines, R, p = arm.pattern, arm.lines, arm.R, arm.p
    one, two, three, slide = lines
    h, point = one.w, three.r
    s2, s3 = (_same_sense(h, line.w) for line in (two, three))
    along = _aside(h, ca.SX(_any_normal(pattern)))
    target = R @ point + p
    distance = ca.dot(h, target - point) / ca.dot(h, slide.w)
    total = turn_onto(h, along, R @ along, preferred[2])
    postures: list[Posture] = []
    misses: list[ca.SX] = []
    for elbow in _to_radius(two, point, one, target, preferred[1], pattern.size):
        # With a third joint that does not exist the orientation chooses the first where its place leaves it free.
        wished = total.turn.then(_signed(elbow.turn, -s2)) if pattern.joints[2] == -1 else preferred[0]
        first = turn_onto(h, two.point(point, elbow.turn) - one.r, target - one.r, wished, pattern.size)
        rest = _signed(total.turn.then(first.turn.back()).then(_signed(elbow.turn, -s2)), s3)
        posture = Posture(
            (first.turn, elbow.turn, rest, distance), (first.free, elbow.free, ca.SX(0), ca.SX(0)), elbow.shortfall
        )
        postures.append(posture)
        misses.append(_miss(pattern, lines, posture, (point, h, along), (target, R @ h, R @ along), at=4))
    return postures, misses


def _point(arm: _Arm, preferred: list[Turn]) -> Solved:
    """Only the place of the tip counts."""
    target = arm.R @ arm.centre + arm.p
    postures = _arms(arm, arm.centre, target, preferred)
    return postures, [_distance(_forward(arm.pattern, arm.lines, one, arm.centre), target) for one in postures]


_FAMILIES = {
    Family.SPHERICAL_WRIST: _spherical_wrist,
    Family.THREE_PARALLEL: _three_parallel,
    Family.PLANAR: _planar,
    Family.POINT: _point,
}


def _arms(arm: _Arm, start: ca.SX, goal: ca.SX, preferred: list[Turn]) -> list[Posture]:
    """Motions of the first three joints that carry a point from start to goal."""
    pattern, lines, meeting = arm.pattern, arm.lines[:3], arm.meeting
    road = {PointRoad.PARALLEL: _by_height, PointRoad.MEET: _by_distance, PointRoad.LINEAR: _by_slides}[pattern.road]
    if not pattern.road_reversed:
        return road(lines, start, goal, preferred, meeting, pattern.size)
    backwards = [line.opposite for line in reversed(lines)]
    found = road(backwards, goal, start, preferred[::-1], meeting, pattern.size)
    return [Posture(one.motions[::-1], one.free[::-1], one.shortfall) for one in found]


def _by_height(
    lines: list[Line], start: ca.SX, goal: ca.SX, preferred: list[Turn], _meeting: ca.SX, size: float
) -> list[Posture]:
    """The last two joints keep the height along the second's axis, so the first must give it."""
    one, two, three = lines
    arms: list[Posture] = []
    for motion, free, short in _to_height(one, two.w, start, goal, preferred[0], size):
        place = one.opposite.point(goal, motion) if isinstance(motion, Turn) else goal - motion * one.w
        for third, free3, short3 in _to_radius_any(three, start, two, place, preferred[2], size):
            second = turn_onto(two.w, three.point(start, third) - two.r, place - two.r, preferred[1], size)
            arms.append(Posture((motion, second.turn, third), (free, second.free, free3), ca.fmax(short, short3)))
    return arms


def _by_distance(
    lines: list[Line], start: ca.SX, goal: ca.SX, preferred: list[Turn], meeting: ca.SX, size: float
) -> list[Posture]:
    """The first two joints keep the distance from where their axes meet, so the third must give it."""
    one, two, three = lines
    arms: list[Posture] = []
    offset = goal - meeting
    for third, free, short in _to_distance(three, start, meeting, ca.dot(offset, offset), preferred[2], size):
        reached = three.point(start, third) - meeting
        for pair in turns_about_two_axes(one.w, two.w, reached, offset, (preferred[0], preferred[1]), size):
            motions = (pair.first.turn, pair.second.turn, third)
            shortfall = ca.fmax(short, pair.first.shortfall)
            arms.append(Posture(motions, (pair.first.free, pair.second.free, free), shortfall))
    return arms


def _by_slides(
    lines: list[Line], start: ca.SX, goal: ca.SX, _preferred: list[Turn], _meeting: ca.SX, _size: float
) -> list[Posture]:
    """Three slides: linear equations."""
    distances = ca.solve(ca.horzcat(*(line.w for line in lines)), goal - start)
    placed = Posture((distances[0], distances[1], distances[2]), (ca.SX(0),) * 3, ca.SX(0))
    return [placed] * 4


Moved: TypeAlias = tuple[Motion, ca.SX, ca.SX]
"""A motion, whether it is free, and its shortfall."""


def _to_height(line: Line, h: ca.SX, start: ca.SX, goal: ca.SX, preferred: Turn, size: float) -> list[Moved]:
    """Motions of a joint whose inverse brings `goal` to the height of `start` along h."""
    if line.slides:
        return [(ca.dot(h, goal - start) / ca.dot(h, line.w), ca.SX(0), ca.SX(0))] * 2
    roots = turns_to_height(-line.w, h, goal - line.r, ca.dot(h, start - line.r), preferred, size)
    return [(root.turn, root.free, root.shortfall) for root in roots]


def _to_radius(line: Line, start: ca.SX, axis: Line, goal: ca.SX, preferred: Turn, size: float) -> tuple[Root, Root]:
    """Turns that bring `start` as far from a parallel axis as `goal` is."""
    radius = _across(axis.w, goal - axis.r)
    return turns_to_distance(line.w, start - line.r, axis.r - line.r, ca.dot(radius, radius), preferred, size)


def _to_radius_any(line: Line, start: ca.SX, axis: Line, goal: ca.SX, preferred: Turn, size: float) -> list[Moved]:
    """The same for a parallel turning joint or a slide across the axis."""
    if not line.slides:
        return [(root.turn, root.free, root.shortfall) for root in _to_radius(line, start, axis, goal, preferred, size)]
    radius = _across(axis.w, goal - axis.r)
    return _slide_to(_across(axis.w, line.w), _across(axis.w, start - axis.r), ca.dot(radius, radius))


def _to_distance(line: Line, start: ca.SX, centre: ca.SX, square: ca.SX, preferred: Turn, size: float) -> list[Moved]:
    """Motions that bring `start` to a distance from `centre`."""
    if line.slides:
        return _slide_to(line.w, start - centre, square)
    height = ca.dot(line.w, start - centre)
    roots = turns_to_distance(line.w, start - line.r, centre - line.r, square - height**2, preferred, size)
    return [(root.turn, root.free, root.shortfall) for root in roots]


def _slide_to(w: ca.SX, offset: ca.SX, square: ca.SX) -> list[Moved]:
    """Both d with |offset + d w|^2 = square, the farther along w first."""
    middle = ca.dot(w, offset)
    aside = offset - middle * w
    rest = square - ca.dot(aside, aside)
    half = ca.sqrt(ca.fmax(rest, 0))
    shortfall = _norm(aside) - ca.sqrt(ca.fmax(square, 0))
    short = ca.fmax(shortfall, 0)
    return [(half - middle, ca.SX(0), short), (-half - middle, ca.SX(0), short)]


def _miss(
    pattern: ArmPattern,
    lines: list[Line],
    posture: Posture,
    starts: tuple[ca.SX, ca.SX, ca.SX],
    goals: tuple[ca.SX, ca.SX, ca.SX],
    at: int,
) -> ca.SX:
    """Forward kinematics of a point on the axes of the joints after `at`, and of two unit vectors, against the pose."""
    point, first, second = starts
    still = any(j == -1 for j in pattern.joints[at:])
    place = _forward(pattern, lines if still else lines[:at], posture, point)
    moved = [_turned(pattern, lines, posture, x) for x in (first, second)]
    squares = [ca.sumsqr(x - goal) for x, goal in zip((place, *moved), goals, strict=True)]
    return ca.sqrt(ca.fmax(squares[0], ca.fmax(squares[1], squares[2])))


def _forward(pattern: ArmPattern, lines: Sequence[Line], posture: Posture, x: ca.SX) -> ca.SX:
    """A point carried by the joints that exist (and by added ones that may turn)."""
    for line, motion, joint in reversed(list(zip(lines, posture.motions, pattern.joints, strict=False))):
        x = x if joint == -1 else line.point(x, motion)
    return x


def _turned(pattern: ArmPattern, lines: Sequence[Line], posture: Posture, x: ca.SX) -> ca.SX:
    for line, motion, joint in reversed(list(zip(lines, posture.motions, pattern.joints, strict=True))):
        x = x if joint == -1 else line.vector(x, motion)
    return x


def _back(lines: Sequence[Line], motions: Sequence[Motion], x: ca.SX) -> ca.SX:
    """A vector seen before the motions."""
    for line, motion in zip(lines, motions, strict=True):
        x = line.opposite.vector(x, motion)
    return x


def _row(pattern: ArmPattern, posture: Posture, miss: ca.SX, near: ca.SX | None) -> ca.SX:
    values: list[ca.SX] = [ca.SX(0)] * pattern.n
    for held in pattern.held:
        assert near is not None
        values[held.joint] = near[held.joint]
    code = ca.SX(0)
    for motion, free, joint in zip(posture.motions, posture.free, pattern.joints, strict=True):
        if joint >= 0:
            values[joint] = motion.angle if isinstance(motion, Turn) else motion
        if joint != -1:
            code = code + 2.0 ** (joint if joint >= 0 else 20) * free
    return ca.horzcat(*values, miss, posture.shortfall, code)


def _displacement(pattern: ArmPattern, T: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Rotation and translation of T home^-1, or of its inverse for a reversed arm."""
    R_h, p_h = ca.SX(pattern.home[:3, :3]), ca.SX(pattern.home[:3, 3])
    R = T[:3, :3] @ R_h.T
    p = T[:3, 3] - R @ p_h
    return (R.T, -R.T @ p) if pattern.reversed else (R, p)


def _line(pattern: ArmPattern, i: int) -> Line:
    return Line(pattern.slides[i], ca.SX(pattern.axes[i]), ca.SX(pattern.points[i]))


def _preferred(joint: int, near: ca.SX | None) -> Turn:
    if near is None or joint < 0:
        return unturned()
    return Turn(ca.cos(near[joint]), ca.sin(near[joint]))


def _signed(turn: Turn, sense: ca.SX) -> Turn:
    """The turn, or its opposite where the sense is negative."""
    return Turn(turn.c, sense * turn.s)


def _same_sense(h: ca.SX, w: ca.SX) -> ca.SX:
    """One if two parallel axes point the same way, else minus one."""
    return ca.sign(ca.dot(h, w))


def _aside(w: ca.SX, other: ca.SX) -> ca.SX:
    """(3,) a unit vector normal to w."""
    normal = cross(w, other)
    return normal / _norm(normal)


def _any_normal(pattern: ArmPattern) -> list[float]:
    """A unit vector of the frame far from the first axis."""
    least = int(abs(pattern.axes[0]).argmin())
    return [1.0 if i == least else 0.0 for i in range(3)]


def _across(w: ca.SX, x: ca.SX) -> ca.SX:
    return x - ca.dot(w, x) * w


def _norm(x: ca.SX) -> ca.SX:
    return ca.sqrt(ca.dot(x, x))


def _distance(x: ca.SX, y: ca.SX) -> ca.SX:
    return _norm(x - y)
