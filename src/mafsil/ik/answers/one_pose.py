"""The answer to one pose: the rows of its closed form where they decide, else with as much care as it needs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.ik.answers.candidate_table import CandidateTable, Decision
from mafsil.ik.answers.lists import SAME, complete, refined_lists
from mafsil.ik.answers.question import Question
from mafsil.ik.answers.setting import Setting, turns_of
from mafsil.ik.answers.solution_set import SolutionSet
from mafsil.ik.problem import clean_poses, printed_pose
from mafsil.ik.redundant.parametric_form import has_redundant_joints
from mafsil.ik.tolerances import REACHED
from mafsil.ik.winding import TURN
from mafsil.lazy_module import lazily
from mafsil.mechanics.closed_form.thresholds import APART

if TYPE_CHECKING:
    import mafsil.ik.answers.redundant_single as redundant_single
    import mafsil.ik.redundant.at_parameter as at_parameter
else:
    at_parameter = lazily("mafsil.ik.redundant.at_parameter")
    redundant_single = lazily("mafsil.ik.answers.redundant_single")

POSE = (4, 4)


def one_pose(
    setting: Setting, T: PoseMatrix, q0: JointVector, tolerance: float, others: JointVector | None = None
) -> SolutionSet:
    """All solutions of one pose.

    Args:
        setting: the arm.
        T: (4, 4) requested pose.
        q0: (m,) values that free and locked joints take, and to which angles are wound.
        tolerance: largest residual of a solution.
        others: coordinates of the whole robot, where the joints that do not move the frame are.

    Raises:
        InputError: no pose.
    """
    kernel = setting.kernel
    if kernel is not None and np.isfinite(T).all():
        rows = kernel.call(T, q0, turns_of(q0), *setting.bounds, tolerance)
        return judged_pose(Question(setting, T.copy(), q0, tolerance, others), rows)
    if has_redundant_joints(setting):
        return redundant_single.redundant_single(setting, T, q0, tolerance, others)
    clean, valid = clean_poses(T[None])
    goal = clean[0] if valid[0] else printed_pose("T_sd", T)
    return at_parameter.answer_at(Question(setting, goal, q0, tolerance, others))


def judged_pose(question: Question, judged: tuple[JointVector, Floats, float]) -> SolutionSet:
    """The answer from the rows of the closed form.

    Args:
        question: to an arm whose closed form is exact and locks no joint; its pose is a copy of the caller's.
        judged: (rows, m) coordinates, (rows, 6) details, and the decision about the pose.

    Raises:
        InputError: no pose.
    """
    q, columns, decision = judged
    if decision != Decision.CAREFUL:
        if decision == Decision.NO_POSE:
            goal = printed_pose("T_sd", question.T)
            return one_pose(question.setting, goal, question.q0, question.tolerance, question.others)
        rows = [] if decision == Decision.NONE else distinct_rows(q, columns, question)
        return exact_set(question, q, columns, rows)
    setting, form = question.setting, question.setting.arm.form
    assert form is not None
    question.T = clean_poses(question.T[None])[0][0]
    if setting.arm.general is not None:
        # Roots that merge by three or four may be lost: elimination has candidates too.
        return question.answer()
    rows = q[None], CandidateTable.of(columns[None]), question.tolerance
    lists = refined_lists(setting, form, question.T[None], question.q0, rows)
    if lists.open[0]:
        return question.answer()
    found = np.flatnonzero(lists.valid[0])
    codes, residual = lists.codes[0, found], lists.residual[0, found]
    known = True if complete(setting, codes, residual) else None
    rest = lists.within[0, found], found, codes, lists.free[0, found]
    return SolutionSet(
        question, lists.q[0, found], residual, *rest, method="closed form", complete=known, isolated=False
    )


def distinct_rows(q: JointVector, columns: Floats, question: Question) -> list[int]:
    """The rows of one pose that are solutions, each of them once; of so few numbers Python makes the least work.

    Args:
        q: (rows, m) coordinates.
        columns: (rows, 6) details.
        question: gives the tolerance and which coordinates are angles.
    """
    setting, tolerance = question.setting, question.tolerance
    revolute = setting.revolute.tolist()
    # Elsewhere rows with branch margins far from zero are distinct.
    all_may_repeat = setting.quartic or not setting.plain
    kept: list[int] = []
    seen: list[list[float]] = []
    for k, (residual, _, free, _, margin, _) in enumerate(columns.tolist()):
        if not residual <= tolerance:
            continue
        if all_may_repeat or free > 0.0 or margin < APART:
            row = q[k].tolist()
            if any(_alike(row, other, revolute) for other in seen):
                continue
            seen.append(row)
        kept.append(k)
    return kept


def _alike(one: list[float], other: list[float], revolute: list[bool]) -> bool:
    """Whether coordinates are equal up to whole turns."""
    for a, b, turns in zip(one, other, revolute, strict=True):
        apart = a - b
        if turns:
            apart -= TURN * round(apart / TURN)
        if abs(apart) > SAME:
            return False
    return True


_new = object.__new__


def clear_set(setting: Setting, q: JointVector, details: Floats, chosen: slice | NDArray[np.intp]) -> SolutionSet:
    """The solutions of a pose whose list is clear: distinct, isolated, exact rows of the closed form.

    Args:
        setting: the arm.
        q: (k, m) their coordinates.
        details: (rows, 6) of all rows of the closed form.
        chosen: which rows they are.
    """
    answer = _new(SolutionSet)
    answer.own = answer.q = q
    answer._ask, answer._setting, answer._details, answer._chosen = _question, setting, details, chosen  # pyright: ignore[reportPrivateUsage]
    if setting.part.places is not None:
        answer.q = setting.part.lift(q, setting.part.middle)
    return answer


def exact_set(question: Question, q: JointVector, details: Floats, rows: list[int]) -> SolutionSet:
    """The solutions of a pose whose list is exact, but where branches may meet and joints be free; or there are none.

    Args:
        question: about the pose.
        q: (rows, m) coordinates of all rows of the closed form.
        details: (rows, 6) of them.
        rows: which of them are solutions, each of them once.
    """
    chosen = np.array(rows, dtype=np.intp)
    answer = clear_set(question.setting, q[chosen], details, chosen)
    if question.setting.part.places is not None:
        answer.q = question.setting.part.lift(answer.own, question.others)
    answer._isolated = False  # pyright: ignore[reportPrivateUsage]
    vars(answer)["_question"] = question
    return answer


def _question(answer: SolutionSet) -> Question:
    """The question that a clear list answers: its pose is that of its solutions."""
    setting = answer._setting  # pyright: ignore[reportPrivateUsage]
    return Question(setting, setting.robot.forward_kinematics(answer.own[0]), setting.middle, REACHED)
