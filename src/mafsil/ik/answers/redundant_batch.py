"""Batches for arms whose closed form locks joints: their values are chosen for all poses, one kernel does the rest.

The rows of a batch as `SolutionBatch` has them, and how answers are written into them.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.ik.answers.candidate_table import ParametricSummary, ParametricTable
from mafsil.ik.answers.question import LOOSE
from mafsil.ik.answers.redundant_single import careful_question
from mafsil.ik.answers.refusal import out_of_plane
from mafsil.ik.answers.setting import CLEAR, Setting, turns_of
from mafsil.ik.answers.solution_set import SolutionSet
from mafsil.ik.problem import FARTHEST, ORTHOGONALITY
from mafsil.ik.redundant.parameter_search import ParameterValues, parameter_values
from mafsil.ik.redundant.parametric_form import parametric_form
from mafsil.ik.result import CODES, IKStatus
from mafsil.ik.tolerances import ON_LIMIT

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
