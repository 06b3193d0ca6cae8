"""Closed loops in time: `simulate` runs a scenario.

Recordings of runs side by side of which some ended early: each stands where it last was, and is said by number.
"""

from __future__ import annotations

import os
from dataclasses import replace
from time import perf_counter
from typing import TYPE_CHECKING, Literal

import numpy as np

from mafsil.arrays import Floats, require_function, require_kind
from mafsil.errors import InputError
from mafsil.lazy_module import lazily
from mafsil.simulation.clock import RealTime
from mafsil.simulation.faults import Stopped, law_name
from mafsil.simulation.live_log import RunListener, log_of
from mafsil.simulation.recording import Recording, SimulationStatus
from mafsil.simulation.rigid_plant import RigidPlant
from mafsil.simulation.run import Progress, Run
from mafsil.simulation.scenario import Scenario

if TYPE_CHECKING:
    import mafsil.simulation.fused as fused_loop
    import mafsil.simulation.rigid_run as rigid_run
    import mafsil.simulation.varied_run as varied_run
    from mafsil.control.laws import LawMemory
    from mafsil.simulation.varied_run import VariedFusedRun, VariedRun
else:
    fused_loop = lazily("mafsil.simulation.fused")
    varied_run = lazily("mafsil.simulation.varied_run")
    rigid_run = lazily("mafsil.simulation.rigid_run")


STILL = ("qd", "qdd", "tau", "tau_commanded", "contact_wrench")
"""What is zero once a run has ended; places stay."""


def simulate(
    scenario: Scenario,
    progress: Progress | None = None,
    *,
    fused: bool | None = None,
    clock: Literal["real"] | None = None,
    log: RunListener | str | os.PathLike[str] | None = None,
    memory: LawMemory | None = None,
) -> Recording:
    """Run a scenario.

    The law sees the state (with sensor noise) once every control period; its efforts are clipped and kept constant
    while the plant is integrated with the fixed step. Where law and plant are expressions, the whole loop can run as
    compiled code; it agrees with the general loop to rounding.

    Args:
        scenario: what to run.
        progress: called with the fraction done, about a hundred times; the run stops if it returns False.
        fused: whether the loop is compiled as a whole; None compiles long runs of laws that allow it.
        clock: `real` lets every tick begin when it is due and counts those that are not done within their period; a
            run then takes as long as the motion. As fast as it goes if None.
        log: a file `.mcap` that grows with the run and survives the process (`pip install mafsil[record]`), or a
            `LiveLog` for several runs, or what else hears of ticks; `Recording.load` reads the file. None for none.
        memory: what the law takes over from the last run with this memory, and leaves for the next: for runs that
            follow each other. None begins afresh.

    Returns:
        The recording up to the end, or up to the last good state: if the motion blows up, a sensor or the law fails,
        the law raises, `progress` says no, or Ctrl-C is pressed. Its status says which.

    Raises:
        InputError: the law returns efforts of a wrong shape; progress cannot be called; `fused` is asked of a law or a
            number of substeps that cannot be compiled, or together with a clock; a log of another suffix, or `mcap` is
            not installed.
        FileError: the log cannot be written.
    """
    require_kind("scenario", scenario, "Scenario", "trajectory", "law", "ticks")
    if progress is not None:
        require_function("progress", progress, "function of the fraction done", 1)
    if fused not in (None, True, False):
        raise InputError("input.choice", name="fused", value=fused, known="None, True, False")
    if memory is not None:
        require_kind("memory", memory, "LawMemory", "begun")
    if clock not in (None, "real"):
        raise InputError("input.choice", name="clock", value=clock, known="None, 'real'")
    if clock and fused:
        raise InputError("simulation.fused_clock")
    began = perf_counter()
    kinds = (
        (Run, fused_loop.FusedRun) if scenario.variants is None else (varied_run.VariedRun, varied_run.VariedFusedRun)
    )
    kind = kinds[clock is None and _is_fused(scenario, fused)]
    run = rigid_run.RigidRun(scenario) if isinstance(scenario.true_plant, RigidPlant) else kind(scenario)
    run.memory = memory
    if clock:
        run.clock = RealTime(law_name(scenario.law), scenario.control_period)
    with log_of(log) as run.log:
        run.begin_log()
        try:
            status = run.to_the_end(progress)
        except Stopped as stop:
            status = run.stop(stop.status, stop.fault)
        except KeyboardInterrupt:
            status = run.stop(SimulationStatus.INTERRUPTED)
        recording = run.recording(status, perf_counter() - began)
        if isinstance(run, varied_run.VariedRun | varied_run.VariedFusedRun):
            recording = with_ends(recording, run)
        run.end_log(recording)
    if run.log is not None and run.log.fault:
        recording.metadata["log_fault"] = run.log.fault
    return recording


def _is_fused(scenario: Scenario, requested: bool | None) -> bool:
    if requested is False:
        return False
    states = max(1, scenario.start()[0].size // scenario.robot.n)
    if requested is None and scenario.ends_at / scenario.control_period * states < fused_loop.WORTH:
        return False
    possible = fused_loop.can_fuse(scenario)
    if requested and not possible:
        raise InputError("simulation.not_fused", law=law_name(scenario.law), substeps=scenario.substeps)
    return possible


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
