"""The answer to one pose: the rows of its closed form where they decide, else with as much care as it needs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.ik.answers.candidate_table import CandidateTable, Decision
from mafsil.ik.answers.eliminated import elimination_set, judge
from mafsil.ik.answers.lists import complete, refined_lists
from mafsil.ik.answers.question import LOOSE, Question
from mafsil.ik.answers.setting import CLEAR, Quick, Setting, turns_of
from mafsil.ik.answers.solution_set import SolutionSet
from mafsil.ik.redundant.parametric_form import has_redundant_joints
from mafsil.ik.result import IKStatus, clean_poses, printed_pose
from mafsil.ik.tolerances import REACHED
from mafsil.lazy_module import lazily

if TYPE_CHECKING:
    import mafsil.ik.answers.redundant_batch as redundant_single
    import mafsil.ik.redundant.at_parameter as at_parameter
    import mafsil.ik.refine_loops as winding_loops
    from mafsil.ik.general.offset_wrist import OffsetWrist
else:
    at_parameter = lazily("mafsil.ik.redundant.at_parameter")
    redundant_single = lazily("mafsil.ik.answers.redundant_batch")
    winding_loops = lazily("mafsil.ik.refine_loops")

POSE = (4, 4)
CAREFUL, NONE, NO_POSE, REPEATED = (
    float(each) for each in (Decision.CAREFUL, Decision.NONE, Decision.NO_POSE, Decision.REPEATED)
)
"""Decisions as the compiled closed form gives them: members of an enumeration take a microsecond to be read."""


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


def pose_near(quick: Quick, T: PoseMatrix, q0: JointVector, tolerance: float) -> SolutionSet:
    """All solutions of one pose from the compiled closed form, with preferred values.

    Args:
        quick: the closed form.
        T: (4, 4) requested pose.
        q0: (n,) coordinates of the whole robot.
        tolerance: largest residual of a solution.

    Raises:
        InputError: no pose.
    """
    setting, others = quick.setting, q0.copy()
    own = setting.part.own(others)
    judged = quick.call(T, own, turns_of(own), *setting.bounds, tolerance)
    return judged_pose(Question(setting, T.copy(), own, tolerance, others), judged)


class OffsetPoses:
    """The shortest way to all solutions of one pose of an arm with an offset wrist.

    Attributes:
        setting: the arm.
        wrist: the polynomial of its last joint.
    """

    __slots__ = ("setting", "wrist")

    def __init__(self, setting: Setting, wrist: OffsetWrist) -> None:
        self.setting, self.wrist = setting, wrist

    def proven(self, T: PoseMatrix, q0: JointVector | None, tolerance: float) -> SolutionSet | None:
        """The complete list of one pose; None where it is not proven.

        Args:
            T: (4, 4) requested pose.
            q0: (n,) coordinates of the whole robot near which angles are wound; the middle of the limits if None.
            tolerance: largest residual of a solution.
        """
        setting, poses, others = self.setting, T[None].copy(), None if q0 is None else q0.copy()
        lists, own = self.wrist.solve_poses(poses), setting.middle if others is None else setting.part.own(others)
        # Within a wide tolerance the nearest configuration may do where none is exact.
        if lists.counts[0] < 0 or (not lists.counts[0] and tolerance > LOOSE):
            return None
        judged = judge(setting, lists.q, poses, lists.rows, own)
        if judged.worst > CLEAR:
            return None
        return elimination_set(Question(setting, poses[0], own, tolerance, others), judged, isolated=len(lists.q) > 0)


def offset_poses(setting: Setting) -> OffsetPoses | None:
    """That way for an arm; None where it has another one."""
    arm = setting.arm
    wrist = arm.general.offset if arm.form is None and arm.general is not None else None
    return None if wrist is None else OffsetPoses(setting, wrist)


def judged_pose(question: Question, judged: tuple[JointVector, Floats, float]) -> SolutionSet:
    """The answer from the rows of the closed form.

    Args:
        question: to an arm whose closed form is exact and locks no joint; its pose is a copy of the caller's.
        judged: (rows, m) coordinates, (rows, 6) details, and the decision about the pose.

    Raises:
        InputError: no pose.
    """
    q, columns, decision = judged
    if decision > 0.0:
        assert question.setting.quick is not None
        return _list_of(question, q, columns, question.setting.quick.rows(decision), isolated=True)
    if decision == NONE:
        return _list_of(question, q, columns, slice(0, 0), isolated=False)
    if decision != CAREFUL:
        if decision == NO_POSE:
            goal = printed_pose("T_sd", question.T)
            return one_pose(question.setting, goal, question.q0, question.tolerance, question.others)
        good = columns[None, :, 0] <= question.tolerance
        winding_loops.unique_rows(q[None], good, question.setting.revolute)
        answer = _list_of(question, q, columns, np.flatnonzero(good), isolated=False)
        # No two branches meet: only where the Jacobian says so may a solution move.
        answer._apart = decision == REPEATED and question.setting.decisive  # pyright: ignore[reportPrivateUsage]
        return answer
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
    answer = SolutionSet(
        question, lists.q[0, found], residual, *rest, method="closed form", complete=known, isolated=False
    )
    if len(found) and not rest[0].any() and (columns[found, 2] > 0.0).any():
        # The list is not open: no value of the joints that are free leads into the limits.
        vars(answer)["status"] = IKStatus.BEYOND_LIMITS
    return answer


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


def _list_of(
    question: Question, q: JointVector, details: Floats, chosen: slice | NDArray[np.intp], *, isolated: bool
) -> SolutionSet:
    """Some rows of the closed form as the answer to a question.

    Args:
        question: about the pose.
        q: (rows, m) coordinates of all rows of the closed form.
        details: (rows, 6) of them.
        chosen: which of them are solutions, each of them once.
        isolated: whether it is known that none of them can move.
    """
    answer = clear_set(question.setting, q[chosen], details, chosen)
    if question.setting.part.places is not None:
        answer.q = question.setting.part.lift(answer.own, question.others)
    answer._isolated = isolated  # pyright: ignore[reportPrivateUsage]
    vars(answer)["_question"] = question
    return answer


def _question(answer: SolutionSet) -> Question:
    """The question that a clear list answers: its pose is that of its solutions."""
    setting = answer._setting  # pyright: ignore[reportPrivateUsage]
    return Question(setting, setting.robot.forward_kinematics(answer.own[0]), setting.middle, REACHED)
