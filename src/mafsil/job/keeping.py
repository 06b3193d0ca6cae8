"""Whether the driven arm of a job kept what its moves were to keep."""

from __future__ import annotations

import numpy as np

from mafsil.job.called import Where
from mafsil.job.remark import Remark
from mafsil.job.run import Run
from mafsil.planning.kept_planning import Measured


def worst_kept(run: Run, leg: int) -> Measured | None:
    """How far the driven arm left what a leg keeps; None of one that keeps nothing, or was never come to.

    Args:
        run: what happened.
        leg: its number.
    """
    way = run.plan.legs[leg].way
    if way is None or way.plan.kept is None or not way.plan.kept.asked or way.plan.checker is None:
        return None
    t, begun, end = run.recording.t, run.plan.starts[leg], run.plan.starts[leg + 1]
    rows = np.flatnonzero((t >= begun) & (t <= end))
    if not len(rows):
        return None
    return Measured(way.plan.kept, way.plan.kept.measures(way.plan.checker, run.recording.q[rows]).max(axis=0))


def keeping_remarks(run: Run) -> list[Remark]:
    """Whether each move kept what it was to keep, measured on the recorded motion."""
    found: list[Remark] = []
    for k, leg in enumerate(run.plan.legs):
        measured = worst_kept(run, k)
        if measured is None:
            continue
        level, key = ("good", "job.kept_driven") if measured.holds else ("failure", "job.constraint_violated")
        found.append(Remark(level, key, {"move": Where(leg.index, run.job.move[leg.index]), "kept": measured}))
    return found
