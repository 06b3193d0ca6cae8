"""Singular configurations: whether, what is lost, which joints depend on each other, and why."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, JointVector, not_negative
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.messages import say
from mafsil.model import JointKind
from mafsil.performance.singularities.axis_cases import Axes, SingularityCause, causes
from mafsil.performance.singularities.determinant import vanishing_factors
from mafsil.performance.singularities.ranks import (
    ResolvedTask,
    generic_rank_of,
    resolved_task,
    scaled_for_rank,
)
from mafsil.performance.singularities.screw_parameters import (
    ScrewParameters,
    canonical_system,
    twist_screw,
    vector_text,
    wrench_screw,
)
from mafsil.performance.tolerances import COARSEST, SLOPE_STEP
from mafsil.performance.velocity.scaling import (
    TOLERANCE,
    Scaled,
    Task,
    prismatic_joints,
    rank_in_doubt,
    rank_of,
    require_one,
    scaled_jacobian,
)
from mafsil.robot import Robot, of_robot
from mafsil.robot.degrees import takes_degrees


class SingularityStatus(Status):
    """Whether a configuration is singular, the question that succeeds with yes."""

    SINGULAR = ("performance.singular", True)
    """Its rank is lower than that of almost all others."""
    DEFICIENT = ("performance.deficient", True)
    """The arm has no configuration of full rank, and this one is like almost all others."""
    REGULAR = ("performance.regular", False)


@dataclass(frozen=True, eq=False, repr=False)
class Singularity(
    Answer,
    data="singular robot q task rank generic_rank full_rank singular_values length in_doubt cases "
    "null_rates lost_twists carried_wrenches=wrenches",
):
    """The singularity of one configuration; true if it is singular.

    Attributes:
        robot: name.
        q: (n,) the configuration [rad | m].
        task: rows that count.
        rank, generic_rank, full_rank: of the Jacobian here, almost everywhere, and the most that so many joints and
            rows can have. Where the generic rank is below the full one, the arm is singular at every configuration.
        singular_values: without units, largest first.
        length: [m] that divided translations.
        tolerance: of the rank.
        null_rates: (n - rank, n) independent joint rates that do not move the tip (task).
        lost_twists: (generic_rank - rank, 6) twists (omega, v) in {s} that are possible nearby and not here.
        wrenches: (m - rank, 6) wrenches (m, f) in {s} that the structure carries without any joint effort.
        causes: dependent sets of axes with their geometry, for part of a pose the factors of the determinant that
            vanish; empty where the rank is full.
    """

    robot: str
    q: JointVector
    task: Task
    rank: int
    generic_rank: int
    full_rank: int
    singular_values: Floats
    length: float
    tolerance: float
    null_rates: Floats
    lost_twists: Floats
    wrenches: Floats
    causes: tuple[SingularityCause, ...]

    @property
    def singular(self) -> bool:
        """Whether the rank is not full."""
        return self.rank < self.full_rank

    @property
    def in_doubt(self) -> bool:
        """Whether a description of six digits leaves the rank open: a singular value is that near to the tolerance."""
        return bool(rank_in_doubt(self.singular_values, self.tolerance))

    @property
    def status(self) -> SingularityStatus:
        """Whether this configuration is singular, the arm at all of them, or neither."""
        if self.drop > 0:
            return SingularityStatus.SINGULAR
        return SingularityStatus.DEFICIENT if self.deficient else SingularityStatus.REGULAR

    @property
    def drop(self) -> int:
        """How much of the rank that almost all configurations have is lost here."""
        return self.generic_rank - self.rank

    @property
    def deficient(self) -> bool:
        """Whether the arm never reaches full rank: not this configuration is to blame but how the arm is built."""
        return self.generic_rank < self.full_rank

    @property
    def cases(self) -> tuple[str, ...]:
        """The five cases that hold, as `I (joint2, joint6)`."""
        return tuple(f"{cause.number} ({', '.join(cause.names)})" for cause in self.causes if cause.number)

    @property
    def lost_screws(self) -> tuple[ScrewParameters, ...]:
        """The lost twists as axis, point and pitch."""
        return tuple(twist_screw(V, length=self.length) for V in self.lost_twists)

    @property
    def reciprocal_screws(self) -> tuple[ScrewParameters, ...]:
        """The carried wrenches as lines of action."""
        return tuple(wrench_screw(F, length=self.length) for F in self.wrenches)

    def explain(self, language: str | None = None) -> str:
        """Rank, causes, lost motions, carried wrenches, in sentences."""
        details = {
            "robot": self.robot,
            "rank": self.rank,
            "generic": self.generic_rank,
            "full": self.full_rank,
            "task": self.task if isinstance(self.task, str) else vector_text(np.array(self.task, float)),
            "tolerance": self.tolerance,
        }
        if not self.singular:
            ratio = float(self.singular_values[self.rank - 1] / self.singular_values[0]) if self.rank else 0.0
            regular = say("performance.regular", language=language, ratio=ratio, **details)
            return "\n".join([regular, *self._doubt(language)])
        lines = [say("performance.deficient", language=language, **details)] if self.deficient else []
        lines += [say("performance.singular", language=language, **details)] if self.drop > 0 else []
        lines += [_cause_line(cause, language) for cause in self.causes]
        lines += [screw.sentence("lost", language) for screw in self.lost_screws]
        lines += [screw.sentence("carried", language) for screw in self.reciprocal_screws]
        return "\n".join([*lines, *self._doubt(language)])

    def _doubt(self, language: str | None) -> list[str]:
        """That rounding may have decided, where it may."""
        if not self.in_doubt:
            return []
        ratios = self.singular_values / self.singular_values[0]
        nearest = float(ratios[np.argmin(np.abs(np.log(np.maximum(ratios, LEAST_DIVISOR) / self.tolerance)))])
        return [say("performance.rank_in_doubt", language=language, ratio=nearest, tolerance=self.tolerance)]

    def to_dict(self) -> dict[str, Any]:
        """Plain data; arrays are those of the answer."""
        return Answer.to_dict(self) | {"causes": [cause.sentence() for cause in self.causes]}


def _cause_line(cause: SingularityCause, language: str | None) -> str:
    sentence = cause.sentence(language)
    if not cause.number:
        return sentence
    return say("performance.case_number", language=language, number=cause.number, sentence=sentence)


@of_robot
@takes_degrees("q")
def singularity(
    robot: Robot,
    q: ArrayLike,
    *,
    task: Task | None = None,
    length: float | None = None,
    tolerance: float = TOLERANCE,
    degrees: bool = False,
) -> Singularity:
    """The singularity of one configuration: rank, cause, lost motions; `singularity(robot, q).explain()`.

    Args:
        robot: the arm.
        q: (n,) joint coordinates [rad | m].
        task: rows that count; the arm's `default_task` if None.
        length: [m] that divides translations; the arm's characteristic length if None.
        tolerance: singular values below this share of the largest count as zero.
        degrees: the angles in q are in degrees.

    Raises:
        InputError: a batch (use `is_singular`), or q of a wrong shape.

    Reference: Lynch & Park, Modern Robotics, sec. 5.3; lost directions and reciprocal wrenches: Hunt, Kinematic
    Geometry of Mechanisms, 1978.
    """
    tolerance = not_negative("tolerance", tolerance, most=COARSEST)
    configuration = require_one("q", q, robot.n)
    resolved = resolved_task(robot, task)
    scaled = scaled_for_rank(robot, configuration, resolved.rows, length)
    U, s, Vt = np.linalg.svd(scaled.J)
    found, generic = int(rank_of(s, tolerance)), generic_rank_of(robot, resolved.rows)
    null, left = Vt[found:], U[:, found:]
    every = generic == len(scaled.rows)
    lost = left if every else _reachable(robot, configuration, scaled, null, left, generic - found)
    return Singularity(
        robot.name,
        configuration,
        resolved.task,
        found,
        generic,
        resolved.full_rank,
        s,
        scaled.length,
        tolerance,
        null * scaled.columns,
        _twists(scaled, lost),
        wrenches_of(scaled, left),
        _causes(robot, scaled, resolved, found, tolerance) if found < resolved.full_rank else (),
    )


def _causes(
    robot: Robot, scaled: Scaled, resolved: ResolvedTask, found: int, tolerance: float
) -> tuple[SingularityCause, ...]:
    """Dependent axes for the whole pose; for a part of it the factors of the determinant that vanish."""
    if len(scaled.rows) == 6:
        return causes(_axes(robot, scaled, tolerance), robot.n - found)
    if not isinstance(resolved.task, str) or len(resolved.rows) != robot.n:
        return ()
    try:
        return vanishing_factors(robot, resolved.task, scaled.q, tolerance)
    except InputError:
        return ()


def _axes(robot: Robot, scaled: Scaled, tolerance: float) -> Axes:
    plain = [JointKind.REVOLUTE, JointKind.PRISMATIC]
    followed = {joint.mimic.leader for joint in robot.mechanism.joints if joint.mimic is not None}
    simple = [j.kind in plain and j.name not in followed for j in robot.mechanism.coordinates]
    prismatic = prismatic_joints(robot)
    return Axes(
        scaled.J,
        [bool(s and ok) for s, ok in zip(prismatic, simple, strict=True)],
        [bool(ok and not s) for s, ok in zip(prismatic, simple, strict=True)],
        robot.joint_names,
        scaled.point,
        scaled.length,
        tolerance,
    )


def _reachable(robot: Robot, q: Floats, scaled: Scaled, null: Floats, left: Floats, count: int) -> Floats:
    """Of the directions that are missing here, the `count` ones that a small motion brings back.

    To first order these are the directions left' dJ(qd) n for all rates qd and all n that move nothing.
    """
    if count <= 0:
        return left[:, :0]
    step = SLOPE_STEP
    nearby = q + step * np.concatenate([np.eye(robot.n), -np.eye(robot.n)])
    factors = scaled.row_factors[:, None] * scaled.columns
    J = robot.jacobian_space(nearby)
    if len(scaled.rows) == 6:
        v = J[:, 3:] + np.cross(J[:, :3], scaled.point[:, None], axis=-2)
        J = np.concatenate([J[:, :3], v], axis=1)
    else:
        J = scaled_jacobian(robot, nearby, task=scaled.rows, length=scaled.length).J / factors
    change = left.T @ (J * factors) @ null.T
    U, _, _ = np.linalg.svd(np.concatenate(list(change), axis=1))
    return left @ U[:, :count]


def _twists(scaled: Scaled, directions: Floats) -> Floats:
    """(k, 6) twists in {s} of directions (m, k) without units, their system in its canonical basis."""
    V = np.zeros((directions.shape[1], 6))
    V[:, list(scaled.rows)] = directions.T
    omega, v = canonical_system(V[:, :3], V[:, 3:])
    V = _tidy(np.concatenate([omega, v * scaled.length], axis=1))
    V[:, 3:] -= np.cross(V[:, :3], scaled.point)
    return V


def wrenches_of(scaled: Scaled, directions: Floats) -> Floats:
    """(k, 6) wrenches in {s} of covectors (m, k) without units, their system in its canonical basis."""
    F = np.zeros((directions.shape[1], 6))
    F[:, list(scaled.rows)] = directions.T
    f, m = canonical_system(F[:, 3:], F[:, :3])
    F = _tidy(np.concatenate([m, f / scaled.length], axis=1))
    F[:, :3] += np.cross(scaled.point, F[:, 3:])
    return F


def _tidy(rows: Floats) -> Floats:
    """Each row with its largest entry one, its sign fixed."""
    if not rows.size:
        return rows
    largest = np.take_along_axis(rows, np.abs(rows).argmax(axis=1)[:, None], axis=1)
    return rows / largest
