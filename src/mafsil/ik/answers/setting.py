"""An arm as inverse kinematics asks it: limits, closed form, and what does not depend on the pose."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector
from mafsil.ik.analysis import Analysis, Task, analysis
from mafsil.ik.moving_part import MovingPart, middle_of, moving_part
from mafsil.ik.numerical.problem import problem_of
from mafsil.ik.numerical.search import Plan, cached_plan
from mafsil.ik.numerical.task import pose_task
from mafsil.ik.problem import reach_bound
from mafsil.kernels import Kernel
from mafsil.kernels.lazy import lazy
from mafsil.mechanics.arm_pattern import Family, PointRoad
from mafsil.model import JointKind, Mechanism
from mafsil.robot import Robot

MASKS = {"pose": (1, 1, 1, 1, 1, 1), "position": (0, 0, 0, 1, 1, 1), "axis": (1, 1, 0, 1, 1, 1)}
"""Components of the error that each task asks for."""

SPLIT = 0.5
"""Residual, in units of the arm, up to which a row with four merged roots may become a solution by refinement.

A merged shoulder lets a straight wrist seem bent, and the turn of its last link is then anything.
"""

CLEAR = 1e-11
"""Residual below which a row of the closed form needs no refinement."""

NEARLY, BENT = 1e-3, 1e-2
"""Residual up to which a row may become a solution by refinement where a solution's mark is that small."""

FAR = 1e300
"""Stands for a limit that is none: compiled code takes finite numbers."""


class Setting:
    """What all questions to one arm share.

    Attributes:
        part: the joints that move the frame, among those of the whole robot.
        robot: of those joints alone; its tip is the frame asked for.
        task: what of a pose counts.
        arm: what it was recognised as.
        lower, upper: (n,) limits.
        turning: (n,) which coordinates are angles.
        middle: (n,) the middle of the limits, zero where one is missing.
        mask: (6,) components of the error that count.
    """

    def __init__(self, part: MovingPart, task: Task) -> None:
        robot = part.robot if part.frame is None else Robot(_with_tip(part.robot.mechanism, part.frame))
        self.part, self.robot = part, robot
        self.task: Task = task
        self.lower, self.upper = robot.limits.lower, robot.limits.upper
        kinds = [joint.kind for joint in robot.mechanism.coordinates]
        self.turning: NDArray[np.bool_] = np.array([kind is JointKind.REVOLUTE for kind in kinds], dtype=np.bool_)
        self.middle = middle_of(robot)
        self.mask: NDArray[np.bool_] = np.array(MASKS[task], dtype=np.bool_)
        self.bounds = np.clip(self.lower, -FAR, FAR), np.clip(self.upper, -FAR, FAR)
        self.middle_turns = turns_of(self.middle)
        self.nothing: JointVector = np.zeros((0, robot.n))

    @lazy
    def few(self) -> bool:
        """Whether the arm has fewer joints than the task has equations: only least squares meet a rounded pose."""
        return self.robot.n < {"pose": 6, "axis": 5, "position": 3}[self.task]

    def allowed(self, q: JointVector) -> NDArray[np.bool_]:
        """(k,) which rows are within the limits."""
        inside = (q >= self.lower - 1e-12) & (q <= self.upper + 1e-12)
        return np.asarray(inside.all(axis=-1), dtype=np.bool_)

    @lazy
    def arm(self) -> Analysis:
        """What the arm was recognised as."""
        return analysis(self.robot.mechanism, self.task)

    @lazy
    def kernel(self) -> Kernel | None:
        """The labelled closed form, where it is exact and nothing is held: its rows are the answer."""
        arm = self.arm
        return arm.form.labelled if arm.form is not None and arm.exact and not arm.held else None

    @lazy
    def newton(self) -> Plan:
        """Steps and check of Newton's method for whole poses, without limits, as compiled kernels."""
        task = pose_task("pose", (0.0, 0.0, 1.0), None, CLEAR, None)
        return cached_plan(problem_of(self.robot, None, False), task, 0)

    @lazy
    def quartic(self) -> bool:
        """Whether the closed form solves an equation of fourth degree, whose roots may merge by three or four."""
        form = self.arm.form
        return form is not None and form.pattern.quartic

    @lazy
    def holds_one(self) -> bool:
        """Whether the closed form is exact once one joint is held, and solves no equation of fourth degree."""
        return len(self.arm.held) == 1 and self.arm.exact and not self.quartic

    @lazy
    def decisive(self) -> bool:
        """Whether the closed form alone proves that a pose has no solution: exact, of second degree, no joint held."""
        return self.arm.exact and not self.quartic and not self.arm.held

    @lazy
    def candidate(self) -> float:
        """Residual up to which a row of an exact closed form may become a solution by refinement.

        Rounding splits merged roots: two by its square root, four by its fourth root.
        """
        return 1e-2 if self.quartic else 1e-5

    def folded(self, facts: Floats) -> NDArray[np.bool_]:
        """(*batch, k) rows that rounding may have moved off: two pairs of roots merge there and split again.

        Args:
            facts: (*batch, k, 6) of the closed form.
        """
        residual = facts[..., 0]
        form = self.arm.form
        if form is None or form.pattern.family not in (Family.SPHERICAL_WRIST, Family.THREE_PARALLEL):
            return np.zeros(residual.shape, dtype=np.bool_)
        found = np.asarray((residual > CLEAR) & (residual <= SPLIT * form.pattern.size), dtype=np.bool_)
        where = found.nonzero()
        code = np.nan_to_num(facts[..., 3][where]).astype(np.int64)
        merged = self.merged_twice(code) & (code % 3 == 1)
        beside = residual[where] <= NEARLY * form.pattern.size
        others = facts[tuple(index[beside] for index in where[:-1])]
        beside[beside] = np.where(others[..., 0] <= CLEAR, others[..., 4], np.inf).min(axis=-1) <= BENT
        found[where] = merged | beside
        return found

    def merged_twice(self, codes: NDArray[np.int64]) -> NDArray[np.bool_]:
        """(*batch, k) whether two of shoulder, elbow and wrist have branches that are one.

        The code's digits in base three say one where two branches are one.
        """
        form = self.arm.form
        if form is None or form.pattern.family not in (Family.SPHERICAL_WRIST, Family.THREE_PARALLEL):
            return np.zeros(codes.shape, dtype=np.bool_)
        if not any(j >= 0 and not slides for j, slides in zip(form.pattern.joints, form.pattern.slides, strict=True)):
            # Slides alone are linear: nothing merges.
            return np.zeros(codes.shape, dtype=np.bool_)
        digits = codes[..., None] // np.array([1, 3, 9]) % 3
        return np.asarray((digits == 1).sum(axis=-1) > 1, dtype=np.bool_)

    @lazy
    def plain(self) -> bool:
        """Whether rows with marks far from zero are distinct and isolated: no turning joint was added."""
        form = self.arm.form
        if form is None or (form.pattern.road is PointRoad.QUARTIC and any(form.pattern.slides[:3])):
            # Where the equation is of lower degree, the table repeats roots.
            return False
        return all(j >= 0 or slides for j, slides in zip(form.pattern.joints, form.pattern.slides, strict=True))

    @lazy
    def length(self) -> float:
        """Scale that makes positions comparable with angles: the arm's reach [m]."""
        _, radius = reach_bound(self.robot.mechanism, None)
        return radius if np.isfinite(radius) and radius > 0 else 1.0

    def scaled_jacobians(self, q: JointVector) -> Floats:
        """(k, 6, n) body Jacobians of the task, lengths in units of the reach."""
        if not len(q):
            return np.zeros((0, 6, self.robot.n))
        return self.robot.jacobian_body(q) * self._scale[:, None]

    def scaled_jacobian_rate(self, q: JointVector, qd: JointVector) -> Floats:
        """(6, n) how the body Jacobian of the task changes with the joints at rates qd, lengths as above."""
        return self.robot.jacobian_body_rate(q, qd) * self._scale[:, None]

    @lazy
    def _scale(self) -> Floats:
        return np.where(self.mask, np.repeat([1.0, 1.0 / self.length], 3), 0.0)


def turns_of(q: JointVector) -> Floats:
    """(*batch, n, 2) cosines and sines."""
    return np.stack([np.cos(q), np.sin(q)], axis=-1)


@lru_cache(maxsize=128)
def setting(robot: Robot, frame: str | None, task: Task) -> Setting:
    """What questions to a robot share; made once.

    Args:
        robot: any arm.
        frame: name of a link; the tip if None.
        task: `pose`, `position` or `axis`.
    """
    return Setting(moving_part(robot, frame), task)


@lru_cache(maxsize=64)
def _with_tip(mechanism: Mechanism, frame: str) -> Mechanism:
    return mechanism.with_tip(frame)
