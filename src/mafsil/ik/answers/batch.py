"""All solutions of many poses at once: padded arrays, and the careful answer to any one of them by its index."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.errors import InputError
from mafsil.ik.answers.branch import UNNAMED, Branch, branch, missed
from mafsil.ik.answers.eliminated import Eliminated, eliminated
from mafsil.ik.answers.question import FOLD, LOOSE, Question
from mafsil.ik.answers.redundant_batch import redundant_batch
from mafsil.ik.answers.refined_rows import beside_folds, refinable, refined_rows
from mafsil.ik.answers.refusal import beyond_reach, out_of_plane, reached_places
from mafsil.ik.answers.search_batch import search_batch, searched
from mafsil.ik.answers.setting import CLEAR, Setting, turns_of
from mafsil.ik.answers.solution_set import SolutionSet, wound_near
from mafsil.ik.answers.verdict import Verdict
from mafsil.ik.general.findings import MOST
from mafsil.ik.problem import FARTHEST, ORTHOGONALITY, clean_poses
from mafsil.ik.redundant.eliminated_batch import counted_by_elimination, eliminated_batch
from mafsil.ik.redundant.fixed import answered
from mafsil.ik.redundant.parametric_form import has_redundant_joints
from mafsil.kernels import Kernel
from mafsil.mechanics.arm_pattern import Missed
from mafsil.messages import say

VERDICTS = tuple(Verdict)
_MEMBERS = np.array(VERDICTS, dtype=np.object_)

CHUNK = 8192
"""Poses whose facts are held at once; memory beyond the results does not grow with the batch."""

APART = 1e-4
"""Marks below which rows are looked at for being the same solution."""


PROBE = 8
"""Poses after which it is known whether elimination proves the lists of an arm."""

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
    others: JointVector
    tolerance: float

    def __len__(self) -> int:
        return len(self.q)

    def __bool__(self) -> bool:
        return bool(self.solved.all())

    def __iter__(self) -> Iterator[SolutionSet]:
        if self.q.ndim > 3:
            raise InputError("ik.many_dimensions", shape=self.status_codes.shape)
        return (self[i] for i in range(len(self.q)))

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

    @property
    def status(self) -> NDArray[np.object_]:
        """(*batch,) what can be said about each pose, members of `Verdict`."""
        return _MEMBERS[self.status_codes]

    def explain(self, *index: int, language: str | None = None) -> str:
        """The answer to one pose in sentences; without an index how many poses have which status.

        Raises:
            InputError: the row is not a pose.
        """
        if index:
            return self[index].explain(language)
        lines = [say("ik.batch", language=language, solved=int(self.solved.sum()), count=self.solved.size)]
        for code in np.unique(self.status_codes):
            verdict, count = VERDICTS[int(code)], int((self.status_codes == code).sum())
            first = ", ".join(str(int(i[0])) for i in np.nonzero(self.status_codes == code))
            name = say(f"ik.name_{verdict.name.lower()}", language=language)
            lines.append(say("ik.batch_status", language=language, status=name, count=count, first=first))
        return "\n".join(lines)

    def __getitem__(self, index: int | tuple[int, ...]) -> SolutionSet:
        """The careful answer to one pose, with families and reasons.

        Raises:
            InputError: the row is not a pose.
        """
        clean, valid = clean_poses(_finite(self.T[index].reshape(1, 4, 4)))
        if not valid[0]:
            raise InputError("ik.no_pose", name=f"T_sd[{index}]", limit=ORTHOGONALITY)
        part = self.setting.part
        return answered(Question(self.setting, clean[0], part.own(self.others), self.tolerance, self.others))

    def nearest(self, q: JointVector) -> JointVector:
        """(*batch, n) for every pose the solution nearest to a configuration, within the limits if any is; NaN if none.

        Args:
            q: (n,) or (*batch, n).
        """
        part = self.setting.part
        start = np.asarray(q, dtype=np.float64)[..., None, :]
        wound = wound_near(self.q, start, part.lower, part.upper, part.turning)
        if part.places is not None:
            wound = part.lifted(part.own(wound), start)
        cost = np.linalg.norm(wound - start, axis=-1) + np.where(self.within, 0.0, 1e6)
        cost = np.where(self.valid, cost, np.inf)
        best = cost.argmin(axis=-1)[..., None]
        chosen = np.take_along_axis(wound, best[..., None], axis=-2)[..., 0, :]
        return np.where(np.isfinite(np.take_along_axis(cost, best, axis=-1)), chosen, np.nan)


def solved_batch(setting: Setting, T: PoseMatrix, others: JointVector, tolerance: float) -> SolutionBatch:
    """All solutions of a batch.

    Args:
        setting: the arm.
        T: (*batch, 4, 4) poses.
        others: (n,) values that free and held joints take, and joints that do not move the frame.
        tolerance: largest residual of a solution.
    """
    part = setting.part
    near = part.own(others)
    flat = np.ascontiguousarray(T.reshape(-1, 4, 4))
    kernel = setting.kernel
    if kernel is not None and setting.arm.form is not None:
        parts = _compiled(setting, kernel, setting.arm.form.pattern.branches, flat, near, tolerance)
    elif has_redundant_joints(setting):
        parts = redundant_batch(setting, flat, near, tolerance)
    elif counted_by_elimination(setting):
        parts = eliminated_batch(setting, flat, near, tolerance)
    elif searched(setting):
        parts = search_batch(setting, flat, near, tolerance)
    else:
        parts = _one_by_one(setting, flat, near, tolerance)
    shape = T.shape[:-2]
    q, valid, within, residual, codes, free, status = (one.reshape(*shape, *one.shape[1:]) for one in parts)
    q, free = part.lifted(q, others), part.lifted_bits(free)
    return SolutionBatch(q, valid, within, residual, codes, free, status, setting, T, others, tolerance)


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
        odd = ((facts[..., 0] <= max(setting.candidate, tolerance)) & (facts[..., 0] > CLEAR)) | (
            good & (free | (facts[..., 4] <= MERGED))
        )
        # Without an exact solution the nearest posture may be within the tolerance.
        nearest = np.minimum(facts[..., 0], facts[..., 1])
        if setting.few:
            # Whose steps may all succeed and the added joints move: only at folds does that say nothing.
            nearest = np.where(free | (facts[..., 4] <= FOLD), nearest, facts[..., 0])
        nearly = 1e3 * tolerance if tolerance > LOOSE else LOOSE
        odd |= (nearest <= nearly) & ~good.any(axis=1, keepdims=True)
        odd |= setting.folded(facts)
        if setting.quartic:
            odd |= (facts[..., 4] <= FOLD) | ~good.any(axis=1, keepdims=True)
        lost = ~(good & inside).any(axis=1) & (free & poses[:, None]).any(axis=1)
        careful = (odd.any(axis=1) | lost) & poses
        close = good.any(axis=1) & ~careful
        if setting.plain and not setting.quartic:
            close &= (good & (facts[..., 4] < APART)).any(axis=1)
        _merge(setting, np.flatnonzero(close), out, good)
        told: dict[int, Verdict] = {}
        for i in np.flatnonzero(careful):
            question = Question(setting, clean_poses(T[begin + i][None])[0][0], near, tolerance)
            told[int(i)] = _careful(question, int(i), out, facts, good, inside)
        q[part], residual[part], valid[part], within[part] = out, facts[..., 0], good, good & inside
        codes[part], loose[part] = np.nan_to_num(facts[..., 3]), np.where(good, facts[..., 2], 0.0)
        status[part] = _statuses(setting, T[part], facts, good, within[part], poses)
        for i, verdict in told.items():
            status[begin + i] = VERDICTS.index(verdict)
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
    """Rows with NaN, infinities or numbers that would overflow as zeros, which are no poses either."""
    finite = np.asarray((np.abs(T) < FARTHEST).all(axis=(1, 2)), dtype=np.bool_)
    return T if finite.all() else np.where(finite[:, None, None], T, 0.0)


def _careful(
    question: Question, i: int, q: Floats, facts: Floats, good: NDArray[np.bool_], inside: NDArray[np.bool_]
) -> Verdict:
    """One pose with refinement, merging and free joints; its rows are written back."""
    answer = question.answer()
    good[i] = False
    # Solutions found otherwise, and second ones of a row, take the rows that are left; of continua there may be more.
    rows, left = answer.rows.copy(), np.setdiff1d(np.arange(len(good[i])), answer.rows)
    again = np.flatnonzero((rows < 0) | (np.arange(len(rows)) != np.array([list(rows).index(row) for row in rows])))
    rows[again[: len(left)]] = left[: len(again)]
    kept = np.setdiff1d(np.arange(len(rows)), again[len(left) :])
    rows = rows[kept]
    q[i, rows], facts[i, rows, 0], facts[i, rows, 3] = answer.own[kept], answer.residual[kept], answer.codes[kept]
    facts[i, rows, 2] = 0
    names = question.setting.robot.joint_names
    for family in answer.families:
        bit = 1 << names.index(family.joint)
        for row in rows[kept == family.solution]:
            facts[i, row, 2] = int(facts[i, row, 2]) | bit
    good[i, rows], inside[i, rows] = True, answer.within[kept]
    return answer.status


def _statuses(
    setting: Setting,
    T: PoseMatrix,
    facts: Floats,
    good: NDArray[np.bool_],
    within: NDArray[np.bool_],
    poses: NDArray[np.bool_],
) -> NDArray[np.int8]:
    """What the closed form proves of each pose."""
    found, allowed = good.any(axis=1), within.any(axis=1)
    continuum = ((facts[..., 2] > 0) & good).any(axis=1)
    status = np.where(allowed, VERDICTS.index(Verdict.SOLVED), VERDICTS.index(Verdict.BEYOND_LIMITS))
    status[allowed & continuum] = VERDICTS.index(Verdict.CONTINUUM)
    status[~found] = VERDICTS.index(Verdict.OUT_OF_REACH)
    if setting.robot.n < 6 and setting.task == "pose":
        for i in np.flatnonzero(~found & poses):
            short = np.where(np.isfinite(facts[i, :, 1]), facts[i, :, 1], np.inf)
            step = missed(int(np.nan_to_num(facts[i, int(short.argmin()), 3]))) if short.min() > 1e-12 else Missed.NONE
            off = step in (Missed.NONE, Missed.ORIENTATION) or out_of_plane(setting, T[i])
            if off and not beyond_reach(setting, T[i]):
                status[i] = VERDICTS.index(Verdict.NOT_OF_THIS_ARM)
        status[_reached_elsewhere(setting, T, status)] = VERDICTS.index(Verdict.NOT_OF_THIS_ARM)
    status[~poses] = VERDICTS.index(Verdict.NOT_A_POSE)
    return status.astype(np.int8)


def _refined(setting: Setting, T: PoseMatrix, near: JointVector) -> Eliminated:
    """Lists of an almost ideal arm: rows away from folds refined; beside them by elimination where it proves lists.

    Where it proves none, as with wrists that nearly meet, rows are sought on both sides of the folds. Poses without a
    solution within the limits are left open.
    """
    found = refined_rows(setting, T, near)
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
            listed = eliminated(setting, general, T[part], near)
            q[part], residual[part], sure[part] = listed.q, listed.residual, listed.sure
            general = general if 2 * listed.sure.sum() >= len(part) else None
        part = part[~sure[part]]
        if len(part):
            q[part], residual[part] = beside_folds(setting, T[part], near)
            sure[part] = (np.isfinite(residual[part]) & setting.allowed(q[part])).any(axis=1)
    return Eliminated(sure, q, residual, codes)


def _reached_elsewhere(setting: Setting, T: PoseMatrix, status: NDArray[np.int8]) -> NDArray[np.intp]:
    """Poses said to be out of reach whose place alone can be reached."""
    rows = np.flatnonzero((status == VERDICTS.index(Verdict.OUT_OF_REACH)) & np.isfinite(T).all(axis=(1, 2)))
    return rows[reached_places(setting, T[rows])] if len(rows) else rows


def _one_by_one(setting: Setting, T: PoseMatrix, near: JointVector, tolerance: float) -> tuple[NDArray[Any], ...]:
    """Arms without an exact closed form of their own: lists proven by elimination at once, the others with care."""
    clean, valid = clean_poses(_finite(T))
    arm, count, n = setting.arm, len(T), setting.robot.n
    proven: Eliminated | None = None
    asked = np.where(valid[:, None, None], clean, np.nan)
    if arm.form is None and arm.general is not None and n == 6:
        proven = eliminated(setting, arm.general, asked, near)
    elif refinable(setting):
        proven = _refined(setting, asked, near)
    sure = np.zeros(count, dtype=np.bool_) if proven is None else proven.sure
    answers = {int(i): answered(Question(setting, clean[i], near, tolerance)) for i in np.flatnonzero(valid & ~sure)}
    most = max([len(one) for one in answers.values()] + ([] if proven is None else [proven.q.shape[1]]), default=0)
    q, residual = np.full((count, most, n), np.nan), np.full((count, most), np.nan)
    codes, loose = np.full((count, most), UNNAMED, dtype=np.int16), np.zeros((count, most), dtype=np.int32)
    if proven is not None:
        q[:, : proven.q.shape[1]], residual[:, : proven.q.shape[1]] = proven.q, proven.residual
        codes[:, : proven.q.shape[1]] = UNNAMED if proven.codes is None else proven.codes
    good = residual <= tolerance
    within = good & ((q >= setting.lower - 1e-12) & (q <= setting.upper + 1e-12)).all(axis=-1)
    status = np.where(within.any(axis=1), VERDICTS.index(Verdict.SOLVED), VERDICTS.index(Verdict.BEYOND_LIMITS))
    status[~good.any(axis=1)] = VERDICTS.index(Verdict.OUT_OF_REACH)
    status[~valid] = VERDICTS.index(Verdict.NOT_A_POSE)
    for i, one in answers.items():
        k = len(one)
        q[i, :k], residual[i, :k], within[i, :k], codes[i, :k] = one.own, one.residual, one.within, one.codes
        loose[i, :k], good[i, :k], status[i] = one.own_free, True, VERDICTS.index(one.status)
    return q, good, within, residual, codes, loose, status.astype(np.int8)
