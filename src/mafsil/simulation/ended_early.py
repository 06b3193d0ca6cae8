"""Recordings of runs side by side of which some ended early: each stands where it last was, and is said by number."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from mafsil.arrays import Floats
from mafsil.simulation.recording import Recording, SimulationStatus
from mafsil.simulation.run import Run

if TYPE_CHECKING:
    from mafsil.simulation.varied_run import VariedFusedRun, VariedRun

STILL = ("qd", "qdd", "tau", "tau_commanded", "contact_wrench")
"""What is zero once a run has ended; places stay."""


def with_ends(recording: Recording, run: VariedRun | VariedFusedRun) -> Recording:
    """The recording with runs that ended early as they last were, their last times, and which lost their loops.

    Args:
        recording: of the runs.
        run: that made it.
    """
    ends, lost, ticks = run.ends, run.lost, len(recording.t)
    early = np.asarray(ends < ticks)
    if not early.any() or not recording.status.succeeded:
        return recording
    over = np.arange(ticks)[:, None] >= ends
    last = np.where(over, np.maximum(ends - 1, 0), np.arange(ticks)[:, None])
    arrays: dict[str, Floats] = {}
    for name, array in recording.arrays().items():
        if name == "t" or name.endswith("_ref"):
            continue
        every = over.reshape(*over.shape, *[1] * (array.ndim - 2))
        arrays[name] = np.where(every, 0.0, array) if name in STILL else array[last, np.arange(len(ends))]
    never = np.flatnonzero(ends == 0)
    if len(never) and ticks:
        # Not even the start holds: it is all that there is.
        q = run.start[0][None]
        off = Run.tip_errors(run, slice(0, 1), q, np.broadcast_to(recording.q_ref[:1], q.shape))
        for name, first in zip(("q", "tip_position_error", "tip_rotation_error"), (q, *off), strict=True):
            arrays[name][:, never] = first[:, never]
    times = recording.t[np.maximum(ends - 1, 0)] if ticks else np.zeros(len(ends))
    metadata = recording.metadata | {
        "run_ends": times.tolist(),
        "runs_lost": np.flatnonzero(early & lost).tolist(),
        "runs_blown_up": np.flatnonzero(early & ~lost).tolist(),
    }
    status = SimulationStatus.LOOPS_LOST if (early & lost).any() else SimulationStatus.BLOWN_UP
    return replace(recording, **arrays, status=status, metadata=metadata)
