"""Forward kinematics and Jacobians by products of exponentials, helical joints too, derived step by step in letters.

The arm is given by its screw axes, with the numbers against which its products are checked. A run of parallel axes is
one turn by the sum of its angles, so that c12 and s123 appear at once:
P_i = E_1 ... E_i has the rotation R_i and the origin p_i = p_i-1 + R_i-1 r_i - R_i r_i + h_i theta_i R_i-1 w_i.

Reference: Lynch & Park, Modern Robotics, sec. 4.1 and 5.1.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import takewhile
from typing import Literal, TypeAlias

import numpy as np

from mafsil.arrays import Floats, Vector3
from mafsil.derivation.document import Derivation, Grid, Line, Name, Step, letter_line
from mafsil.derivation.polynomial import (
    ONE,
    ZERO,
    Angle,
    Entries,
    Polynomial,
    Row,
    SymbolicPose,
    angle_sum,
    constant,
    cross,
    minus,
    numbers,
    plus,
    product,
    scale_row,
    symbol,
    transform,
    transpose,
    trig,
)
from mafsil.derivation.tolerances import NOTHING
from mafsil.derivation.verification import STATES, Judge
from mafsil.errors import InputError, ModelError
from mafsil.model import JointKind, Mechanism
from mafsil.model.dh_from_axes import screws
from mafsil.model.exponentials import chain_to_tip, kind_of_screw
from mafsil.robot import Robot


@dataclass(frozen=True, slots=True, eq=False)
class ScrewJoint:
    """One joint.

    Attributes:
        direction: (3,) of the axis or the slide.
        point: of the axis in letters; that of the joint before for a slide.
        pitch: advance per radian in letters.
        turns: whether it turns.
    """

    direction: Vector3
    point: Row
    pitch: Polynomial
    turns: bool


@dataclass(frozen=True, slots=True, eq=False)
class ScrewArm:
    """The chain from base to tip by screws.

    Attributes:
        mechanism: the robot.
        joints: base first.
        home: pose of the tip at q = 0.
        letters: number of every letter [m | m/rad].
        coordinates: for each joint, its place in q.
    """

    mechanism: Mechanism
    joints: tuple[ScrewJoint, ...]
    home: SymbolicPose
    letters: dict[str, float]
    coordinates: tuple[int, ...]

    @property
    def n(self) -> int:
        """Number of joints of the chain."""
        return len(self.joints)

    def screw(self, index: int) -> Row:
        """(6,) S = (omega, v): v = r x omega + h omega, or (0, direction)."""
        return self.moved_screw(index, _IDENTITY)

    def moved_screw(self, index: int, pose: SymbolicPose) -> Row:
        """(6,) Ad(pose) S: direction and point of the axis are moved, the pitch stays."""
        joint = self.joints[index]
        w = transform(pose.R, _row(joint.direction))
        if not joint.turns:
            return (ZERO, ZERO, ZERO, *w)
        r = plus(pose.p, transform(pose.R, joint.point))
        return (*w, *plus(cross(r, w), scale_row(joint.pitch, w)))

    def exponential(self, index: int) -> SymbolicPose:
        """E = exp([S] q)."""
        *_, last = self._run(index, index + 1)
        return last

    def products(self, longest: int) -> tuple[SymbolicPose, ...]:
        """P_0 = I, P_1 = E_1, P_2 = E_1 E_2 ..., as far as none is longer than `longest` on paper."""
        poses = takewhile(lambda P: sum(x.length for row in P.entries for x in row) <= longest, self._run(0, self.n))
        return tuple(poses)

    def _run(self, start: int, stop: int) -> Iterator[SymbolicPose]:
        """The identity and the products of the joints from start.

        Turns about parallel neighbours are added to one angle; what stood before them is kept beside.
        """
        pose, before, axis, angle = _IDENTITY, _IDENTITY.R, None, ()
        yield pose
        for index in range(start, stop):
            joint, name = self.joints[index], index + 1
            w = transform(pose.R, _row(joint.direction))
            if not joint.turns:
                pose = SymbolicPose(pose.R, plus(pose.p, scale_row(symbol(f"q{name}", name), w)))
                yield pose
                continue
            sense = 0 if axis is None else _sense(axis, joint.direction)
            own: Angle = ((f"theta{name}", 1),)
            if axis is not None and sense:
                angle = angle_sum(angle, own, sense)
            else:
                before, axis, angle = pose.R, joint.direction, own
            R = product(before, _turn(axis, angle))
            p = plus(pose.p, minus(transform(pose.R, joint.point), transform(R, joint.point)))
            if not joint.pitch.is_zero:
                p = plus(p, scale_row(joint.pitch * symbol(f"theta{name}", name), w))
            pose = SymbolicPose(R, p)
            yield pose


class ScrewJudge(Judge):
    """The compiled robot at random states, for products of exponentials.

    Attributes:
        home: (states, 4, 4) home pose, the same at every state.
        moved: (n + 1, states, 4, 4) products of the first exponentials: poses of links against those at q = 0.
    """

    def __init__(self, arm: ScrewArm, seed: int = 5) -> None:
        robot = self.robot = Robot(arm.mechanism)
        rng = np.random.default_rng(seed)
        q = self.q = np.zeros((STATES, arm.mechanism.n))
        for place, joint in zip(arm.coordinates, arm.joints, strict=True):
            q[:, place] = rng.uniform(-np.pi, np.pi, STATES) if joint.turns else rng.uniform(-1.0, 1.0, STATES)
        self.values = {**arm.letters}
        for i, place in enumerate(arm.coordinates, start=1):
            self.values[f"q{i}"] = self.values[f"theta{i}"] = q[:, place]
        self.tip = np.asarray(robot.forward_kinematics(q))
        self.J_s = np.asarray(robot.jacobian_space(q))[:, :, list(arm.coordinates)]
        zero = np.zeros(arm.mechanism.n)
        self.home = np.broadcast_to(np.asarray(robot.forward_kinematics(zero)), self.tip.shape)
        links = [arm.mechanism.link_names.index(j.child) for j in chain_to_tip(arm.mechanism) if j.moves]
        now, then = np.asarray(robot.link_poses(q)), np.asarray(robot.link_poses(zero))
        identity = np.broadcast_to(np.eye(4), self.tip.shape)
        self.moved = np.stack([identity, *(np.asarray(now[:, k] @ np.linalg.inv(then[k]), np.float64) for k in links)])

    def exponential(self, i: int) -> Floats:
        """(states, 4, 4) E_i."""
        before: Floats = np.asarray(np.linalg.inv(self.moved[i - 1]), dtype=np.float64)
        return before @ self.moved[i]


def screw_arm(mechanism: Mechanism) -> ScrewArm:
    """The arm to the tip by screws in letters.

    Points are chosen one after the other, each on its axis next to the one before; the steps between them get letters:
    one length L_i, or x_i, y_i, z_i.

    Args:
        mechanism: any; its chain to the tip is taken.

    Raises:
        ModelError: a mimic joint on the chain, or no joint at all.
    """
    S, _, home = screws(mechanism)
    if not len(S):
        raise ModelError("derivation.no_joint", robot=mechanism.name)
    letters: dict[str, float] = {}
    joints: list[ScrewJoint] = []
    place, point = np.zeros(3), (ZERO, ZERO, ZERO)
    for i, screw in enumerate(S, start=1):
        kind, direction, pitch = kind_of_screw(screw)
        direction = _tidy(direction)
        advance = ZERO
        if kind is not JointKind.PRISMATIC:
            foot: Vector3 = np.asarray(np.cross(direction, screw[3:]), dtype=np.float64)
            foot = foot + direction * float(direction @ (place - foot))
            point = _step(point, foot - place, i - 1, letters)
            place = foot
            advance = _letter(f"h{i}", pitch, letters)
        joints.append(ScrewJoint(direction, point, advance, kind is not JointKind.PRISMATIC))
    tip = _step(point, home[:3, 3] - place, len(S), letters)
    moving = [joint for joint in chain_to_tip(mechanism) if joint.moves]
    coordinates = tuple(mechanism.joint_names.index(joint.name) for joint in moving)
    return ScrewArm(mechanism, tuple(joints), SymbolicPose(numbers(home[:3, :3]), tip), letters, coordinates)


def _step(point: Row, step: Vector3, i: int, letters: dict[str, float]) -> Row:
    """The next point in letters."""
    along = [k for k in range(3) if abs(step[k]) > NOTHING]
    names = {k: f"L{i}" if len(along) == 1 else f"{'xyz'[k]}{i}" for k in along}
    return tuple(x + _letter(names[k], float(step[k]), letters) if k in names else x for k, x in enumerate(point))


def _letter(name: str, value: float, letters: dict[str, float]) -> Polynomial:
    if abs(value) < NOTHING:
        return ZERO
    letters[name] = value
    return symbol(name)


def _turn(axis: Vector3, angle: Angle) -> Entries:
    """Rot(axis, angle) = c I + s [w] + (1 - c) w w'."""
    c, s = trig(False, angle), trig(True, angle)
    hat = np.cross(axis, np.eye(3)).T
    outer = np.outer(axis, axis)
    return tuple(
        tuple(
            c * constant(float((k == j) - outer[k, j])) + s * constant(float(hat[k, j])) + constant(float(outer[k, j]))
            for j in range(3)
        )
        for k in range(3)
    )


def _sense(one: Vector3, two: Vector3) -> int:
    """1 if parallel, -1 if opposite, else 0."""
    for sense in (1, -1):
        if float(np.abs(one - sense * two).max()) < NOTHING:
            return sense
    return 0


def _tidy(direction: Vector3) -> Vector3:
    rounded = np.round(direction)
    return np.where(np.abs(direction - rounded) < NOTHING, rounded, direction)


def _row(values: Vector3) -> Row:
    return tuple(constant(float(x)) for x in values)


_IDENTITY = SymbolicPose(((ONE, ZERO, ZERO), (ZERO, ONE, ZERO), (ZERO, ZERO, ONE)), (ZERO, ZERO, ZERO))
Form: TypeAlias = Literal["dh", "screws"]
LONGEST = 1500
"""Factors and terms of a product on paper; longer ones stay products."""
_AXES = "xyz"


def wants_screws(form: str) -> bool:
    """Whether the method is that of screws.

    Raises:
        InputError: neither `dh` nor `screws`.
    """
    if form not in ("dh", "screws"):
        raise InputError("derivation.form", value=form, known="dh, screws")
    return form == "screws"


def fk_by_screws(mechanism: Mechanism) -> Derivation:
    """T_st = exp([S_1] q_1) ... exp([S_n] q_n) M, every line checked.

    Args:
        mechanism: its chain to the tip may have revolute, prismatic and helical joints.
    """
    arm = screw_arm(mechanism)
    judge = ScrewJudge(arm)
    found = arm.products(LONGEST)
    steps = [_table(arm, judge), _exponentials(arm, judge), _products(judge, found), _tip(arm, judge, found)]
    return Derivation("derivation.fk_title", mechanism.name, tuple(steps), STATES)


def jacobian_by_screws(mechanism: Mechanism) -> Derivation:
    """J_s,i = Ad(E_1 ... E_i-1) S_i, every line checked.

    Args:
        mechanism: its chain to the tip may have revolute, prismatic and helical joints.
    """
    arm = screw_arm(mechanism)
    judge = ScrewJudge(arm)
    found = arm.products(LONGEST)
    before = found[: arm.n]
    columns = [arm.moved_screw(i, pose) for i, pose in enumerate(before)]
    lines = [
        judge.line((Name("J", f"s,{i}"),), tuple((x,) for x in column), truth=judge.J_s[:, :, i - 1 : i])
        for i, column in enumerate(columns, start=1)
    ]
    steps = [_table(arm, judge), _exponentials(arm, judge), _products(judge, before)]
    steps.append(Step("derivation.screw_columns", {}, tuple(lines)))
    if len(columns) < arm.n:
        steps.append(Step("derivation.screw_columns_long", {"count": len(columns), "limit": LONGEST}))
    else:
        whole = judge.line((Name("J", "s"),), transpose(tuple(columns)), truth=judge.J_s)
        steps.append(Step("derivation.whole", {}, (whole,)))
    return Derivation("derivation.jacobian_title", mechanism.name, tuple(steps), STATES)


def _table(arm: ScrewArm, judge: ScrewJudge) -> Step:
    """Screws and home pose, and what the letters stand for."""
    head = (Name("i"), *(Name("ω", a) for a in _AXES), *(Name("v", a) for a in _AXES))
    rows = tuple((str(i), *arm.screw(i - 1)) for i in range(1, arm.n + 1))
    lines = [letter_line(name, value) for name, value in arm.letters.items()]
    for i, joint in enumerate(arm.joints, start=1):
        if joint.turns:
            lines.append(Line((Name(f"theta{i}"),), (symbol(f"q{i}"),)))
    lines.append(judge.line((Name("M"),), arm.home.entries, truth=judge.home))
    return Step("derivation.screw_table", {"robot": arm.mechanism.name}, tuple(lines), Grid(head, rows))


def _exponentials(arm: ScrewArm, judge: ScrewJudge) -> Step:
    lines = [
        judge.line((Name("E", str(i)),), arm.exponential(i - 1).entries, truth=judge.exponential(i))
        for i in range(1, arm.n + 1)
    ]
    return Step("derivation.screw_exponentials", {}, tuple(lines))


def _products(judge: ScrewJudge, found: Sequence[SymbolicPose]) -> Step:
    """P_2 and the later ones; P_1 is E_1."""
    lines: list[Line] = []
    for i, pose in enumerate(found[2:], start=2):
        sides = (Name("P" if i > 2 else "E", str(i - 1)), Name("E", str(i)))
        lines.append(judge.line((Name("P", str(i)),), sides, pose.entries, truth=judge.moved[i]))
    return Step("derivation.screw_products", {}, tuple(lines))


def _tip(arm: ScrewArm, judge: ScrewJudge, found: Sequence[SymbolicPose]) -> Step:
    """T_st in formulas, or as a product of what was written before."""
    last = len(found) - 1
    names = [Name("P" if last > 1 else "E", str(last))] if last else []
    names += [Name("E", str(i)) for i in range(last + 1, arm.n + 1)] + [Name("M")]
    if last < arm.n:
        T = judge.matrix(found[-1].entries)
        for i in range(last, arm.n):
            T = T @ judge.matrix(arm.exponential(i).entries)
        error = float(np.abs(T @ judge.matrix(arm.home.entries) - judge.tip).max())
        details = {"count": last, "limit": LONGEST, "tip": arm.mechanism.tip}
        return Step("derivation.screw_result_long", details, (Line((Name("T", "st"),), (tuple(names),), error),))
    R = product(found[-1].R, arm.home.R)
    p = plus(found[-1].p, transform(found[-1].R, arm.home.p))
    lines = [Line((Name("T", "st"),), (tuple(names),), 0.0)]
    for r in range(3):
        for c in range(3):
            lines.append(judge.line((Name("r", f"{r + 1}{c + 1}"),), R[r][c], truth=judge.tip[:, r, c]))
    for r, axis in enumerate(_AXES):
        lines.append(judge.line((Name("p", axis),), p[r], truth=judge.tip[:, r, 3]))
    return Step("derivation.screw_result", {"tip": arm.mechanism.tip}, tuple(lines))
