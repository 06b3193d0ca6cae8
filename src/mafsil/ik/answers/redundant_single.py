"""One pose of an arm whose closed form locks joints: the kernel's rows where they are regular, else with care."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.ik.answers.candidate_table import CODE, EXCESS, RESIDUAL
from mafsil.ik.answers.question import Question
from mafsil.ik.answers.search import Start
from mafsil.ik.answers.setting import CLEAR, Setting, turns_of
from mafsil.ik.answers.solution_set import SolutionSet
from mafsil.ik.problem import ORTHOGONALITY, clean_poses, printed_pose
from mafsil.ik.redundant.parameter_search import ParameterValues, nearest_allowed, parameter_values
from mafsil.ik.redundant.parametric_form import ParametricForm, parametric_form
from mafsil.ik.result import IKStatus
from mafsil.ik.tolerances import ON_LIMIT
from mafsil.kernels.lazy import preset


def redundant_single(
    setting: Setting, T: PoseMatrix, q0: JointVector, tolerance: float, others: JointVector | None = None
) -> SolutionSet:
    """All solutions of one pose with the redundant joints at `q0`, or at the nearest tried values that lead to any.

    1. The kernel gives every branch at the preferred values, and says whether one is within the limits and whether
       one needs refinement.
    2. Where none is within the limits other values are sought, and the kernel called again.
    3. Regular branches are the answer; each is a member of a continuum, for the other joints follow the locked ones.
       Anything else is answered with care.

    Args:
        setting: an arm for which `has_redundant_joints` holds.
        T: (4, 4) pose.
        q0: (n,) values that free and redundant joints take.
        tolerance: largest residual of a solution.
        others: coordinates of the whole robot, where the joints that do not move the frame are.

    Raises:
        InputError: no pose.
    """
    form, most = parametric_form(setting), min(tolerance, setting.candidate)
    turns = setting.middle_turns if q0 is setting.middle else turns_of(q0)
    # 1.
    values = q0[form.joints]
    q, details, summary = form.solutions.call(T, values, q0, turns, *setting.bounds, most)
    defect, doubtful, folded, excess = summary.tolist()
    if not defect <= ORTHOGONALITY:
        return redundant_single(setting, printed_pose("T_sd", T), q0, tolerance, others)
    # 2.
    if not excess <= ON_LIMIT:
        other = nearest_allowed(setting, form, T, q0, most)
        if other is None:
            starts = parameter_values(setting, form, T[None], q0, most)
            if not starts.allowed[0]:
                return careful_question(setting, form, T, q0, tolerance, others, starts, 0).answer()
            other = starts.values[0]
        values = other
        q, details, summary = form.solutions.call(T, values, q0, turns, *setting.bounds, most)
        _, doubtful, folded, _ = summary.tolist()
    # 3.
    if doubtful or folded or tolerance < CLEAR:
        none = np.zeros(1, dtype=np.bool_)
        known = ParameterValues(values[None], ~none, ~none, none, none)
        return careful_question(setting, form, T, q0, tolerance, others, known, 0).answer()
    good = details[:, RESIDUAL] <= CLEAR
    chosen, rows = details[good], good.nonzero()[0]
    return regular_answer(
        Question(setting, T.copy(), q0, tolerance, others),
        q[good],
        chosen[:, RESIDUAL],
        chosen[:, EXCESS],
        rows,
        chosen[:, CODE],
    )


def regular_answer(
    question: Question,
    q: JointVector,
    residual: Floats,
    excess: Floats,
    rows: NDArray[np.int64],
    codes: Floats,
) -> SolutionSet:
    """Regular solutions, each the member of a continuum.

    Args:
        question: that they answer.
        q: (k, n) coordinates.
        residual, excess: (k,) errors, and by how much the limits are exceeded.
        rows, codes: (k,) row of the closed form's table, and branch as a number.
    """
    answer = SolutionSet(
        question,
        q,
        residual,
        excess <= ON_LIMIT,
        rows,
        codes.astype(np.int64),
        np.zeros(len(q), dtype=np.int64),
        method="closed form",
        complete=False,
        isolated=False,
    )
    preset(answer, status=IKStatus.CONTINUUM)
    return answer


def careful_question(
    setting: Setting,
    form: ParametricForm,
    T: PoseMatrix,
    q0: JointVector,
    tolerance: float,
    others: JointVector | None,
    starts: ParameterValues,
    i: int,
) -> Question:
    """The question to one pose, with what is known of its redundant joints.

    Args:
        setting, form: the arm and its kernels.
        T: (4, 4) pose.
        q0, tolerance, others: as for `redundant_single`.
        starts: known of some poses.
        i: place of the pose among those.
    """
    question = Question(setting, clean_poses(T[None])[0][0], q0, tolerance, others)
    moved = q0.copy()
    moved[form.joints] = starts.values[i]
    start = Start(moved, bool(starts.refuted[i]), bool(starts.unreachable[i]))
    preset(question, start=start)
    return question
