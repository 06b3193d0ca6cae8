"""Arms whose closed form locks joints, one pose or many: values are chosen, the kernel does the rest."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.ik.answers.candidate_table import CODE, EXCESS, RESIDUAL, ParametricSummary, ParametricTable
from mafsil.ik.answers.question import LOOSE, Question
from mafsil.ik.answers.refusal import out_of_plane
from mafsil.ik.answers.search import Start
from mafsil.ik.answers.setting import CLEAR, Setting, turns_of
from mafsil.ik.answers.solution_set import SolutionSet
from mafsil.ik.redundant.parameter_search import ParameterValues, nearest_allowed, parameter_values
from mafsil.ik.redundant.parametric_form import ParametricForm, parametric_form
from mafsil.ik.result import CODES, FARTHEST, ORTHOGONALITY, IKStatus, clean_poses, printed_pose
from mafsil.ik.tolerances import ON_LIMIT
from mafsil.kernels.lazy import preset

CHUNK = 4096
"""Poses whose details are kept at once."""


def redundant_batch(setting: Setting, T: PoseMatrix, q0: JointVector, tolerance: float) -> tuple[NDArray[Any], ...]:
    """All solutions of many poses with the redundant joints at `q0`, or at the nearest tried values that lead to any.

    For each chunk of poses:

    1. Values of the redundant joints are found, or the proof that there are none.
    2. The kernel gives all branches there, and says which poses need refinement.
    3. Regular poses are written as they are: members of continua, or proven to be beyond the limits.
    4. Poses proven to be out of reach have no rows.
    5. What is left is answered one by one, with care.

    Args:
        setting: an arm whose exact closed form locks joints.
        T: (k, 4, 4) poses; rows that are no poses get `NOT_A_POSE`.
        q0: (n,) values that free and redundant joints take.
        tolerance: largest residual of a solution.

    Returns:
        Coordinates, which rows are solutions, which of them are within the limits, residuals, codes, free coordinates,
        and statuses, as `SolutionBatch` has them.
    """
    form, most, turns = parametric_form(setting), min(tolerance, setting.candidate), turns_of(q0)
    out = BatchRows(len(T), form.pattern.branches, setting.robot.n)
    bits, names = sum(1 << joint for joint in form.joints), setting.robot.joint_names
    for begin in range(0, len(T), CHUNK):
        part = slice(begin, begin + CHUNK)
        poses = finite_poses(T[part])
        # 1.
        starts = parameter_values(setting, form, poses, q0, most)
        # 2.
        q, details, summary = form.solutions(poses, starts.values, q0, turns, *setting.bounds, most)
        known = ParametricSummary.of(summary)
        valid = known.defect <= ORTHOGONALITY
        # 3.
        settled = (starts.allowed | (starts.refuted & starts.solved)) & (tolerance >= CLEAR)
        regular = np.flatnonzero(valid & (known.doubtful + known.folded == 0.0) & settled)
        whole = len(regular) == len(poses)
        rows = part if whole else begin + regular
        q, details = (q, details) if whole else (q[regular], details[regular])
        table = ParametricTable.of(details)
        good = table.residual <= CLEAR
        out.q[rows], out.residual[rows], out.valid[rows] = q, table.residual, good
        out.within[rows] = good & (table.excess <= ON_LIMIT)
        out.codes[rows], out.free[rows] = np.nan_to_num(table.code), np.where(good, bits, 0)
        out.set_status(begin + regular, IKStatus.CONTINUUM)
        out.set_status(begin + regular[~starts.allowed[regular]], IKStatus.BEYOND_LIMITS)
        # 4.
        left = np.setdiff1d(np.flatnonzero(valid), regular, assume_unique=True)
        proven = np.array([_proven(setting, poses[i], starts, int(i), tolerance) for i in left], dtype=np.bool_)
        out.set_status(begin + left[proven], IKStatus.OUT_OF_REACH)
        # 5.
        for i in left[~proven]:
            question = careful_question(setting, form, poses[i], q0, tolerance, None, starts, int(i))
            answer = question.answer()
            out.write(begin + int(i), answer)
            for family in (one for one in answer.families if one.solution < out.q.shape[1]):
                out.free[begin + int(i), family.solution] |= 1 << names.index(family.joint)
    return out.columns


def _proven(setting: Setting, T: PoseMatrix, starts: ParameterValues, i: int, tolerance: float) -> bool:
    """Whether nothing can be near enough, and not because of what a planar arm, or one of few joints, cannot do."""
    few = setting.few and setting.task == "pose"
    return bool(starts.unreachable[i]) and tolerance <= LOOSE and not few and not out_of_plane(setting, T)


class BatchRows:
    """Solutions of k poses in a table of the same number of rows for each.

    Attributes:
        q: (k, rows, n) coordinates.
        valid, within: (k, rows) which rows are solutions, and within the limits.
        residual: (k, rows) their errors.
        codes: (k, rows) branches as numbers.
        free: (k, rows) sum of 2^i over the coordinates that may be chosen.
        status: (k,) index of the status; at first that of no poses.
    """

    def __init__(self, count: int, rows: int, n: int) -> None:
        shape = (count, rows)
        self.q = np.full((*shape, n), np.nan)
        self.residual: Floats = np.full(shape, np.nan)
        self.valid, self.within = np.zeros(shape, dtype=np.bool_), np.zeros(shape, dtype=np.bool_)
        self.codes, self.free = np.zeros(shape, dtype=np.int16), np.zeros(shape, dtype=np.int32)
        self.status = np.full(count, CODES[IKStatus.NOT_A_POSE], dtype=np.int8)

    def set_status(self, which: NDArray[np.bool_] | NDArray[np.intp], status: IKStatus) -> None:
        """Set the status of some poses."""
        self.status[which] = CODES[status]

    def write(self, i: int, answer: SolutionSet) -> None:
        """A careful answer into the rows of its pose, as far as there are any."""
        k = min(len(answer), self.q.shape[1])
        self.q[i, :k], self.residual[i, :k], self.codes[i, :k] = answer.own[:k], answer.residual[:k], answer.codes[:k]
        self.valid[i, :k], self.within[i, :k], self.free[i, :k] = True, answer.within[:k], answer.own_free[:k]
        self.status[i] = CODES[answer.status]

    @property
    def columns(self) -> tuple[NDArray[Any], ...]:
        """Coordinates, solutions, those within the limits, residuals, codes, free coordinates, statuses."""
        return self.q, self.valid, self.within, self.residual, self.codes, self.free, self.status


def finite_poses(T: PoseMatrix) -> PoseMatrix:
    """Rows with NaN, infinities or numbers that would overflow as zeros, which are no poses either.

    Args:
        T: (k, 4, 4).
    """
    finite = np.asarray((np.abs(T) < FARTHEST).all(axis=(1, 2)), dtype=np.bool_)
    return T if finite.all() else np.where(finite[:, None, None], T, 0.0)


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
