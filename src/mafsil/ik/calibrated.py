"""Almost ideal arms: which branch of the ideal arm each solution continues, and which are lost or gained at folds.

A measured arm is off the shape that gave it a closed form by millimetres. Its solutions are those of the ideal arm
moved a little, except near folds, where two branches meet: there a pair may vanish or appear.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Answer
from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.errors import InputError
from mafsil.geometry import pose
from mafsil.ik.answers.candidate_table import CandidateTable
from mafsil.ik.answers.setting import setting
from mafsil.ik.answers.solution_set import SolutionSet
from mafsil.ik.inverse import inverse_kinematics
from mafsil.ik.refine import distinct, refine_rows
from mafsil.ik.result import IKStatus
from mafsil.ik.structure.analysis import analysis
from mafsil.ik.tolerances import IDEAL_QUARTIC_REACHED, IDEAL_REACHED, NEARLY_REACHED, SHORTEST
from mafsil.messages import say
from mafsil.model.loading import RobotLike
from mafsil.robot import Robot, as_robot

LEAP = 0.3
"""Joint motion of one step beyond which another branch may have been caught [rad | m]."""


@dataclass(frozen=True, eq=False, repr=False)
class Continuation(Answer, entries="answer"):
    """Solutions of an arm by the branches of the nearest ideal arm; true if one is within the limits.

    Attributes:
        answer: solutions of the arm itself; `complete` where elimination proves that there are no others.
        ideal: (b, n) branches of the ideal arm; NaN where it does not reach the pose on that branch.
        solution: (b,) index of the solution that continues a branch; -1 if lost, or not there from the start.
        moved: (b,) largest joint motion from the ideal branch to the solution; NaN without one [rad | m].
        lost: branches of the ideal arm that end before the measured arm: they met another at a fold.
        gained: solutions that continue no branch of the ideal arm.
        defect: how far the arm is from the ideal one [rad, and m relative to its size].
    """

    answer: SolutionSet
    ideal: JointVector
    solution: NDArray[np.int64]
    moved: Floats
    lost: tuple[int, ...]
    gained: tuple[int, ...]
    defect: float

    @property
    def status(self) -> IKStatus:
        """What can be said about the arm's own solutions."""
        return self.answer.status

    def __bool__(self) -> bool:
        return bool(self.answer)

    def to_dict(self) -> dict[str, Any]:
        """Plain data; arrays are those of the answer."""
        kept = {"ideal": self.ideal, "solution": self.solution, "moved": self.moved}
        return {**self.answer.to_dict(), **kept, "lost": self.lost, "gained": self.gained, "defect": self.defect}

    def explain(self, language: str | None = None) -> str:
        """In sentences: how many branches go on, which are lost or gained, and the answer's own words."""
        kept = int((self.solution >= 0).sum())
        lines = [say("calibrated.kept", language=language, kept=kept, defect=self.defect)]
        if self.lost:
            lines.append(say("calibrated.lost", language=language, branches=_list(self.lost)))
        if self.gained:
            lines.append(say("calibrated.gained", language=language, solutions=_list(self.gained)))
        return "\n".join([*lines, self.answer.explain(language)])


def continued_branches(robot: RobotLike, T_sd: ArrayLike) -> Continuation:
    """The solutions of one pose, each with the branch of the nearest ideal arm that it continues.

    Args:
        robot: of up to six joints that move its tip, of a shape that has a closed form or nearly so. The answer has
            these joints only.
        T_sd: (4, 4) requested pose in {s}.

    Raises:
        InputError: no such arm, a wrong shape, or no pose.
    """
    shared = setting(as_robot(robot), None, "pose")
    robot = shared.robot
    answer, arm = inverse_kinematics(robot, T_sd), analysis(robot.mechanism)
    if arm.form is None or arm.locked:
        raise InputError("calibrated.no_ideal", joints=robot.n)
    if not isinstance(answer, SolutionSet):
        raise InputError("input.shape", name="T_sd", expected="(4, 4)", got=np.shape(T_sd), hint="")
    T = np.asarray(T_sd, dtype=np.float64)
    q, details, _ = arm.form.labelled(T, shared.middle, shared.middle_turns, *shared.bounds)
    reached = IDEAL_QUARTIC_REACHED if shared.quartic else IDEAL_REACHED
    exists = np.isfinite(q).all(axis=-1) & (CandidateTable.of(details).subproblem_residual <= reached)
    ideal = np.where(exists[:, None], q, np.nan)
    rows = np.flatnonzero(exists)
    rows = rows[distinct(ideal[rows], shared.revolute)]
    solution, moved = np.full(len(ideal), -1), np.full(len(ideal), np.nan)
    ends = [_continue(robot, ideal[row], T) for row in rows]
    order = np.argsort([way for _, way in ends])
    for i in map(int, order):
        if not len(answer) or not np.isfinite(ends[i][0]).all():
            continue
        away = _apart(answer.q, ends[i][0], shared.revolute)
        best = int(away.argmin())
        if away[best] < NEARLY_REACHED and best not in solution:
            solution[rows[i]] = best
            moved[rows[i]] = _apart(answer.q[best], ideal[rows[i]], shared.revolute)
    lost = tuple(int(row) for row in rows if solution[row] < 0)
    gained = tuple(k for k in range(len(answer)) if k not in solution)
    return Continuation(answer, ideal, solution, moved, lost, gained, float(arm.form.pattern.defect))


def _continue(robot: Robot, q: JointVector, T: PoseMatrix) -> tuple[JointVector, float]:
    """Where the measured configuration q goes while its pose moves to T, and by how much; NaN where it ends on the way.

    The pose moves along a screw, by steps that Newton's method can follow.
    """
    start = robot.forward_kinematics(q)
    V, s, step = pose.error(start, T), 0.0, 0.25
    everything, here = np.ones(6, dtype=np.bool_), q
    while s < 1.0:
        goal = start @ pose.exp(V * min(1.0, s + step))
        trial, residual = refine_rows(robot, here[None], goal, everything)
        if residual[0] <= IDEAL_REACHED and np.abs(trial[0] - here).max() <= LEAP:
            here, s, step = trial[0], min(1.0, s + step), 2 * step
        elif step > SHORTEST:
            step /= 4
        else:
            return np.full(len(q), np.nan), np.inf
    return here, float(np.abs(here - q).max())


def _apart(q: JointVector, other: JointVector, revolute: NDArray[np.bool_]) -> Floats:
    d = q - other
    return np.abs(np.where(revolute, (d + np.pi) % (2 * np.pi) - np.pi, d)).max(axis=-1)


def _list(numbers: tuple[int, ...]) -> str:
    return ", ".join(str(k + 1) for k in numbers)
