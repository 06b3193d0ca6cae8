"""Batches for arms whose closed form holds one joint: its value is chosen for every pose, one kernel does the rest."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.ik.answers.question import Question
from mafsil.ik.answers.setting import CLEAR, Setting, turns_of
from mafsil.ik.answers.solution_set import SolutionSet
from mafsil.ik.answers.start import SCAN
from mafsil.ik.answers.verdict import Verdict
from mafsil.ik.closed_form import ClosedForm
from mafsil.ik.problem import clean_poses
from mafsil.ik.redundant.held import held_values

VERDICTS = tuple(Verdict)

CHUNK = 512
"""Poses whose facts are held at once."""

FINE = 240
"""Values of the held joint that are tried before intervals are made."""

MERGED = 1e-7
"""Marks up to which a solution may be the member of a further continuum."""

APART = 1e-4
"""Marks below which two rows may be the same solution."""


def held_batch(setting: Setting, T: PoseMatrix, near: JointVector, tolerance: float) -> tuple[NDArray[Any], ...]:
    """All solutions of many poses with the held joint at `near`, or at the nearest tried value that leads to any.

    Poses without a solution within the limits so far, and those near singular postures, are answered one by one.

    Args:
        setting: an arm whose exact closed form holds one joint.
        T: (k, 4, 4) poses; rows that are none are told so.
        near: (n,) values that free and held joints take.
        tolerance: largest residual of a solution.

    Returns:
        Coordinates, which rows are solutions, which of them are within the limits, residuals, codes, free coordinates,
        and statuses, as `SolutionBatch` has them.
    """
    form, held, n = setting.arm.form, setting.arm.held[0], setting.robot.n
    assert form is not None
    finite = np.isfinite(T).all(axis=(1, 2), keepdims=True)
    clean, valid = clean_poses(np.where(finite, T, 0.0))
    rows, count = form.pattern.branches, len(T)
    q, residual = np.full((count, rows, n), np.nan), np.full((count, rows), np.nan)
    good, within = np.zeros((count, rows), dtype=np.bool_), np.zeros((count, rows), dtype=np.bool_)
    codes, loose = np.zeros((count, rows), dtype=np.int16), np.zeros((count, rows), dtype=np.int32)
    status = np.full(count, VERDICTS.index(Verdict.NOT_A_POSE), dtype=np.int8)
    for begin in range(0, count, CHUNK):
        part = np.arange(begin, min(begin + CHUNK, count))
        part = part[valid[part]]
        starts, sure = _chosen(setting, form, clean[part], near, held)
        some = part[sure]
        out, facts, _ = form.labelled(clean[some], starts[sure], turns_of(starts[sure]), *setting.bounds)
        plain = ~_odd(setting, facts).any(axis=1)
        some, out, facts = some[plain], out[plain], facts[plain]
        q[some], residual[some], codes[some] = out, facts[..., 0], np.nan_to_num(facts[..., 3])
        good[some] = facts[..., 0] <= tolerance
        within[some] = good[some] & (facts[..., 5] <= 1e-12)
        loose[some] = np.where(good[some], 1 << held, 0)
        status[some] = VERDICTS.index(Verdict.CONTINUUM)
        for i in np.setdiff1d(part, some):
            answer = Question(setting, clean[i], near, tolerance).answer()
            status[i] = VERDICTS.index(answer.status)
            _written(setting, answer, (q[i], residual[i], codes[i], good[i], within[i], loose[i]))
    return q, good, within, residual, codes, loose, status


def _chosen(
    setting: Setting, form: ClosedForm, T: PoseMatrix, near: JointVector, held: int
) -> tuple[JointVector, NDArray[np.bool_]]:
    """(k, n) values of free and held joints, and (k,) whether they lead to solutions within the limits."""
    starts = np.repeat(near[None], len(T), axis=0)
    sure = _allowed(setting, form, T, starts)
    low, high = max(setting.lower[held], -np.pi), min(setting.upper[held], np.pi)
    for count in (SCAN, FINE):
        values = np.linspace(low, high, count)
        for value in values[np.argsort(np.abs(values - near[held]), kind="stable")]:
            rest = np.flatnonzero(~sure)
            if not len(rest):
                return starts, sure
            starts[rest, held] = value
            sure[rest] = _allowed(setting, form, T[rest], starts[rest])
    for i in np.flatnonzero(~sure):
        known = held_values(setting, T[i], float(near[held]))
        if known is not None and len(known.values):
            tries = np.repeat(near[None], len(known.values), axis=0)
            tries[:, held] = known.values
            good = _allowed(setting, form, np.broadcast_to(T[i], (len(tries), 4, 4)), tries)
            starts[i], sure[i] = tries[int(good.argmax())], good.any()
    return starts, sure


def _allowed(setting: Setting, form: ClosedForm, T: PoseMatrix, near: JointVector) -> NDArray[np.bool_]:
    """(k,) which poses have a solution within the limits."""
    _, facts, _ = form.labelled(T, near, turns_of(near), *setting.bounds)
    return ((facts[..., 0] <= CLEAR) & (facts[..., 5] <= 1e-12)).any(axis=1)


def _odd(setting: Setting, facts: Floats) -> NDArray[np.bool_]:
    """(k, branches) rows that have to be looked at with care: not quite solutions, merging, or free."""
    residual, mark = facts[..., 0], facts[..., 4]
    odd = (residual > CLEAR) & (residual <= setting.candidate)
    odd |= (residual <= CLEAR) & ((facts[..., 2] > 0) | (mark <= (MERGED if setting.plain else APART)))
    return odd | setting.folded(facts)


def _written(setting: Setting, answer: SolutionSet, rows: tuple[NDArray[Any], ...]) -> None:
    """A careful answer into the rows of its pose, as far as there is room."""
    q, residual, codes, good, within, loose = rows
    k = min(len(answer), len(q))
    q[:k], residual[:k], codes[:k] = answer.own[:k], answer.residual[:k], answer.codes[:k]
    good[:k], within[:k], loose[:k] = True, answer.within[:k], answer.own_free[:k]
    names = setting.robot.joint_names
    for family in answer.families:
        if family.solution < k:
            loose[family.solution] |= 1 << names.index(family.joint)
