"""The answer to many poses: the rows of the closed form as they are, and the poses that need more care together.

1. The compiled closed form gives rows, facts and a decision for every pose, by chunks whose facts stay in cache.
2. Where the solutions are exact their rows are merged; where rows have to be refined that is done for all at once.
3. Poses of which nothing is proven then are searched one by one: free joints that have to be chosen, continua that
   cross, roots of an equation of fourth degree that are missing.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.ik.answers.almost_ideal import one_by_one
from mafsil.ik.answers.batch import VERDICTS, Columns, SolutionBatch
from mafsil.ik.answers.facts import Decision, Facts
from mafsil.ik.answers.lists import Lists, exact_lists, refined_lists
from mafsil.ik.answers.question import Question
from mafsil.ik.answers.redundant_batch import redundant_batch
from mafsil.ik.answers.refusal import beyond_reach, missed_step, out_of_plane, reached_places
from mafsil.ik.answers.search_batch import search_batch, searched
from mafsil.ik.answers.setting import Setting, turns_of
from mafsil.ik.answers.solution_set import SolutionSet
from mafsil.ik.answers.verdict import Verdict
from mafsil.ik.closed_form import ClosedForm
from mafsil.ik.problem import clean_poses
from mafsil.ik.redundant.eliminated_batch import counted_by_elimination, eliminated_batch
from mafsil.ik.redundant.parametric_form import has_redundant_joints
from mafsil.kernels import Kernel
from mafsil.mechanics.arm_pattern import Missed
from mafsil.mechanics.closed_form.thresholds import INSIDE

CHUNK = 4096
"""Poses whose facts are held at once; memory beyond the results does not grow with the batch."""

_CODE = {verdict: code for code, verdict in enumerate(VERDICTS)}


def solved_batch(setting: Setting, T: PoseMatrix, others: JointVector, tolerance: float) -> SolutionBatch:
    """All solutions of a batch.

    Args:
        setting: the arm.
        T: (*batch, 4, 4) poses.
        others: (n,) values that free and held joints take, and joints that do not move the frame.
        tolerance: largest residual of a solution.
    """
    near = setting.part.own(others)
    flat = np.ascontiguousarray(T.reshape(-1, 4, 4))
    if setting.kernel is not None:
        columns = _Judged(setting, setting.kernel, near, tolerance).columns(flat)
    elif has_redundant_joints(setting):
        columns = Columns(*redundant_batch(setting, flat, near, tolerance))
    elif counted_by_elimination(setting):
        columns = Columns(*eliminated_batch(setting, flat, near, tolerance))
    elif searched(setting):
        columns = Columns(*search_batch(setting, flat, near, tolerance))
    else:
        columns = one_by_one(setting, flat, near, tolerance)
    return SolutionBatch(columns, setting, T, others, tolerance)


class _Rest(NamedTuple):
    """Poses of a batch whose lists are not clear.

    Attributes:
        at: (k,) which they are.
        T: (k, 4, 4) poses.
        facts: of their rows.
        decision: (k,) about each.
    """

    at: NDArray[np.intp]
    T: PoseMatrix
    facts: Facts
    decision: Floats

    def where(self, which: NDArray[np.bool_]) -> _Rest:
        """Some of them."""
        return _Rest(self.at[which], self.T[which], self.facts.at(which), self.decision[which])


class _Judged:
    """Batches by the compiled closed form of one arm."""

    def __init__(self, setting: Setting, kernel: Kernel, near: JointVector, tolerance: float) -> None:
        assert setting.arm.form is not None
        self.setting, self.kernel, self.near, self.tolerance = setting, kernel, near, tolerance
        self.form: ClosedForm = setting.arm.form
        self.wishes = near, turns_of(near), *setting.bounds, np.asarray(tolerance)

    def columns(self, T: PoseMatrix) -> Columns:
        """The results of poses (k, 4, 4)."""
        count, rows, n = len(T), self.form.pattern.branches, self.setting.robot.n
        made = Columns(
            np.empty((count, rows, n)),
            np.empty((count, rows), dtype=np.bool_),
            np.empty((count, rows), dtype=np.bool_),
            np.empty((count, rows)),
            np.empty((count, rows), dtype=np.int16),
            np.zeros((count, rows), dtype=np.int32),
            np.empty(count, dtype=np.int8),
        )
        known, decision = np.empty((min(count, CHUNK), rows, 6)), np.empty(min(count, CHUNK))
        waiting: list[tuple[NDArray[np.intp], Floats, Floats]] = []
        for begin in range(0, count, CHUNK):
            end = min(begin + CHUNK, count)
            facts, decided = known[: end - begin], decision[: end - begin]
            self.kernel(T[begin:end], *self.wishes, out=(made.q[begin:end], facts, decided))
            self._fill(Columns._make(column[begin:end] for column in made), Facts.of(facts))
            rest = np.flatnonzero(decided <= 0.0)
            if len(rest):
                waiting.append((begin + rest, facts[rest], decided[rest]))
            if waiting and (end == count or sum(len(one[0]) for one in waiting) >= CHUNK):
                at, columns, decisions = (np.concatenate(parts) for parts in zip(*waiting, strict=True))
                self._settle(made, _Rest(at, T[at], Facts.of(columns), decisions))
                waiting = []
        return made

    def _fill(self, columns: Columns, facts: Facts) -> None:
        """Facts and statuses as if all poses were clear."""
        columns.residual[...] = facts.residual
        np.less_equal(facts.residual, self.tolerance, out=columns.valid)
        np.less_equal(facts.excess, INSIDE, out=columns.within)
        np.logical_and(columns.within, columns.valid, out=columns.within)
        with np.errstate(invalid="ignore"):
            columns.codes[...] = facts.code
        allowed = columns.within.any(axis=1)
        columns.status[...] = np.where(allowed, _CODE[Verdict.SOLVED], _CODE[Verdict.BEYOND_LIMITS])

    def _settle(self, columns: Columns, rest: _Rest) -> None:
        """Poses whose lists are not clear."""
        columns.codes[rest.at] = np.nan_to_num(rest.facts.code)
        none = rest.at[rest.decision == Decision.NO_POSE]
        columns.valid[none], columns.within[none] = False, False
        columns.status[none] = _CODE[Verdict.NOT_A_POSE]
        self._refuse(columns, rest.where(rest.decision == Decision.NONE))
        exact = rest.where((rest.decision == Decision.REPEATED) | (rest.decision == Decision.MEETING))
        if len(exact.at):
            lists = exact_lists(self.setting, exact.T, columns.q[exact.at], exact.facts, self.tolerance)
            self._write(columns, exact, lists)
        careful = rest.where(rest.decision == Decision.CAREFUL)
        if not len(careful.at):
            return
        clean, _ = clean_poses(careful.T)
        rows = columns.q[careful.at], careful.facts, self.tolerance
        lists = refined_lists(self.setting, self.form, clean, self.near, rows)
        closed = ~lists.open
        self._write(columns, careful.where(closed), Lists._make(column[closed] for column in lists))
        for k in np.flatnonzero(lists.open):
            answer = Question(self.setting, clean[k], self.near, self.tolerance).answer()
            _place(columns, int(careful.at[k]), answer)

    def _write(self, columns: Columns, rest: _Rest, lists: Lists) -> None:
        """Lists of some poses into the results."""
        at = rest.at
        columns.q[at], columns.residual[at], columns.codes[at] = lists.q, lists.residual, lists.codes
        columns.valid[at], columns.within[at], columns.free[at] = lists.valid, lists.within, lists.free
        found = np.asarray(lists.valid.any(axis=1), dtype=np.bool_)
        allowed, moving = lists.within.any(axis=1), (lists.free > 0).any(axis=1)
        status = np.where(allowed, _CODE[Verdict.SOLVED], _CODE[Verdict.BEYOND_LIMITS])
        status[allowed & moving] = _CODE[Verdict.CONTINUUM]
        status[~allowed & moving] = _CODE[Verdict.NOT_FOUND_WITHIN_LIMITS]
        columns.status[at] = status
        self._refuse(columns, rest.where(~found))

    def _refuse(self, columns: Columns, rest: _Rest) -> None:
        """The statuses of poses without a solution: what the closed form proves."""
        setting, at = self.setting, rest.at
        columns.valid[at], columns.within[at] = False, False
        columns.status[at] = _CODE[Verdict.OUT_OF_REACH]
        if not setting.few or setting.task != "pose" or not len(at):
            return
        elsewhere = np.zeros(len(at), dtype=np.bool_)
        for k in range(len(at)):
            step = missed_step(rest.facts.at(k))
            off = step in (Missed.NONE, Missed.ORIENTATION) or out_of_plane(setting, rest.T[k])
            elsewhere[k] = bool(off) and not beyond_reach(setting, rest.T[k])
        open_poses = np.flatnonzero(~elsewhere)
        if len(open_poses):
            elsewhere[open_poses] = reached_places(setting, rest.T[open_poses])
        columns.status[at[elsewhere]] = _CODE[Verdict.NOT_OF_THIS_ARM]


def _place(columns: Columns, i: int, answer: SolutionSet) -> None:
    """The answer to one pose that was searched, into its rows as far as there are enough."""
    count = columns.valid.shape[1]
    columns.valid[i], columns.within[i], columns.free[i] = False, False, 0
    # Solutions found otherwise, and second ones of a row, take the rows that are left; of continua there may be more.
    rows, left = answer.rows.copy(), np.setdiff1d(np.arange(count), answer.rows)
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
    columns.status[i] = _CODE[answer.status]
