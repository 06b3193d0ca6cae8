"""The numerical judges of derivations: the compiled robot at random states, and at every solution of random poses."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mafsil.arrays import Floats, PoseMatrix
from mafsil.derivation.arm import SymbolicArm
from mafsil.derivation.document import Factors, Line, Name, Product, Side, is_matrix
from mafsil.derivation.expression import Expression, function, name_expression, plus_minus
from mafsil.derivation.grouping import evaluate as evaluate_factored
from mafsil.derivation.grouping import factor_out
from mafsil.derivation.polynomial import Entries, Polynomial
from mafsil.derivation.tolerances import HALF_DIGITS, LIMIT, ROUNDOFF
from mafsil.errors import MafsilError
from mafsil.mechanics.arm_pattern import ArmPattern, Family, PositioningMethod
from mafsil.model import JointKind, Mechanism
from mafsil.model.exponentials import chain_to_tip
from mafsil.model.placement import rotation_x, translation
from mafsil.robot import Robot

STATES = 20


class DerivationError(MafsilError, RuntimeError):
    """A line of a derivation does not agree with the compiled robot: an error of the derivation, never printed."""


class Judge:
    """Values of the compiled robot at random states, and the check of a line against them.

    Attributes:
        arm: the arm in letters.
        robot, q: the compiled robot and its states (states, n).
        values: numbers of its letters at the states.
        frames: (n + 1, states, 4, 4) poses in {s} of the frames {0} .. {n} of the modified table.
        shown_frames: the same of the table that is shown, which may be classic.
        tip: (states, 4, 4) pose of the tip.
        J_s: (states, 6, n) space Jacobian, columns of the chain's joints.
    """

    def __init__(self, arm: SymbolicArm, seed: int = 5) -> None:
        self.arm = arm
        robot = self.robot = Robot(arm.mechanism)
        q = self.q = _states(arm, np.random.default_rng(seed))
        self.values: dict[str, float | Floats] = arm.values(q)
        self.tip = np.asarray(robot.forward_kinematics(q))
        self.J_s = np.asarray(robot.jacobian_space(q))[:, :, list(arm.coordinates)]
        self.frames = _frames(arm, robot, q)
        self.shown_frames = _shown(arm, self.frames)

    def line(self, left: Product, *sides: Side, truth: Floats, limit: float = LIMIT) -> Line:
        """A line whose formulas have been compared with the truth.

        Args:
            left: what is computed.
            sides: what it equals; formulas and matrices among them are checked as they will be printed.
            truth: (states, rows, columns) or (states,) numbers of the compiled robot.
            limit: relative error allowed.

        Raises:
            DerivationError: a formula differs.
        """
        scale = max(1.0, float(np.abs(truth).max(initial=0.0)))
        error = 0.0
        for side in sides:
            shown = self._shown(side)
            if shown is not None:
                error = max(error, float(np.abs(shown - truth).max()))
        if error > limit * scale:
            name = " ".join(each.letter + each.index for each in left)
            raise DerivationError("derivation.differs", line=name, error=error, limit=limit * scale)
        return Line(left, sides, error)

    def _shown(self, side: Side) -> Floats | None:
        """Numbers of a side that has any."""
        if isinstance(side, Polynomial):
            return self.number(side)
        if isinstance(side, Factors):
            return np.prod([self.number(formula) for formula in side.formulas], axis=0)
        return self.matrix(side) if is_matrix(side) else None

    def number(self, formula: Polynomial) -> Floats:
        """(states,) values of a formula in the form in which it is printed."""
        return np.broadcast_to(evaluate_factored(factor_out(formula), self.values), (STATES,))

    def matrix(self, entries: Entries) -> Floats:
        """(states, rows, columns) values of a matrix."""
        flat = [self.number(x) for row in entries for x in row]
        return np.stack(flat, axis=-1).reshape(STATES, len(entries), len(entries[0]))


def _shown(arm: SymbolicArm, frames: Floats) -> Floats:
    """The frames at the far ends of the links, if the table is classic."""
    if arm.classic is None:
        return frames
    far = [translation(row.a, 0.0, 0.0) @ rotation_x(row.alpha) for row in arm.classic.table.rows]
    return np.concatenate([frames[:1], frames[1:] @ np.array(far)[:, None]])


def _states(arm: SymbolicArm, rng: np.random.Generator) -> Floats:
    """(states, n of the robot): any angle, slides up to twice the arm's size; joints beside the chain at zero."""
    q = np.zeros((STATES, arm.mechanism.n))
    for place, row in zip(arm.coordinates, arm.table.rows, strict=True):
        q[:, place] = rng.uniform(-np.pi, np.pi, STATES) if row.kind == "R" else rng.uniform(-1.0, 1.0, STATES)
    return q


def _frames(arm: SymbolicArm, robot: Robot, q: Floats) -> Floats:
    """Frames of the table, fixed to the robot's own links: T_s,link(q) T_link,i with T_link,i taken at q = 0."""
    links = [joint.child for joint in chain_to_tip(arm.mechanism) if joint.kind is not JointKind.FIXED]
    home = np.asarray(robot.link_poses(np.zeros(arm.mechanism.n)))
    moved = np.asarray(robot.link_poses(q))
    T_s = np.array(arm.table.base)
    frames = [np.broadcast_to(T_s, (STATES, 4, 4))]
    for row, link in zip(arm.table.rows, links, strict=True):
        T_s = T_s @ row.transform(arm.table.convention)
        place = arm.mechanism.link_names.index(link)
        frames.append(np.asarray(moved[:, place] @ np.linalg.inv(home[place]) @ T_s, dtype=np.float64))
    return np.stack(frames)


POSES = 20


class AngleJudge:
    """Values of all names at all solutions of random poses.

    Attributes:
        pattern: what the arm was recognised as.
        axes, points: (m, 3) of the pattern's joints.
        poses: number of poses.
        signed: letters of the unknowns that have two values.
    """

    def __init__(
        self, mechanism: Mechanism, pattern: ArmPattern, solve: Callable[[PoseMatrix], Floats], seed: int = 7
    ) -> None:
        self.pattern, self.axes, self.points = pattern, pattern.axes, pattern.points
        self.poses, self.signed = POSES, list[str]()
        robot = Robot(mechanism)
        q, T = _solutions(robot, solve, np.random.default_rng(seed))
        X: Floats = np.asarray(T @ np.linalg.inv(pattern.home), np.float64)
        if pattern.reversed:
            X = np.asarray(np.linalg.inv(X), np.float64)
        self._count = len(q)
        self.values: dict[str, Floats] = {"R": X[:, :3, :3], "t": X[:, :3, 3]}
        self.constant("m", pattern.centre)
        self.constant("o", pattern.meeting)
        for k, joint in enumerate(pattern.joints):
            self.constant(self.letter("w", k), self.axes[k])
            self.constant(self.letter("r", k), self.points[k])
            self.values[self._unknown(k)] = q[:, joint] if joint >= 0 else np.zeros(len(q))

    def constant(self, name: str, vector: Floats) -> None:
        """A vector that does not depend on the pose."""
        self.values[name] = np.broadcast_to(vector, (self._count, 3))

    def index(self, k: int) -> int:
        """Number of the robot's joint that the pattern's joint k is; its place where it is none."""
        joint = self.pattern.joints[k]
        return joint + 1 if joint >= 0 else k + 1

    def letter(self, stem: str, k: int) -> str:
        """A letter with the number of a joint."""
        return f"{stem}{self.index(k)}"

    def details(self, *joints: int) -> dict[str, object]:
        """Numbers of joints for a sentence: a, b, c."""
        return {letter: self.index(k) for letter, k in zip("abc", joints, strict=False)}

    def w(self, k: int) -> Expression:
        """Direction of an axis."""
        return name_expression(self.letter("w", k))

    def r(self, k: int) -> Expression:
        """A point of an axis."""
        return name_expression(self.letter("r", k))

    def angle(self, k: int) -> Expression:
        """The unknown of a joint."""
        return name_expression(self._unknown(k))

    def across(self, k: int) -> Floats:
        """(3,) a unit vector normal to an axis."""
        axis = self.axes[k]
        side = np.cross(axis, np.eye(3)[int(np.abs(axis).argmin())])
        return side / np.linalg.norm(side)

    def define(self, name: str, formula: Expression) -> Line:
        """A definition: its value is that of its formula, printed where the arm alone decides it."""
        value = np.asarray(formula.evaluate(self.values))
        self.values[name] = value
        if value.ndim > 2 or np.ptp(value, axis=0).max(initial=0.0) > ROUNDOFF * max(1.0, self.pattern.size):
            return Line((Name(name),), (formula,))
        return Line((Name(name),), (formula, vector_text(value[0]) if value.ndim == 2 else number_text(value[0])))

    def less(self, whole: Expression, one: Expression, other: Expression) -> Expression:
        """Whole - one other, or the whole where one of them is zero at all states."""
        zero = any(np.abs(each.evaluate(self.values)).max(initial=0.0) < ROUNDOFF for each in (one, other))
        return whole if zero else whole - one * other

    def elementary(self, k: int, a: Expression, b: Expression, c: Expression) -> list[Line]:
        """A cos x + b sin x = c for the unknown of joint k, checked, and both its solutions, checked."""
        names = [self.letter(stem, k) for stem in "abc"]
        lines = [self.define(name, formula) for name, formula in zip(names, (a, b, c), strict=True)]
        at, bt, ct = (name_expression(name) for name in names)
        x = self.angle(k)
        left = at * function("cos", x) + bt * function("sin", x)
        gap = np.abs(np.asarray(left.evaluate(self.values)) - self.values[names[2]])
        lines.append(Line((), (left, ct), self._error(names[2], gap, self.pattern.size**2)))
        size = function("sqrt", function("square", at) + function("square", bt))
        lines.append(self.judge_joint(k, plus_minus(function("atan2", bt, at), function("acos", ct / size))))
        return lines

    def turn(self, k: int, start: Expression, goal: Expression) -> list[Line]:
        """The turn of joint k that brings one vector to another: its projections, and the angle between them."""
        u, v = self.letter("u", k), self.letter("v", k)
        lines = [self.define(u, start), self.define(v, goal)]
        return [*lines, self.judge_joint(k, between(self.w(k), name_expression(u), name_expression(v)))]

    def total(self, joints: tuple[int, ...], start: Expression, goal: Expression) -> list[Line]:
        """The sum of the turns about parallel axes, as one turn about the first of them."""
        name = "theta" + "".join(str(self.index(k)) for k in joints)
        self._total = name
        first = joints[0]
        u, v = self.letter("e", first), self.letter("f", first)
        lines = [self.define(u, start), self.define(v, goal)]
        self.values[name] = sum((self._sense(k, first) * self.values[self._unknown(k)] for k in joints), np.zeros(1))
        return [*lines, self._solve(name, between(self.w(first), name_expression(u), name_expression(v)), slides=False)]

    def remaining(self, k: int, others: tuple[int, ...]) -> Line:
        """What the sum leaves to joint k."""
        rest = name_expression(self._total)
        for j in others:
            rest = rest - self.angle(j) if self._sense(j, others[0]) > 0 else rest + self.angle(j)
        return self.judge_joint(k, rest if self._sense(k, others[0]) > 0 else -rest)

    def judge_joint(self, k: int, formula: Expression) -> Line:
        """The unknown of joint k, compared with the solver's values."""
        if formula.signed:
            self.signed.append(_plain(self._unknown(k)))
        if self.pattern.joints[k] < 0:
            return Line((Name(self._unknown(k)),), (formula,))
        return self._solve(self._unknown(k), formula, self.pattern.prismatic[k])

    def singular(self) -> list[tuple[str, dict[str, object]]]:
        """Places where steps lose their meaning: keys and details."""
        pattern, cases = self.pattern, list[tuple[str, dict[str, object]]]()
        if pattern.family is Family.PLANAR:
            return [("elbow", self.details(1, 0))]
        if pattern.family is Family.SPHERICAL_WRIST and pattern.positioning is PositioningMethod.MEET:
            cases.append(("pole", self.details(0)))
        else:
            cases.append(("shoulder", self.details(0, 1)))
        if not pattern.prismatic[2]:
            cases.append(("elbow", self.details(2, 1)))
        wrist = (5, 4) if pattern.family is Family.THREE_PARALLEL else (3, 4, 5)
        cases.append(("last" if len(wrist) == 2 else "wrist", self.details(*wrist)))
        return cases

    def _solve(self, name: str, formula: Expression, slides: bool) -> Line:
        gaps = [
            np.abs(_wrap(np.asarray(formula.evaluate(self.values, s)) - self.values[name], slides)) for s in (1.0, -1.0)
        ]
        return Line((Name(name),), (formula,), self._error(name, np.minimum(*gaps), 1.0))

    def _error(self, name: str, gap: Floats, scale: float) -> float:
        error = float(gap.max(initial=0.0))
        if not error <= HALF_DIGITS * max(1.0, scale):
            raise DerivationError("derivation.differs", line=_plain(name), error=error, limit=HALF_DIGITS)
        return error

    def _unknown(self, k: int) -> str:
        joint = self.pattern.joints[k]
        return f"{'d' if self.pattern.prismatic[k] else 'theta'}{(joint if joint >= 0 else k) + 1}"

    def _sense(self, k: int, first: int) -> float:
        return float(np.sign(self.axes[k] @ self.axes[first]))


def between(axis: Expression, u: Expression, v: Expression) -> Expression:
    """The angle of the turn about an axis that brings u to v, as an atan2.

    Args:
        axis: unit vector.
        u, v: vectors; what lies along the axis does not count.
    """
    return function("atan2", axis.dot(u.cross(v)), u.dot(v) - axis.dot(u) * axis.dot(v))


def _wrap(gap: Floats, slides: bool) -> Floats:
    return gap if slides else gap - 2 * np.pi * np.round(gap / (2 * np.pi))


def vector_text(values: Floats) -> str:
    """(x, y, z) with six digits."""
    return "(" + ", ".join(number_text(float(x)) for x in values) + ")"


def number_text(value: float) -> str:
    """Six digits; roundoff is zero."""
    return f"{0.0 if abs(value) < ROUNDOFF else value:.6g}".replace("-", "−")


def _plain(name: str) -> str:
    return name_expression(name).text()


def _solutions(robot: Robot, solve: Callable[[PoseMatrix], Floats], rng: np.random.Generator) -> tuple[Floats, Floats]:
    """(k, n) all solutions of random poses that stay clear of singular ones, and (k, 4, 4) their poses."""
    sliding = np.array([joint.kind.value == "prismatic" for joint in robot.mechanism.coordinates])
    rows: list[Floats] = []
    poses: list[PoseMatrix] = []
    while len(rows) < POSES:
        planted = np.where(sliding, rng.uniform(0.2, 0.6, robot.n), rng.uniform(-np.pi, np.pi, robot.n))
        values = np.linalg.svd(robot.jacobian_body(planted), compute_uv=False)
        if values[-1] > 1e-2 * values[0]:
            T = np.asarray(robot.forward_kinematics(planted))
            rows.append(solve(T))
            poses.append(np.broadcast_to(T, (len(rows[-1]), 4, 4)))
    return np.concatenate(rows), np.concatenate(poses)
