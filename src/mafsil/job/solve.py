"""From a job to a run: the robot with its tool, the plan, the drive and its judgement.

A plan is simulated, its numbers are held against what was asked, its failures explained. A job driven many times:
payloads, friction, gains, delays and noise are drawn, each run is judged as the job is.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Literal, Protocol

import msgspec
import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, whole
from mafsil.job.driving import Run, simulate_plan
from mafsil.job.driving.arrival import errors_of, goal_of
from mafsil.job.driving.run import JobVariation
from mafsil.job.judging import judge_run, summary
from mafsil.job.judging.causes import causes_of
from mafsil.job.judging.law_conditions import stability_remarks
from mafsil.job.language.description import Job
from mafsil.job.language.driving_tables import SPREADS, Normal, VariationTable
from mafsil.job.language.reading import parse_job
from mafsil.job.language.text import Places, text_of
from mafsil.job.language.units import tolerances
from mafsil.job.planning import plan_moves
from mafsil.job.planning.equipment import equipment_of
from mafsil.job.planning.fitting import kinematic, require_fit
from mafsil.job.planning.limiting import limits_of_cycle
from mafsil.job.planning.named_files import with_files
from mafsil.job.planning.neighbours import neighbours_of
from mafsil.job.planning.plan import Plan
from mafsil.job.planning.searching import is_search, search_remarks
from mafsil.job.remark import Refusal, Remark
from mafsil.robot import Robot
from mafsil.simulation import Normal as DrawnNormal
from mafsil.simulation import Scenario, Variation, cluster_executor, monte_carlo
from mafsil.simulation.live_log import RunListener
from mafsil.simulation.run import Progress
from mafsil.simulation.stepping import DEFAULT, IMPLICIT_FRICTION, STIFF

MOST_RUNS = 100_000
"""Of a job that is driven many times."""


class Watcher(Protocol):
    """Is called as the work goes on."""

    def enter(self, stage: str) -> None:
        """A stage begins: stage_robot, stage_planning, stage_simulating, stage_causes, stage_varying."""

    def update(self, share: float) -> None:
        """Share of the stage that is done."""

    def show_plan(self, plan: Plan) -> None:
        """The motion is planned."""


class _Nobody:
    def enter(self, stage: str) -> None: ...

    def update(self, share: float) -> None: ...

    def show_plan(self, plan: Plan) -> None: ...


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
    folder: str | os.PathLike[str],
    watcher: Watcher | None = None,
    source: str = "<text>",
    *,
    log: str | os.PathLike[str] | RunListener | None = None,
    cluster: str | None = None,
) -> Run | Refusal:
    """Solve a job end to end.

    Args:
        job: what is asked.
        text: of its file, kept in the results.
        folder: to which the path of a robot file is relative.
        watcher: called as it goes on.
        source: name of the file, for errors.
        log: path of a live log of the run, `.mcap`, or what else hears of its ticks; none if None.
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
    found = plan_searches(job, text, Path(folder), source, robot, motion)
    if isinstance(found, Refusal):
        return found
    motion = found
    eye.show_plan(motion)
    run = drive(job, text, robot, motion, eye.update, again=_Again(eye).update, log=log)
    return run if job.variation is None else _vary(run, eye, cluster)


def plan_searches(job: Job, text: str, folder: Path, source: str, robot: Robot, motion: Plan) -> Plan | Refusal:
    """The motion of a job whose searches end where the simulated force of contact comes.

    Args:
        job, text, folder, source: as for `solve`.
        robot, motion: as `prepare` gives them, with searches to the ends of their paths.
    """
    stops = tuple[float, ...]()
    while searches := [k for k, leg in enumerate(motion.legs) if is_search(job, leg) and leg.stopped is None]:
        k = searches[0]
        tape = simulate_plan(job, text, robot, replace(motion, legs=motion.legs[: k + 1])).recording
        wrench, least = tape.contact_wrench, job.move[motion.legs[k].index].until_force
        assert wrench is not None
        felt = np.linalg.norm(wrench[:, 3:], axis=1)
        rows = np.flatnonzero((tape.t >= motion.starts[k]) & (felt >= least))
        if not len(rows):
            return motion
        stops = (*stops, float(tape.t[rows[0]] - motion.starts[k]))
        planned = prepare(job, text, folder, None, source, stops=stops)
        if isinstance(planned, Refusal):
            return planned
        motion = planned[1]
    return motion


def _vary(run: Run, eye: Watcher, cluster: str | None) -> Run:
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
    job = simulated_by(parse_job(text, place.name, folder=home), plant, real_time=real_time)
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
    job: Job, text: str, folder: str | os.PathLike[str], watcher: Watcher | None = None, source: str = "<text>", *,
    stops: tuple[float, ...] = (),
) -> tuple[Robot, Plan] | Refusal:  # fmt: skip
    """The robot of a job and the motion that the job asks for; nothing is simulated. Arguments as for `solve`.

    With `stops` searches by force end at these times after their beginnings [s].

    Raises:
        MafsilError: the robot cannot be read, or numbers of the job do not fit it.
    """
    eye = watcher or _Nobody()
    eye.enter("stage_robot")
    places = Places(text, source).of(job)
    home = Path(folder)
    tools = equipment_of(job, home, places)
    robot = tools[0].robot
    require_fit(job, robot, places)
    job = with_files(job, home, places)
    neighbours = neighbours_of(job, home, places)
    eye.enter("stage_planning")
    without_forces = kinematic(job, tools[0], places)
    motion = plan_moves(job, tools, eye.update, text, neighbours, stops)
    if isinstance(motion, Refusal):
        return motion
    if without_forces is not None:
        motion = replace(motion, kinematic=True, remarks=(*motion.remarks, without_forces))
    return robot, motion


def drive(
    job: Job,
    text: str,
    robot: Robot,
    plan: Plan,
    progress: Callable[[float], None] = lambda share: None,
    *,
    explained: bool = True,
    again: Callable[[float], None] = lambda share: None,
    log: str | os.PathLike[str] | RunListener | None = None,
) -> Run:
    """Simulate a plan and judge the run.

    Args:
        job, text: what is asked, and its file.
        robot: with its tool.
        plan: the motion.
        progress: called with the share of the time that has been simulated.
        explained: whether a job that failed is driven again, to find the causes.
        again: called with the share of that which is done.
        log: path of a live log, `.mcap`, or what else hears of the ticks; none if None.

    Raises:
        JobError: friction is too stiff for the integrator that is asked
            for, or the motion is too long to be simulated.
        MafsilError: the log cannot be written.
    """
    run = replace(simulate_plan(job, text, robot, plan, progress, log=log), limits=limits_of_cycle(plan))
    causes = causes_of(run, again) if explained and not plan.kinematic else {}
    searches = search_remarks(job, plan, simulated=True)
    found = replace(run, remarks=(*searches, *judge_run(run, summary(run), causes), *run.remarks))
    return replace(found, remarks=(*found.remarks, *stability_remarks(found)))


def vary(run: Run, *, cluster: str | None = None, progress: Progress | None = None) -> JobVariation:
    """Drive the motion of a job many times, as its `[variation]` says.

    1. All stretches of the plan follow each other in each run, with the same drawn numbers; what the job itself
       gripped is gripped in every run.
    2. Each run is judged where its moves end, as the run of the job is.

    Args:
        run: of the job, come to its end.
        cluster: a number of worker processes here, or the address of a dask scheduler; this process if None.
        progress: called with the share that is done; False ends it with the runs done so far.

    Raises:
        InputError: what is drawn makes no sense; MuJoCo's arm, which is not varied; dask is not installed.
    """
    asked = run.job.variation
    assert asked is not None
    scenarios = [driven.scenario for driven in run.driven]
    variation = Variation(**{name: _spread(getattr(asked, name)) for name in SPREADS})
    legs = [k for k, leg in enumerate(run.plan.legs) if goal_of(leg) is not None]
    marks = np.minimum([float(run.plan.starts[k + 1]) for k in legs], sum(each.ticks()[-1] for each in scenarios))
    with cluster_executor(cluster) as executor:
        drawn = monte_carlo(
            _stable(run.job, scenarios, asked), variation, asked.runs, seed=asked.seed, bound=asked.bound,
            marks=marks, executor=executor, progress=progress,
        )  # fmt: skip
    names = tuple(leg.name or str(leg.index + 1) for leg in run.plan.legs)
    return JobVariation(drawn, asked, _missed_legs(run.job, run.plan, legs, drawn.outcomes.marked), names)


def _stable(job: Job, scenarios: list[Scenario], asked: VariationTable) -> list[Scenario]:
    """With an integrator that no drawn friction makes unstable, unless the job names one."""
    if job.simulation.method is not None:
        return scenarios
    stiff = False
    if asked.friction is not None or asked.inertia is not None:
        most, least = _largest(asked.friction), _smallest(asked.inertia)
        stiff = any(scenario.stiffness * most / least > STIFF for scenario in scenarios)
    if stiff or any(scenario.integrator == IMPLICIT_FRICTION for scenario in scenarios):
        return [replace(each, integrator=IMPLICIT_FRICTION) for each in scenarios]
    # Forces of contact are asked for once a step, for all runs together.
    touches = any(scenario.true_plant.environment is not None for scenario in scenarios)
    return [replace(each, integrator=DEFAULT) for each in scenarios] if touches else scenarios


def _largest(spread: tuple[float, float] | Normal | None) -> float:
    if spread is None:
        return 1.0
    return spread.mean + 4.0 * spread.deviation if isinstance(spread, Normal) else spread[1]


def _smallest(spread: tuple[float, float] | Normal | None) -> float:
    if spread is None:
        return 1.0
    low = spread.mean - 4.0 * spread.deviation if isinstance(spread, Normal) else spread[0]
    return max(low, 1e-3)


def _spread(given: tuple[float, float] | Normal | None) -> DrawnNormal | tuple[float, float] | None:
    return DrawnNormal(given.mean, given.deviation) if isinstance(given, Normal) else given


def _missed_legs(job: Job, plan: Plan, legs: list[int], q: Floats) -> NDArray[np.int64]:
    """(b,) the first leg whose target each run missed, from its positions (b, m, n) where they end; -1 for none."""
    first = np.full(len(q), -1, dtype=np.int64)
    for m, k in reversed(list(enumerate(legs))):
        leg = plan.legs[k]
        allowed = tolerances(job, leg.load.robot, leg.index)
        position, turn, joints = errors_of(leg, q[:, m])
        if goal_of(leg) == "joints":
            share = (joints / allowed.joints).max(axis=-1)
        else:
            share = np.maximum(position / allowed.position, turn / allowed.orientation)
        first[share > 1.0] = k
    return first
