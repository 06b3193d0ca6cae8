"""From a job to a run: the robot with its tool, the plan, the drive."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import Literal, Protocol

import msgspec

from mafsil.arrays import whole
from mafsil.job.description import Job
from mafsil.job.drive import drive
from mafsil.job.equipment import equipment_of
from mafsil.job.fitting import require_fit
from mafsil.job.kinematic import kinematic
from mafsil.job.lines import Places
from mafsil.job.move_planner import plan
from mafsil.job.named_files import with_files
from mafsil.job.neighbours import neighbours_of
from mafsil.job.plan import Plan
from mafsil.job.reading import parse
from mafsil.job.remark import Refusal, Remark
from mafsil.job.run import Run
from mafsil.job.text import text_of
from mafsil.job.vary import vary
from mafsil.robot import Robot

MOST_RUNS = 100_000
"""Of a job that is driven many times."""


class Watcher(Protocol):
    """Is called as the work goes on."""

    def enter(self, stage: str) -> None:
        """A stage begins: stage_robot, stage_planning, stage_simulating, stage_causes, stage_varying."""

    def update(self, share: float) -> None:
        """Share of the stage that is done."""


class _Nobody:
    def enter(self, stage: str) -> None: ...

    def update(self, share: float) -> None: ...


class _Again:
    """The stage in which causes are looked for; it begins with its first step."""

    def __init__(self, eye: Watcher) -> None:
        self._eye, self._entered = eye, False

    def update(self, share: float) -> None:
        """Share that is done."""
        if not self._entered:
            self._eye.enter("stage_causes")
            self._entered = True
        self._eye.update(share)


def solve(
    job: Job,
    text: str,
    folder: Path,
    watcher: Watcher | None = None,
    source: str = "<text>",
    *,
    log: str | os.PathLike[str] | None = None,
    cluster: str | None = None,
) -> Run | Refusal:
    """Solve a job end to end.

    Args:
        job: what is asked.
        text: of its file, kept in the results.
        folder: to which the path of a robot file is relative.
        watcher: called as it goes on.
        source: name of the file, for errors.
        log: path of a live log of the run, `.mcap`; none if None.
        cluster: for a job with `[variation]`, a number of worker processes here, or the address of a dask scheduler;
            this process if None.

    Returns:
        What happened, or which move is impossible and why.

    Raises:
        MafsilError: the robot cannot be read, or numbers of the job do not fit it; the log cannot be written.
    """
    eye = watcher or _Nobody()
    planned = prepare(job, text, folder, eye, source)
    if isinstance(planned, Refusal):
        return planned
    robot, motion = planned
    eye.enter("stage_simulating")
    run = drive(job, text, robot, motion, eye.update, again=_Again(eye).update, log=log)
    return run if job.variation is None else _varied(run, eye, cluster)


def _varied(run: Run, eye: Watcher, cluster: str | None) -> Run:
    """The run, and the same job driven many times, unless the run itself came to no end."""
    if run.stopped is not None:
        return replace(run, remarks=(*run.remarks, Remark("warning", "job.not_varied")))
    eye.enter("stage_varying")
    found = vary(run, cluster=cluster, progress=eye.update)
    remark = Remark("good" if found else "warning", "job.varied", {"done": found.done, "runs": found.runs})
    return replace(run, remarks=(*run.remarks, remark), variation=found)


def solve_file(
    path: str | os.PathLike[str],
    folder: str | os.PathLike[str] | None = None,
    *,
    plant: Literal["mafsil", "mujoco", "kinematic"] | None = None,
    real_time: bool = False,
    log: str | os.PathLike[str] | None = None,
    cluster: str | None = None,
) -> Run | Refusal:
    """Read a job file and solve it end to end.

    Args:
        path: of the file.
        folder: to which the path of a robot file is relative; that of the job if None.
        plant: who computes the motion; as the job says if None.
        real_time: whether it is driven against the clock even if the job does not say so.
        log: path of a live log of the run, `.mcap`; none if None.
        cluster: for a job with `[variation]`, a number of worker processes here, or the address of a dask scheduler.

    Returns:
        What happened, or which move is impossible and why.

    Raises:
        MafsilError: the job or the robot cannot be read, or do not fit each other.
    """
    place = Path(path)
    text = text_of(place)
    home = place.parent if folder is None else Path(folder)
    job = simulated_by(parse(text, place.name, folder=home), plant, real_time=real_time)
    return solve(job, text, home, source=place.name, log=log, cluster=cluster)


def simulated_by(job: Job, plant: Literal["mafsil", "mujoco", "kinematic"] | None, *, real_time: bool = False) -> Job:
    """The job with another plant, or against the clock.

    Args:
        job: as it is asked.
        plant: who computes the motion; as the job says if None.
        real_time: whether it is driven against the clock even if the job does not say so.
    """
    own = job.simulation
    changed = msgspec.structs.replace(own, plant=plant or own.plant, real_time=real_time or own.real_time)
    return msgspec.structs.replace(job, simulation=changed)


def with_runs(job: Job, runs: int) -> Job:
    """A job with `[variation]`, driven so many times; once if 0.

    Args:
        job: as it is asked.
        runs: how many.

    Raises:
        InputError: more than a hundred thousand.
    """
    whole("runs", runs, 0, MOST_RUNS)
    assert job.variation is not None
    variation = msgspec.structs.replace(job.variation, runs=runs) if runs else None
    return msgspec.structs.replace(job, variation=variation)


def prepare(
    job: Job, text: str, folder: Path, watcher: Watcher | None = None, source: str = "<text>"
) -> tuple[Robot, Plan] | Refusal:
    """The robot of a job and the motion that the job asks for; nothing is simulated. Arguments as for `solve`.

    Raises:
        MafsilError: the robot cannot be read, or numbers of the job do not fit it.
    """
    eye = watcher or _Nobody()
    eye.enter("stage_robot")
    places = Places(text, source).of(job)
    tools = equipment_of(job, folder, places)
    robot = tools[0].robot
    require_fit(job, robot, places)
    job = with_files(job, folder, places)
    neighbours = neighbours_of(job, folder, places)
    eye.enter("stage_planning")
    without_forces = kinematic(job, tools[0], places)
    motion = plan(job, tools, eye.update, text, neighbours)
    if isinstance(motion, Refusal):
        return motion
    if without_forces is not None:
        motion = replace(motion, kinematic=True, remarks=(*motion.remarks, without_forces))
    return robot, motion
