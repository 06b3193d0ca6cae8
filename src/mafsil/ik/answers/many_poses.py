"""The answer to many poses: the rows of the closed form as they are, and the poses that need more care together.

1. The compiled closed form gives rows, details and a decision for every pose, by chunks whose details stay in cache.
2. Where the solutions are exact their rows are merged; where rows have to be refined that is done for all at once.
3. Poses of which nothing is proven then are searched one by one: free joints that have to be chosen, continua that
   cross, roots of an equation of fourth degree that are missing.
"""

from __future__ import annotations

from functools import partial
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mafsil import threads
from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.ik.answers.batch import Columns, SolutionBatch, finite_poses
from mafsil.ik.answers.branch import UNNAMED
from mafsil.ik.answers.candidate_table import CandidateTable, Decision
from mafsil.ik.answers.eliminated import Eliminated, beside_folds, eliminate_poses, refinable, refined_rows
from mafsil.ik.answers.lists import Lists, exact_lists, moving_joints, refined_lists
from mafsil.ik.answers.question import Question
from mafsil.ik.answers.redundant_batch import redundant_batch
from mafsil.ik.answers.refusal import beyond_reach, failed_step_of, out_of_plane, reached_places
from mafsil.ik.answers.setting import Setting, turns_of
from mafsil.ik.answers.solution_set import SolutionSet
from mafsil.ik.general.findings import MOST
from mafsil.ik.redundant.at_parameter import answer_at
from mafsil.ik.redundant.eliminated_batch import (
    counted_by_elimination,
    eliminated_batch,
    is_search_only,
    search_batch,
)
from mafsil.ik.redundant.parametric_form import has_redundant_joints
from mafsil.ik.result import CODES, IKStatus, clean_poses
from mafsil.ik.structure.closed_form import ClosedForm
from mafsil.kernels import Kernel
from mafsil.mechanics.arm_pattern import APART, ON_LIMIT, FailedStep

PROBE = 8
"""Poses after which it is known whether elimination proves the lists of an arm."""
CHUNK = 2048
"""Poses whose details a thread keeps at once; memory beyond the results does not grow with the batch."""
BLOCK = 32
"""Chunks that are handed to threads together."""
FEW = 256
"""Poses of a batch whose details are kept, so that masks, residuals and statuses are made when they are read."""
_WORK: list[Floats] = []
"""Room for details, one for each thread that asks: fresh memory takes the system longer than the kernel its numbers."""


def solved_batch(setting: Setting, T: PoseMatrix, others: JointVector, tolerance: float) -> SolutionBatch:
    """All solutions of a batch.

    Args:
        setting: the arm.
        T: (*batch, 4, 4) poses.
        others: (n,) values that free and locked joints take, and joints that do not move the frame.
        tolerance: largest residual of a solution.
    """
    q0, request = setting.part.own(others), (setting, T, others, tolerance)
    flat = np.ascontiguousarray(T.reshape(-1, 4, 4))
    if setting.kernel is not None:
        judged = _Judged(setting, setting.kernel, q0, tolerance)
        if len(flat) <= FEW:
            return SolutionBatch(judged.few(flat), judged.columns, request, judged.certify_self_motions)
        judged.many(flat)
        return SolutionBatch(judged.columns().q, judged.columns, request, judged.certify_self_motions)
    if has_redundant_joints(setting):
        columns = Columns(*redundant_batch(setting, flat, q0, tolerance))
    elif counted_by_elimination(setting):
        columns = Columns(*eliminated_batch(setting, flat, q0, tolerance))
    elif is_search_only(setting):
        columns = Columns(*search_batch(setting, flat, q0, tolerance))
    else:
        columns = one_by_one(setting, flat, q0, tolerance)
    return SolutionBatch(columns.q, lambda: columns, request)


class _Rest(NamedTuple):
    """Poses of a batch whose lists are not clear.

    Attributes:
        at: (k,) which they are.
        T: (k, 4, 4) poses.
        details: of their rows.
        decision: (k,) about each.
    """

    at: NDArray[np.intp]
    T: PoseMatrix
    details: CandidateTable
    decision: Floats

    def where(self, which: NDArray[np.bool_]) -> _Rest:
        """Some of them."""
        return _Rest(self.at[which], self.T[which], self.details.at(which), self.decision[which])


_Unclear: TypeAlias = tuple[NDArray[np.intp], Floats, Floats]
"""Poses of a chunk whose lists are not clear: which they are, details of their rows, decisions."""


class _Judged:
    """A batch by the compiled closed form of one arm."""

    def __init__(self, setting: Setting, kernel: Kernel, q0: JointVector, tolerance: float) -> None:
        assert setting.arm.form is not None
        self.setting, self.kernel, self.q0, self.tolerance = setting, kernel, q0, tolerance
        self.form: ClosedForm = setting.arm.form
        quick = setting.quick
        assert quick is not None
        preferred = quick.preferences if q0 is setting.middle else (q0, turns_of(q0), *setting.bounds)
        self.preferences = *preferred, np.asarray(tolerance)
        self._pending: list[tuple[_Rest, NDArray[np.bool_]]] = []
        self._columns: Columns | None = None

    def few(self, T: PoseMatrix) -> JointVector:
        """The coordinates of a batch so small that its details are kept until something of them is read."""
        q, known, decision = self.kernel.ufunc(T, *self.preferences)
        self._waiting = T, q, CandidateTable.of(known), decision
        if not (decision > 0.0).all():
            self.columns()
        return q

    def columns(self) -> Columns:
        """The results, made when they are first request for."""
        if self._columns is None:
            T, q, details, decision = self._waiting
            self._columns = columns = _empty(q)
            self._fill(columns, details)
            rest = np.flatnonzero(~(decision > 0.0))
            if len(rest):
                self._settle(columns, _Rest(rest, T[rest], details.at(rest), decision[rest]))
        return self._columns

    def many(self, T: PoseMatrix) -> None:
        """The results of poses (k, 4, 4), chunk by chunk; those of a block on all threads."""
        count, rows, n = len(T), self.form.pattern.branches, self.setting.robot.n
        self._columns = made = _empty(np.empty((count, rows, n)))
        chunk = min(CHUNK, max(FEW, -(-count // threads.available())))
        begins, waiting = range(0, count, chunk), list[_Unclear]()
        for first in range(0, len(begins), BLOCK):
            block = begins[first : first + BLOCK]
            found: list[_Unclear | None] = [None] * len(block)
            threads.run(partial(self._chunk, T, made, block, found), len(block), threads.available())
            waiting += [one for one in found if one is not None]
            if waiting and (first + BLOCK >= len(begins) or sum(len(one[0]) for one in waiting) >= CHUNK):
                at, columns, decisions = (np.concatenate(parts) for parts in zip(*waiting, strict=True))
                self._settle(made, _Rest(at, T[at], CandidateTable.of(columns), decisions))
                waiting = []

    def _chunk(self, T: PoseMatrix, made: Columns, begins: range, found: list[_Unclear | None], k: int) -> None:
        """One chunk of a block, into the results; what is not clear is put aside."""
        rows, begin = self.form.pattern.branches, begins[k]
        end, size = min(begin + begins.step, len(T)), CHUNK * (6 * rows + 1)
        try:
            kept = _WORK.pop()
        except IndexError:
            kept = np.empty(0)
        kept = kept if kept.size >= size else np.empty(size)
        details, decided = kept[CHUNK:size].reshape(CHUNK, rows, 6)[: end - begin], kept[: end - begin]
        self.kernel(T[begin:end], *self.preferences, out=(made.q[begin:end], details, decided), threads=1)
        self._fill(Columns._make(column[begin:end] for column in made), CandidateTable.of(details))
        rest = np.flatnonzero(~(decided > 0.0))
        if len(rest):
            found[k] = begin + rest, details[rest], decided[rest]
        _WORK.append(kept)

    def _fill(self, columns: Columns, details: CandidateTable) -> None:
        """Details and statuses as if all poses were clear."""
        columns.residual[...] = details.residual
        np.less_equal(columns.residual, self.tolerance, out=columns.valid)
        np.less_equal(details.excess, ON_LIMIT, out=columns.within)
        np.logical_and(columns.within, columns.valid, out=columns.within)
        with np.errstate(invalid="ignore"):
            columns.codes[...] = details.code
        np.multiply(_no_row(columns.within), CODES[IKStatus.BEYOND_LIMITS], out=columns.status, casting="unsafe")

    def certify_self_motions(self) -> None:
        """Free coordinates and statuses of exact solutions that may move though no joint of the closed form is free."""
        columns = self.columns()
        for rest, uncertain in self._pending:
            pose_of, row = np.nonzero(uncertain)
            if not len(row):
                continue
            at = rest.at[pose_of]
            joint = moving_joints(self.setting, columns.q[at, row], rest.T[pose_of], self.tolerance)
            columns.free[at, row] = np.where(joint >= 0, 1 << np.maximum(joint, 0), 0)
            self._judge(columns, at[joint >= 0])
        self._pending = []

    def _settle(self, columns: Columns, rest: _Rest) -> None:
        """Poses whose lists are not clear."""
        columns.codes[rest.at] = np.nan_to_num(rest.details.code)
        none = rest.at[rest.decision == Decision.NO_POSE]
        columns.valid[none], columns.within[none] = False, False
        columns.status[none] = CODES[IKStatus.NOT_A_POSE]
        self._refuse(columns, rest.where(rest.decision == Decision.NONE))
        exact = rest.where((rest.decision == Decision.REPEATED) | (rest.decision == Decision.MEETING))
        if len(exact.at):
            lists = exact_lists(self.setting, columns.q[exact.at], exact.details, self.tolerance)
            self._write(columns, exact, lists)
            uncertain = lists.valid & (lists.free == 0) & (exact.details.margin <= APART)
            self._pending.append((exact, uncertain))
        careful = rest.where(rest.decision == Decision.CAREFUL)
        if not len(careful.at):
            return
        clean, _ = clean_poses(careful.T)
        searched = np.arange(len(clean))
        if self.setting.arm.general is None:
            rows = columns.q[careful.at], careful.details, self.tolerance
            lists = refined_lists(self.setting, self.form, clean, self.q0, rows)
            closed, searched = ~lists.open, np.flatnonzero(lists.open)
            self._write(columns, careful.where(closed), Lists._make(column[closed] for column in lists))
        for k in searched:
            answer = Question(self.setting, clean[k], self.q0, self.tolerance).answer()
            _place(columns, int(careful.at[k]), answer)

    def _write(self, columns: Columns, rest: _Rest, lists: Lists) -> None:
        """Lists of some poses into the results."""
        at = rest.at
        columns.q[at], columns.residual[at], columns.codes[at] = lists.q, lists.residual, lists.codes
        columns.valid[at], columns.within[at], columns.free[at] = lists.valid, lists.within, lists.free
        self._judge(columns, at)
        # Where the closed form's own free joints are, it has decided that none of their values leads into the limits.
        decided = ~lists.within.any(axis=1) & (lists.free > 0).any(axis=1)
        columns.status[at[decided]] = CODES[IKStatus.BEYOND_LIMITS]
        self._refuse(columns, rest.where(_no_row(lists.valid)))

    def _judge(self, columns: Columns, at: NDArray[np.intp]) -> None:
        """The statuses of poses with solutions."""
        none, moving = _no_row(columns.within[at]), (columns.free[at] > 0).any(axis=1)
        status = np.where(none, CODES[IKStatus.BEYOND_LIMITS], CODES[IKStatus.SOLVED])
        status[~none & moving] = CODES[IKStatus.CONTINUUM]
        status[none & moving] = CODES[IKStatus.NOT_FOUND_WITHIN_LIMITS]
        columns.status[at] = status

    def _refuse(self, columns: Columns, rest: _Rest) -> None:
        """The statuses of poses without a solution: what the closed form proves."""
        setting, at = self.setting, rest.at
        columns.valid[at], columns.within[at] = False, False
        columns.status[at] = CODES[IKStatus.OUT_OF_REACH]
        if not setting.few or setting.task != "pose" or not len(at):
            return
        elsewhere = np.zeros(len(at), dtype=np.bool_)
        for k in range(len(at)):
            step = failed_step_of(rest.details.at(k))
            off = step in (FailedStep.NONE, FailedStep.ORIENTATION) or out_of_plane(setting, rest.T[k])
            elsewhere[k] = bool(off) and not beyond_reach(setting, rest.T[k])
        open_poses = np.flatnonzero(~elsewhere)
        if len(open_poses):
            elsewhere[open_poses] = reached_places(setting, rest.T[open_poses])
        columns.status[at[elsewhere]] = CODES[IKStatus.NOT_OF_THIS_ARM]


def _empty(q: JointVector) -> Columns:
    """Room for the results beside the coordinates; no joint is free."""
    shape = q.shape[:2]
    valid, within = np.empty(shape, dtype=np.bool_), np.empty(shape, dtype=np.bool_)
    codes, free = np.empty(shape, dtype=np.int16), np.zeros(shape, dtype=np.int32)
    return Columns(q, valid, within, np.empty(shape), codes, free, np.empty(len(q), dtype=np.int8))


def _no_row(rows: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(k,) whether none of the rows (k, rows) is true; eight of them are looked at as one number."""
    if rows.shape[1] in (8, 16) and rows.flags.c_contiguous:
        return np.asarray((rows.view(np.uint64) == 0).all(axis=1), dtype=np.bool_)
    return np.asarray(~rows.any(axis=1), dtype=np.bool_)


def _place(columns: Columns, i: int, answer: SolutionSet) -> None:
    """The answer to one pose that was searched, into its rows as far as there are enough."""
    count: int = columns.valid.shape[1]
    columns.valid[i], columns.within[i], columns.free[i] = False, False, 0
    # Solutions found otherwise, and second ones of a row, take the rows that are left; of continua there may be more.
    rows: NDArray[np.int64] = answer.rows.copy()
    left = np.setdiff1d(np.arange(count), rows)
    _, first = np.unique(rows, return_index=True)
    again = np.flatnonzero((rows < 0) | ~np.isin(np.arange(len(rows)), first))
    rows[again[: len(left)]] = left[: len(again)]
    kept = np.setdiff1d(np.arange(len(rows)), again[len(left) :])
    rows = rows[kept]
    columns.q[i, rows], columns.residual[i, rows] = answer.own[kept], answer.residual[kept]
    columns.codes[i, rows], columns.free[i, rows] = answer.codes[kept], answer.own_free[kept]
    for family in answer.families:
        columns.free[i, rows[kept == family.solution]] |= 1 << answer.own_names.index(family.joint)
    columns.valid[i, rows], columns.within[i, rows] = True, answer.within[kept]
    columns.status[i] = CODES[answer.status]


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
        if proven is not None and i in proven.found:
            question.know(proven.found[i])
        answers[i] = answer_at(question)
    known = 0 if proven is None else proven.q.shape[1]
    most = max([len(one) for one in answers.values()] + [known], default=0)
    codes, loose = np.full((count, most), UNNAMED, dtype=np.int16), np.zeros((count, most), dtype=np.int32)
    if proven is not None and most == known:
        q, residual, within = proven.q, proven.residual, proven.within
    else:
        q, residual = np.full((count, most, n), np.nan), np.full((count, most), np.nan)
        within = np.zeros((count, most), dtype=np.bool_)
        if proven is not None:
            q[:, :known], residual[:, :known], within[:, :known] = proven.q, proven.residual, proven.within
    if proven is not None and proven.codes is not None:
        codes[:, :known] = proven.codes
    good = residual <= tolerance
    within &= good
    status = np.where(_no_row(within), CODES[IKStatus.BEYOND_LIMITS], CODES[IKStatus.SOLVED])
    status[_no_row(good)] = CODES[IKStatus.OUT_OF_REACH]
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
    within: NDArray[np.bool_] = np.asarray(
        ((q >= setting.lower - ON_LIMIT) & (q <= setting.upper + ON_LIMIT)).all(axis=-1)
    )
    return Eliminated(sure, q, residual, within, codes)
