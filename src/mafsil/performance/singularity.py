"""Singular configurations: whether, what is lost, which joints depend on each other, and why."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, JointVector
from mafsil.messages import say
from mafsil.model import JointKind
from mafsil.performance.axis_cases import Axes, Cause, causes
from mafsil.performance.lost_motions import ScrewReading, twist_reading, wrench_reading
from mafsil.performance.scaling import (
    TOLERANCE,
    Scaled,
    random_configurations,
    rank_of,
    require_one,
    scaled_jacobian,
    sliding_joints,
)
from mafsil.performance.tasks import Task, task_rows
from mafsil.robot import Robot


def singular_values(robot: Robot, q: ArrayLike, *, task: Task = "pose", length: float | None = None) -> Floats:
    """Singular values of the Jacobian without units, largest first.

    For the full pose the linear part is taken at the point nearest to all axes, and the length likewise: the values
    depend on neither the base frame nor the tool. For other tasks it is taken at the tip.

    Args:
        robot: the arm.
        q: (*batch, n) joint coordinates [rad | m].
        task: rows that count.
        length: [m] that divides translations; the arm's characteristic length if None.

    Returns:
        (*batch, min(m, n)).
    """
    values: Any = np.linalg.svd(_scaled(robot, q, task, length).J, compute_uv=False)
    return values


def rank(
    robot: Robot, q: ArrayLike, *, task: Task = "pose", length: float | None = None, tolerance: float = TOLERANCE
) -> NDArray[np.int64]:
    """(*batch) rank of the Jacobian; arguments as `singular_values`, tolerance relative to the largest value."""
    return rank_of(singular_values(robot, q, task=task, length=length), tolerance)


def generic_rank(robot: Robot, *, task: Task = "pose") -> int:
    """The rank that almost all configurations have.

    Args:
        robot: the arm.
        task: rows that count.
    """
    return _generic(robot, task_rows(task))


@lru_cache(maxsize=64)
def _generic(robot: Robot, rows: tuple[int, ...]) -> int:
    return int(rank(robot, random_configurations(robot, 32, limited=False), task=rows).max(initial=0))


def is_singular(
    robot: Robot, q: ArrayLike, *, task: Task = "pose", length: float | None = None, tolerance: float = TOLERANCE
) -> NDArray[np.bool_]:
    """(*batch) whether the rank is below that of almost all configurations; arguments as `rank`."""
    return rank(robot, q, task=task, length=length, tolerance=tolerance) < generic_rank(robot, task=task)


@dataclass(frozen=True, eq=False)
class Singularity:
    """What one configuration can and cannot do.

    Attributes:
        robot: name.
        q: (n,) the configuration [rad | m].
        rank, generic_rank: of the Jacobian here, and almost everywhere.
        singular_values: without units, largest first.
        length: [m] that divided translations.
        tolerance: of the rank.
        null_rates: (n - rank, n) independent joint rates that do not move the tip (task).
        lost_twists: (generic_rank - rank, 6) twists (omega, v) in {s} that are possible nearby and not here.
        wrenches: (m - rank, 6) wrenches (m, f) in {s} that the structure carries without any joint effort.
        causes: dependent sets of axes with their geometry; empty where no rank is lost, or for part of a pose.
    """

    robot: str
    q: JointVector
    rank: int
    generic_rank: int
    singular_values: Floats
    length: float
    tolerance: float
    null_rates: Floats
    lost_twists: Floats
    wrenches: Floats
    causes: tuple[Cause, ...]

    @property
    def singular(self) -> bool:
        """Whether rank is lost."""
        return self.rank < self.generic_rank

    @property
    def cases(self) -> tuple[str, ...]:
        """The five cases that hold, as `I (joint2, joint6)`."""
        return tuple(f"{cause.number} ({', '.join(cause.names)})" for cause in self.causes if cause.number)

    @property
    def lost_screws(self) -> tuple[ScrewReading, ...]:
        """The lost twists as axis, point and pitch."""
        return tuple(twist_reading(V, length=self.length) for V in self.lost_twists)

    @property
    def reciprocal_screws(self) -> tuple[ScrewReading, ...]:
        """The carried wrenches as lines of action."""
        return tuple(wrench_reading(F, length=self.length) for F in self.wrenches)

    def explain(self, language: str | None = None) -> str:
        """Rank, causes, lost motions, carried wrenches, in sentences."""
        facts = {"robot": self.robot, "rank": self.rank, "generic": self.generic_rank, "tolerance": self.tolerance}
        if not self.singular:
            ratio = float(self.singular_values[self.rank - 1] / self.singular_values[0]) if self.rank else 0.0
            return say("performance.regular", language=language, ratio=ratio, **facts)
        lines = [say("performance.singular", language=language, **facts)]
        lines += [_cause_line(cause, language) for cause in self.causes]
        lines += [screw.sentence("lost", language) for screw in self.lost_screws]
        lines += [screw.sentence("carried", language) for screw in self.reciprocal_screws]
        return "\n".join(lines)


def _cause_line(cause: Cause, language: str | None) -> str:
    sentence = cause.sentence(language)
    if not cause.number:
        return sentence
    return say("performance.case_number", language=language, number=cause.number, sentence=sentence)


def singularity(
    robot: Robot, q: ArrayLike, *, task: Task = "pose", length: float | None = None, tolerance: float = TOLERANCE
) -> Singularity:
    """Look closely at one configuration: `singularity(robot, q).explain()`.

    Args:
        robot: the arm.
        q: (n,) joint coordinates [rad | m].
        task: rows that count.
        length: [m] that divides translations; the arm's characteristic length if None.
        tolerance: singular values below this share of the largest count as zero.

    Raises:
        InputError: a batch (use `is_singular`), or q of a wrong shape.

    Reference: Lynch & Park, Modern Robotics, sec. 5.3; lost directions and reciprocal wrenches: Hunt, Kinematic
    Geometry of Mechanisms, 1978.
    """
    configuration = require_one("q", q, robot.n)
    scaled = _scaled(robot, configuration, task, length)
    U, s, Vt = np.linalg.svd(scaled.J)
    found, generic = int(rank_of(s, tolerance)), generic_rank(robot, task=task)
    null, left = Vt[found:], U[:, found:]
    lost = (
        left if generic == len(scaled.rows) else _reachable(robot, configuration, scaled, null, left, generic - found)
    )
    nullity = robot.n - found
    full = len(scaled.rows) == 6 and found < generic
    return Singularity(
        robot.name,
        configuration,
        found,
        generic,
        s,
        scaled.length,
        tolerance,
        null * scaled.columns,
        _twists(scaled, lost),
        wrenches_of(scaled, left),
        causes(_axes(robot, scaled, tolerance), nullity) if full else (),
    )


def _scaled(robot: Robot, q: ArrayLike, task: Task, length: float | None) -> Scaled:
    at: Literal["tip", "axes"] = "axes" if len(task_rows(task)) == 6 else "tip"
    return scaled_jacobian(robot, q, task=task, length=length, at=at)


def _axes(robot: Robot, scaled: Scaled, tolerance: float) -> Axes:
    plain = [JointKind.REVOLUTE, JointKind.PRISMATIC]
    followed = {joint.mimic.leader for joint in robot.mechanism.joints if joint.mimic is not None}
    simple = [j.kind in plain and j.name not in followed for j in robot.mechanism.coordinates]
    sliding = sliding_joints(robot)
    return Axes(
        scaled.J,
        [bool(s and ok) for s, ok in zip(sliding, simple, strict=True)],
        [bool(ok and not s) for s, ok in zip(sliding, simple, strict=True)],
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
    step = 1e-4
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
    """(k, 6) twists in {s} of directions (m, k) without units."""
    V = np.zeros((directions.shape[1], 6))
    V[:, list(scaled.rows)] = directions.T / scaled.row_factors
    V = _tidy(V)
    V[:, 3:] -= np.cross(V[:, :3], scaled.point)
    return V


def wrenches_of(scaled: Scaled, directions: Floats) -> Floats:
    """(k, 6) wrenches in {s} of covectors (m, k) without units."""
    F = np.zeros((directions.shape[1], 6))
    F[:, list(scaled.rows)] = directions.T * scaled.row_factors
    F = _tidy(F)
    F[:, :3] += np.cross(scaled.point, F[:, 3:])
    return F


def _tidy(rows: Floats) -> Floats:
    """Each row with its largest entry one, its sign fixed."""
    if not rows.size:
        return rows
    largest = np.take_along_axis(rows, np.abs(rows).argmax(axis=1)[:, None], axis=1)
    return rows / largest
