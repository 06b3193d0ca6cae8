"""All solutions of many poses at once: padded arrays, and the careful answer to any one of them by its index."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.errors import InputError
from mafsil.ik.answers.branch import UNNAMED, Branch, branch, missed
from mafsil.ik.answers.eliminated import Eliminated, eliminated
from mafsil.ik.answers.held_batch import held_batch
from mafsil.ik.answers.question import FOLD, Question
from mafsil.ik.answers.setting import CLEAR, Setting, turns_of
from mafsil.ik.answers.solution_set import SolutionSet, wound_near
from mafsil.ik.answers.verdict import Verdict
from mafsil.ik.problem import ORTHOGONALITY, clean_poses
from mafsil.ik.redundant.fixed import answered
from mafsil.kernels import Kernel
from mafsil.mechanics.arm_pattern import Missed

VERDICTS = tuple(Verdict)

CHUNK = 8192
"""Poses whose facts are held at once; memory beyond the results does not grow with the batch."""

APART = 1e-4
"""Marks below which rows are looked at for being the same solution."""


MERGED = 1e-7
"""Marks up to which a solution may be a member of a continuum."""

SAME = 1e-6
"""Difference of coordinates up to which rows are one solution [rad | m]."""


@dataclass(frozen=True, eq=False)
class SolutionBatch:
    """All solutions of many poses.

    Row k of a pose is the same root of the closed form for every pose, so that rows do not change places in a batch.

    Attributes:
        q: (*batch, k, n) coordinates; only rows that are `valid` are solutions, others hold the nearest miss.
        valid: (*batch, k) which rows are solutions, each of them once.
        within: (*batch, k) which of them are within the joint limits.
        residual: (*batch, k) by how much forward kinematics misses, distance [m] or angle [rad], the larger.
        codes: (*batch, k) branches as numbers; see `branch`.
        free: (*batch, k) sum of 2^i over the coordinates i that may be chosen: the solution is a member of a continuum.
        status_codes: (*batch,) index into `Verdict`'s members, in order.
    """

    q: JointVector
    valid: NDArray[np.bool_]
    within: NDArray[np.bool_]
    residual: Floats
    codes: NDArray[np.int16]
    free: NDArray[np.int32]
    status_codes: NDArray[np.int8]
    setting: Setting
    T: PoseMatrix
    near: JointVector
    tolerance: float

    def __len__(self) -> int:
        return len(self.q)

    def __repr__(self) -> str:
        shape, solved = self.status_codes.shape, int(self.solved.sum())
        size, rows = self.status_codes.size, int(self.valid.sum())
        return f"<SolutionBatch: {solved} of {size} poses solved, shape {shape}, {rows} rows>"

    @property
    def count(self) -> NDArray[np.int64]:
        """(*batch,) number of solutions."""
        return self.valid.sum(axis=-1)

    @property
    def solved(self) -> NDArray[np.bool_]:
        """(*batch,) which poses have a solution within the limits."""
        return np.asarray(self.within.any(axis=-1), dtype=np.bool_)

    @property
    def labels(self) -> NDArray[np.str_]:
        """(*batch, k) branches as words, such as `right/up/noflip`; empty where there is no solution."""
        form = self.setting.arm.form
        pattern = None if form is None else form.pattern
        words = np.full(self.codes.shape, "", dtype="<U32")
        rows = np.broadcast_to(np.arange(self.codes.shape[-1]), self.codes.shape)
        keys = np.where(self.valid, self.codes.astype(np.int64) * 64 + rows, -1)
        for key in np.unique(keys[keys >= 0]):
            words[keys == key] = str(branch(pattern, int(key % 64), int(key // 64)))
        return words

    def branch(self, *index: int) -> Branch:
        """The branch of one row: indices of the pose, then of the row."""
        form = self.setting.arm.form
        return branch(None if form is None else form.pattern, index[-1], int(self.codes[index]))

    def status(self, *index: int) -> Verdict:
        """What can be said about one pose."""
        return VERDICTS[int(self.status_codes[index])]

    def __getitem__(self, index: int | tuple[int, ...]) -> SolutionSet:
        """The careful answer to one pose, with families and reasons.

        Raises:
            InputError: the row is not a pose.
        """
        clean, valid = clean_poses(_finite(self.T[index].reshape(1, 4, 4)))
        if not valid[0]:
            raise InputError("ik.no_pose", name=f"T_sd[{index}]", limit=ORTHOGONALITY)
        return answered(Question(self.setting, clean[0], self.near, self.tolerance))

    def nearest(self, q: JointVector) -> JointVector:
        """(*batch, n) for every pose the solution nearest to a configuration, within the limits if any is; NaN if none.

        Args:
            q: (n,) or (*batch, n).
        """
        setting = self.setting
        start = np.asarray(q, dtype=np.float64)[..., None, :]
        wound = wound_near(self.q, start, setting.lower, setting.upper, setting.turning)
        cost = np.linalg.norm(wound - start, axis=-1) + np.where(self.within, 0.0, 1e6)
        cost = np.where(self.valid, cost, np.inf)
        best = cost.argmin(axis=-1)[..., None]
        chosen = np.take_along_axis(wound, best[..., None], axis=-2)[..., 0, :]
        return np.where(np.isfinite(np.take_along_axis(cost, best, axis=-1)), chosen, np.nan)


def solved_batch(setting: Setting, T: PoseMatrix, near: JointVector, tolerance: float) -> SolutionBatch:
    """All solutions of a batch.

    Args:
        setting: the arm.
        T: (*batch, 4, 4) poses.
        near: (n,) values that free and held joints take.
        tolerance: largest residual of a solution.
    """
    flat = np.ascontiguousarray(T.reshape(-1, 4, 4))
    kernel = setting.kernel
    if kernel is not None and setting.arm.form is not None:
        parts = _compiled(setting, kernel, setting.arm.form.pattern.branches, flat, near, tolerance)
    elif setting.holds_one:
        parts = held_batch(setting, flat, near, tolerance)
    else:
        parts = _one_by_one(setting, flat, near, tolerance)
    shape = T.shape[:-2]
    q, valid, within, residual, codes, free, status = (part.reshape(*shape, *part.shape[1:]) for part in parts)
    return SolutionBatch(q, valid, within, residual, codes, free, status, setting, T, near, tolerance)


def _compiled(
    setting: Setting, kernel: Kernel, rows: int, T: PoseMatrix, near: JointVector, tolerance: float
) -> tuple[NDArray[Any], ...]:
    """By the labelled closed form, chunk by chunk."""
    count, n = len(T), setting.robot.n
    q, residual = np.empty((count, rows, n)), np.empty((count, rows))
    valid, within = np.empty((count, rows), dtype=np.bool_), np.empty((count, rows), dtype=np.bool_)
    codes, status = np.empty((count, rows), dtype=np.int16), np.empty(count, dtype=np.int8)
    turns, loose = turns_of(near), np.empty((count, rows), dtype=np.int32)
    for begin in range(0, count, CHUNK):
        part = slice(begin, min(begin + CHUNK, count))
        out, facts, defect = kernel(_finite(T[part]), near, turns, *setting.bounds)
        poses = defect <= ORTHOGONALITY
        good = (facts[..., 0] <= tolerance) & poses[:, None]
        inside = facts[..., 5] <= 1e-12
        free = facts[..., 2] > 0
        odd = ((facts[..., 0] <= setting.candidate) & (facts[..., 0] > CLEAR)) | (
            good & (free | (facts[..., 4] <= MERGED))
        )
        odd |= setting.folded(facts)
        if setting.quartic:
            odd |= (facts[..., 4] <= FOLD) | ~good.any(axis=1, keepdims=True)
        lost = ~(good & inside).any(axis=1) & (free & poses[:, None]).any(axis=1)
        careful = (odd.any(axis=1) | lost) & poses
        close = good.any(axis=1) & ~careful
        if setting.plain and not setting.quartic:
            close &= (good & (facts[..., 4] < APART)).any(axis=1)
        _merge(setting, np.flatnonzero(close), out, good)
        for i in np.flatnonzero(careful):
            question = Question(setting, clean_poses(T[begin + i][None])[0][0], near, tolerance)
            _careful(question, int(i), out, facts, good, inside)
        q[part], residual[part], valid[part], within[part] = out, facts[..., 0], good, good & inside
        codes[part], loose[part] = np.nan_to_num(facts[..., 3]), np.where(good, facts[..., 2], 0.0)
        status[part] = _statuses(setting, facts, good, within[part], poses)
    return q, valid, within, residual, codes, loose, status


def _merge(setting: Setting, poses: NDArray[np.intp], q: Floats, good: NDArray[np.bool_]) -> None:
    """Rows that repeat an earlier solution of their pose are no longer good."""
    some, valid = q[poses], good[poses]
    for k in range(1, some.shape[1]):
        for j in range(k):
            d = some[:, k] - some[:, j]
            d = np.where(setting.turning, (d + np.pi) % (2 * np.pi) - np.pi, d)
            valid[:, k] &= ~(valid[:, j] & (np.abs(d).max(axis=1) <= SAME))
    good[poses] = valid


def _finite(T: PoseMatrix) -> PoseMatrix:
    """Rows with NaN or infinities as zeros, which are no poses either."""
    finite = np.asarray(np.isfinite(T).all(axis=(1, 2)), dtype=np.bool_)
    return T if finite.all() else np.where(finite[:, None, None], T, 0.0)


def _careful(
    question: Question, i: int, q: Floats, facts: Floats, good: NDArray[np.bool_], inside: NDArray[np.bool_]
) -> None:
    """One pose with refinement, merging and free joints; its rows are written back."""
    answer = question.answer()
    good[i] = False
    # Solutions found otherwise, and second ones of a row, take the rows that are left; of continua there may be more.
    rows, left = answer.rows.copy(), np.setdiff1d(np.arange(len(good[i])), answer.rows)
    again = np.flatnonzero((rows < 0) | (np.arange(len(rows)) != np.array([list(rows).index(row) for row in rows])))
    rows[again[: len(left)]] = left[: len(again)]
    kept = np.setdiff1d(np.arange(len(rows)), again[len(left) :])
    rows = rows[kept]
    q[i, rows], facts[i, rows, 0], facts[i, rows, 3] = answer.q[kept], answer.residual[kept], answer.codes[kept]
    facts[i, rows, 2] = 0
    names = question.setting.robot.joint_names
    for family in answer.families:
        bit = 1 << names.index(family.joint)
        for row in rows[kept == family.solution]:
            facts[i, row, 2] = int(facts[i, row, 2]) | bit
    good[i, rows], inside[i, rows] = True, answer.within[kept]


def _statuses(
    setting: Setting, facts: Floats, good: NDArray[np.bool_], within: NDArray[np.bool_], poses: NDArray[np.bool_]
) -> NDArray[np.int8]:
    found, allowed = good.any(axis=1), within.any(axis=1)
    continuum = ((facts[..., 2] > 0) & good).any(axis=1)
    status = np.where(allowed, VERDICTS.index(Verdict.SOLVED), VERDICTS.index(Verdict.BEYOND_LIMITS))
    status[allowed & continuum] = VERDICTS.index(Verdict.CONTINUUM)
    status[~found] = VERDICTS.index(Verdict.OUT_OF_REACH)
    if setting.robot.n < 6 and setting.task == "pose":
        for i in np.flatnonzero(~found & poses):
            short = np.where(np.isfinite(facts[i, :, 1]), facts[i, :, 1], np.inf)
            step = missed(int(np.nan_to_num(facts[i, int(short.argmin()), 3]))) if short.min() > 1e-12 else Missed.NONE
            if step in (Missed.NONE, Missed.ORIENTATION):
                status[i] = VERDICTS.index(Verdict.NOT_OF_THIS_ARM)
    status[~poses] = VERDICTS.index(Verdict.NOT_A_POSE)
    return status.astype(np.int8)


def _one_by_one(setting: Setting, T: PoseMatrix, near: JointVector, tolerance: float) -> tuple[NDArray[Any], ...]:
    """Arms without an exact closed form of their own: lists proven by elimination at once, the others with care."""
    clean, valid = clean_poses(_finite(T))
    arm, count, n = setting.arm, len(T), setting.robot.n
    proven: Eliminated | None = None
    if arm.form is None and arm.general is not None and n == 6:
        proven = eliminated(setting, arm.general, np.where(valid[:, None, None], clean, np.nan), near)
    sure = np.zeros(count, dtype=np.bool_) if proven is None else proven.sure
    answers = {int(i): answered(Question(setting, clean[i], near, tolerance)) for i in np.flatnonzero(valid & ~sure)}
    most = max([len(one) for one in answers.values()] + ([] if proven is None else [proven.q.shape[1]]), default=0)
    q, residual = np.full((count, most, n), np.nan), np.full((count, most), np.nan)
    codes, loose = np.full((count, most), UNNAMED, dtype=np.int16), np.zeros((count, most), dtype=np.int32)
    if proven is not None:
        q[:, : proven.q.shape[1]], residual[:, : proven.q.shape[1]] = proven.q, proven.residual
    good = residual <= tolerance
    within = good & ((q >= setting.lower - 1e-12) & (q <= setting.upper + 1e-12)).all(axis=-1)
    status = np.where(within.any(axis=1), VERDICTS.index(Verdict.SOLVED), VERDICTS.index(Verdict.BEYOND_LIMITS))
    status[~valid] = VERDICTS.index(Verdict.NOT_A_POSE)
    for i, one in answers.items():
        k = len(one)
        q[i, :k], residual[i, :k], within[i, :k], codes[i, :k] = one.q, one.residual, one.within, one.codes
        loose[i, :k], good[i, :k], status[i] = one.free, True, VERDICTS.index(one.status)
    return q, good, within, residual, codes, loose, status.astype(np.int8)
