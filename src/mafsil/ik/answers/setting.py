"""An arm as inverse kinematics asks it: limits, closed form, and what does not depend on the pose.

Would the arm that was meant have as many solutions? A description of six digits leaves some counts open.

An arm that differs by e = `DESCRIBED` from the one described has its solutions where the pose differs by about e:

1. two solutions that are d apart at a fold, where the Jacobian's least singular value is about d, merge within d^2 ~ e;
2. a row of the closed form that falls short of the pose by s becomes a solution, or two, within s ~ e;
3. an arm that is near to a simpler structure, with too few joints for its task, has other solutions once it is of it.

Arms without a closed form are looked at by 1 alone, and by how far the nearest pose is where none is reached.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mafsil.algebra.tolerance import DESCRIBED
from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.geometry import rotation
from mafsil.ik.answers.branch import BranchNames
from mafsil.ik.answers.candidate_table import CandidateTable
from mafsil.ik.chain import MovingPart, middle_of, moving_part
from mafsil.ik.numerical.problem import pose_task
from mafsil.ik.result import reach_bound
from mafsil.ik.structure.analysis import Analysis, Task, analysis, structure_in_doubt
from mafsil.ik.tolerances import EXACT_POSE, NEARLY_REACHED
from mafsil.kernels.lazy import lazy
from mafsil.lazy_module import lazily
from mafsil.mechanics.arm_pattern import BENT, CLEAR, NEARLY, ON_LIMIT, SPLIT, Family, candidate, folds, merges_twice
from mafsil.model import JointKind, Mechanism
from mafsil.robot import Robot

if TYPE_CHECKING:
    import mafsil.ik.numerical.problem as numerical_problem
    import mafsil.ik.numerical.search as search
    from mafsil.ik.numerical.search import SearchPlan
    from mafsil.kernels import Kernel
else:
    numerical_problem = lazily("mafsil.ik.numerical.problem")
    search = lazily("mafsil.ik.numerical.search")


MASKS = {"pose": (1, 1, 1, 1, 1, 1), "position": (0, 0, 0, 1, 1, 1), "axis": (1, 1, 0, 1, 1, 1)}
"""Components of the error that each task asks for."""
FAR = 1e50
"""Stands for a limit that is none: compiled code takes finite numbers, and beyond 1e60 looks for overflow, slowly."""


class Quick:
    """The compiled closed form of an arm with the arguments that do not depend on the pose.

    Attributes:
        call: of (T_sd, *preferences, tolerance) to coordinates, details and decision.
        preferences: preferred values, their cosines and sines, limits.
        setting: the arm.
        chosen: decision -> which rows it means, see `rows`.
    """

    __slots__ = ("call", "chosen", "preferences", "setting")

    def __init__(
        self, call: Callable[..., Any], preferences: tuple[JointVector, Floats, Floats, Floats], setting: Setting
    ) -> None:
        self.call, self.preferences, self.setting = call, preferences, setting
        self.chosen: dict[float, slice | NDArray[np.intp]] = {}

    def rows(self, decision: float) -> slice | NDArray[np.intp]:
        """The rows of a clear list: a slice where they follow each other."""
        if (known := self.chosen.get(decision)) is not None:
            return known
        found = bits(int(decision), int(decision).bit_length())
        first, last = found[0], found[-1]
        together = last - first + 1 == len(found)
        self.chosen[float(decision)] = chosen = slice(first, last + 1) if together else np.array(found, dtype=np.intp)
        return chosen


class Setting:
    """What all questions to one arm share.

    Attributes:
        part: the joints that move the frame, among those of the whole robot.
        robot: of those joints alone; its tip is the frame asked for.
        task: what of a pose counts.
        arm: what it was recognised as.
        lower, upper: (n,) limits.
        revolute: (n,) which coordinates are angles.
        middle: (n,) the middle of the limits, zero where one is missing.
        mask: (6,) components of the error that count.
    """

    def __init__(self, part: MovingPart, task: Task) -> None:
        robot = part.robot if part.frame is None else Robot(_with_tip(part.robot.mechanism, part.frame))
        self.part, self.robot = part, robot
        self.task: Task = task
        self.lower, self.upper = robot.limits.lower, robot.limits.upper
        kinds = [joint.kind for joint in robot.mechanism.coordinates]
        self.revolute: NDArray[np.bool_] = np.array([kind is JointKind.REVOLUTE for kind in kinds], dtype=np.bool_)
        self.middle = middle_of(robot)
        self.mask: NDArray[np.bool_] = np.array(MASKS[task], dtype=np.bool_)
        self.bounds = np.clip(self.lower, -FAR, FAR), np.clip(self.upper, -FAR, FAR)
        self.middle_turns = turns_of(self.middle)
        self.nothing: JointVector = np.zeros((0, robot.n))

    @lazy
    def few(self) -> bool:
        """Whether the arm has fewer joints than the task has equations: only least squares meet a rounded pose."""
        return self.robot.n < {"pose": 6, "axis": 5, "position": 3}[self.task]

    def within_limits(self, q: JointVector) -> NDArray[np.bool_]:
        """(k,) which rows are within the limits."""
        inside = (q >= self.lower - ON_LIMIT) & (q <= self.upper + ON_LIMIT)
        return np.asarray(inside.all(axis=-1), dtype=np.bool_)

    @lazy
    def arm(self) -> Analysis:
        """What the arm was recognised as."""
        return analysis(self.robot.mechanism, self.task)

    @lazy
    def branch_names(self) -> BranchNames | None:
        """How the arm's branches are called; None without a closed form."""
        chain, form = self.arm.chain, self.arm.form
        return None if chain is None or form is None else BranchNames(chain, form.pattern)

    @lazy
    def kernel(self) -> Kernel | None:
        """The closed form with its decisions, where it is exact and nothing is locked: its rows are the answer."""
        arm = self.arm
        return arm.form.judged if arm.form is not None and arm.exact and not arm.locked else None

    @lazy
    def quick(self) -> Quick | None:
        """What the shortest way to all solutions of one pose needs; None without such a kernel."""
        kernel = self.kernel
        return None if kernel is None else Quick(kernel.call, (self.middle, self.middle_turns, *self.bounds), self)

    @lazy
    def newton(self) -> SearchPlan:
        """Steps and check of Newton's method for whole poses, without limits, as compiled kernels."""
        task = pose_task("pose", (0.0, 0.0, 1.0), None, CLEAR, None)
        return search.cached_plan(numerical_problem.problem_of(self.robot, None, False), task, 0)

    @lazy
    def quartic(self) -> bool:
        """Whether the closed form solves an equation of fourth degree, whose roots may merge by three or four."""
        form = self.arm.form
        return form is not None and form.pattern.quartic

    @lazy
    def holds_one(self) -> bool:
        """Whether the closed form is exact once one joint is locked, and solves no equation of fourth degree."""
        return len(self.arm.locked) == 1 and self.arm.exact and not self.quartic

    @lazy
    def decisive(self) -> bool:
        """Whether the closed form alone proves that there is no solution: exact, of second degree, no joint locked."""
        return self.arm.exact and not self.quartic and not self.arm.locked

    @lazy
    def candidate(self) -> float:
        """Residual up to which a row of an exact closed form may become a solution by refinement."""
        form = self.arm.form
        return NEARLY_REACHED if form is None else candidate(form.pattern)

    def near_folds(self, details: Floats | CandidateTable) -> NDArray[np.bool_]:
        """(*batch, k) rows that rounding may have moved off: two pairs of roots merge there and split again.

        Args:
            details: of the closed form, by name or as the kernel's (*batch, k, 6).
        """
        known = details if isinstance(details, CandidateTable) else CandidateTable.of(details)
        form = self.arm.form
        if form is None or not folds(form.pattern):
            return np.zeros(known.residual.shape, dtype=np.bool_)
        exact = known.residual <= CLEAR
        off = ~exact & (known.residual <= SPLIT * form.pattern.size)
        code = np.nan_to_num(known.code).astype(np.int64)
        merged = self.merged_twice(code) & (code % 3 == 1)
        beside = np.where(exact, known.margin, np.inf).min(axis=-1, keepdims=True) <= BENT
        nearby = beside & (known.residual <= NEARLY * form.pattern.size)
        return np.asarray(off & (merged | nearby), dtype=np.bool_)

    def merged_twice(self, codes: NDArray[np.int64]) -> NDArray[np.bool_]:
        """(*batch, k) whether two of shoulder, elbow and wrist have branches that are one.

        The code's digits in base three say one where two branches are one.
        """
        if not self._merging:
            return np.zeros(codes.shape, dtype=np.bool_)
        ones = ((codes % 3 == 1).astype(np.int8), codes // 3 % 3 == 1, codes // 9 % 3 == 1)
        return np.asarray(ones[0] + ones[1] + ones[2] > 1, dtype=np.bool_)

    @lazy
    def _merging(self) -> bool:
        """Whether two of shoulder, elbow and wrist may have merged roots at once."""
        form = self.arm.form
        return form is not None and merges_twice(form.pattern)

    @lazy
    def straight(self) -> tuple[float, ...]:
        """Values of the fifth joint that make the sixth axis parallel to the fourth, or to the three parallel ones."""
        assert self.arm.form is not None
        pattern, found = self.arm.form.pattern, list[float]()
        outer, w5, w6 = pattern.axes[3 if pattern.family is Family.SPHERICAL_WRIST else 1], *pattern.axes[4:6]
        for goal in (outer, -outer):
            value = float(np.arctan2(w5 @ np.cross(w6, goal), w6 @ goal - (w5 @ w6) * (w5 @ goal)))
            if np.abs(rotation.exp(w5 * value) @ w6 - goal).max() < EXACT_POSE:
                found.append(value)
        return tuple(found)

    @lazy
    def plain(self) -> bool:
        """Whether rows with branch margins far from zero are distinct and isolated: no revolute joint was added."""
        form = self.arm.form
        return form is not None and form.pattern.plain

    @lazy
    def length(self) -> float:
        """Scale that makes positions comparable with angles: the arm's reach [m]."""
        _, radius = self.reach
        return radius if np.isfinite(radius) and radius > 0 else 1.0

    @lazy
    def reach(self) -> tuple[Floats, float]:
        """Centre and radius of a sphere that the frame cannot leave [m]."""
        return reach_bound(self.robot.mechanism, None)

    @lazy
    def normal(self) -> Floats | None:
        """(3,) the direction to which all revolute axes of a planar arm are parallel and all prismatic normal."""
        chain = self.arm.chain
        if chain is None or not len(chain):
            return None
        revolute = ~np.array(chain.prismatic, dtype=np.bool_)
        if not revolute.any():
            return None
        h: Floats = chain.axes[revolute][0]
        along = np.abs(chain.axes @ h)
        planar = (along[revolute] >= 1.0 - EXACT_POSE).all() and (along[~revolute] <= EXACT_POSE).all()
        return h if planar else None

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
    turns = np.empty((*q.shape, 2))
    np.cos(q, turns[..., 0])
    np.sin(q, turns[..., 1])
    return turns


def bits(code: int, n: int) -> tuple[int, ...]:
    """The coordinates i for which 2^i is part of a sum."""
    return tuple(i for i in range(n) if code >> i & 1)


def require_task(task: object) -> None:
    """Refuse what is no task.

    Raises:
        InputError: the sentence lists the tasks.
    """
    if type(task) is not str or task not in MASKS:
        raise InputError("input.choice", name="task", value=task, known=", ".join(MASKS))


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


MERGING = float(np.sqrt(DESCRIBED))
"""Singular values, relative to the largest, of solutions that rounding may merge: a double root costs the root."""


def folding(setting: Setting, q: JointVector) -> NDArray[np.bool_]:
    """(k,) whether rounding of the description may merge a solution with another, or take it away.

    Args:
        setting: of the arm.
        q: (k, n) solutions.
    """
    values = np.linalg.svd(setting.scaled_jacobians(q), compute_uv=False)
    least = values[:, min(int(setting.mask.sum()), setting.robot.n) - 1]
    return np.asarray(least <= MERGING * np.maximum(values[:, 0], LEAST_DIVISOR), dtype=np.bool_)


def nearly_there(setting: Setting, T: PoseMatrix, q0: JointVector) -> NDArray[np.bool_]:
    """(k,) whether a row of the closed form falls short of a pose by no more than rounding explains.

    Args:
        setting: of the arm.
        T: (k, 4, 4) poses.
        q0: (n,) values that free and locked joints take.
    """
    form = setting.arm.form
    if form is None:
        return np.zeros(len(T), dtype=np.bool_)
    details = CandidateTable.of(form.labelled(T, q0, turns_of(q0), *setting.bounds)[1])
    missing = np.nan_to_num(details.subproblem_residual, nan=np.inf)
    explained = (DESCRIBED + form.pattern.defect) * max(1.0, form.pattern.size)
    return np.asarray(((missing > CLEAR) & (missing <= explained)).any(axis=-1), dtype=np.bool_)


def structure_decides(setting: Setting) -> bool:
    """Whether the count depends on whether the arm is of a simpler structure, which rounding leaves open."""
    open_structure = setting.few or bool(setting.arm.locked) or setting.arm.form is None
    return open_structure and structure_in_doubt(setting.robot, setting.task)
