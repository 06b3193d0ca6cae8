"""Batches of arms without an exact closed form: lists proven by elimination at once, the others with care."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import JointVector, PoseMatrix
from mafsil.ik.answers.batch import Columns, finite_poses
from mafsil.ik.answers.branch import UNNAMED
from mafsil.ik.answers.eliminated import Eliminated, eliminate_poses
from mafsil.ik.answers.question import Question
from mafsil.ik.answers.refined_rows import beside_folds, refinable, refined_rows
from mafsil.ik.answers.setting import Setting
from mafsil.ik.answers.solution_set import SolutionSet
from mafsil.ik.general.findings import MOST
from mafsil.ik.problem import clean_poses
from mafsil.ik.redundant.at_parameter import answer_at
from mafsil.ik.result import CODES, IKStatus
from mafsil.ik.tolerances import ON_LIMIT

PROBE = 8
"""Poses after which it is known whether elimination proves the lists of an arm."""


def one_by_one(setting: Setting, T: PoseMatrix, q0: JointVector, tolerance: float) -> Columns:
    """All solutions of many poses of an arm without an exact closed form of its own.

    Args:
        setting: the arm.
        T: (k, 4, 4) poses; rows that are no poses get `NOT_A_POSE`.
        q0: (n,) values that free and locked joints take, and to which angles are wound.
        tolerance: largest residual of a solution.
    """
    clean, valid = clean_poses(finite_poses(T))
    arm, count, n = setting.arm, len(T), setting.robot.n
    proven: Eliminated | None = None
    poses = np.where(valid[:, None, None], clean, np.nan)
    if arm.form is None and arm.general is not None and n == 6:
        proven = eliminate_poses(setting, arm.general, poses, q0)
    elif refinable(setting):
        proven = _refine(setting, poses, q0)
    sure = np.zeros(count, dtype=np.bool_) if proven is None else proven.sure
    answers: dict[int, SolutionSet] = {}
    for i in np.flatnonzero(valid & ~sure).tolist():
        question = Question(setting, clean[i], q0, tolerance)
        if proven is not None and proven.found is not None:
            question.know(proven.found[i])
        answers[i] = answer_at(question)
    most = max([len(one) for one in answers.values()] + ([] if proven is None else [proven.q.shape[1]]), default=0)
    q, residual = np.full((count, most, n), np.nan), np.full((count, most), np.nan)
    codes, loose = np.full((count, most), UNNAMED, dtype=np.int16), np.zeros((count, most), dtype=np.int32)
    if proven is not None:
        q[:, : proven.q.shape[1]], residual[:, : proven.q.shape[1]] = proven.q, proven.residual
        codes[:, : proven.q.shape[1]] = UNNAMED if proven.codes is None else proven.codes
    good = residual <= tolerance
    within = good & ((q >= setting.lower - ON_LIMIT) & (q <= setting.upper + ON_LIMIT)).all(axis=-1)
    status = np.where(within.any(axis=1), CODES[IKStatus.SOLVED], CODES[IKStatus.BEYOND_LIMITS])
    status[~good.any(axis=1)] = CODES[IKStatus.OUT_OF_REACH]
    status[~valid] = CODES[IKStatus.NOT_A_POSE]
    for i, one in answers.items():
        k = len(one)
        q[i, :k], residual[i, :k], within[i, :k], codes[i, :k] = one.own, one.residual, one.within, one.codes
        loose[i, :k], good[i, :k], status[i] = one.own_free, True, CODES[one.status]
    return Columns(q, good, within, residual, codes, loose, status.astype(np.int8))


def _refine(setting: Setting, T: PoseMatrix, q0: JointVector) -> Eliminated:
    """Lists of an almost ideal arm: rows away from folds refined; beside them by elimination where it proves lists.

    Where it proves none, as with wrists that nearly meet, rows are sought on both sides of the folds. Poses without a
    solution within the limits are left open.
    """
    found = refined_rows(setting, T, q0)
    general, open_rows = setting.arm.general, np.flatnonzero(~found.clear & np.isfinite(T[:, 0, 0]))
    shape = (len(T), MOST)
    q, residual = np.full((*shape, setting.robot.n), np.nan), np.full(shape, np.nan)
    codes, sure = np.full(shape, UNNAMED, dtype=np.int64), found.clear.copy()
    rows = found.q.shape[1]
    q[:, :rows], residual[:, :rows], codes[:, :rows] = found.q, found.residual, found.codes
    q[np.isnan(residual)] = np.nan
    general = general if general is not None and len(open_rows) and general.proves else None
    probing = general is not None
    while len(open_rows):
        # A few poses show whether elimination proves the lists of the arm.
        part = open_rows[: PROBE if probing else len(open_rows)]
        open_rows, probing = open_rows[len(part) :], False
        codes[part] = UNNAMED
        if general is not None:
            listed = eliminate_poses(setting, general, T[part], q0)
            q[part], residual[part], sure[part] = listed.q, listed.residual, listed.sure
            general = general if 2 * listed.sure.sum() >= len(part) else None
        part = part[~sure[part]]
        if len(part):
            q[part], residual[part] = beside_folds(setting, T[part], q0)
            sure[part] = (np.isfinite(residual[part]) & setting.within_limits(q[part])).any(axis=1)
    return Eliminated(sure, q, residual, codes)
