"""A planned job simulated under its controller, stretch by stretch; or again with something of it taken away."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace
from itertools import pairwise
from warnings import catch_warnings

import numpy as np

from mafsil.arrays import JointVector
from mafsil.control import combine
from mafsil.control.laws import LawFunction, LawMemory
from mafsil.errors import InputWarning, JobError
from mafsil.job.driving.arrival import arrival
from mafsil.job.driving.laws import PLACES, law_of
from mafsil.job.driving.run import Run
from mafsil.job.driving.tip_laws import environment_of, rigid_surfaces_of
from mafsil.job.language.description import TIP_LAWS, Disturbance, Job
from mafsil.job.language.units import centre_of_mass, part_inertia
from mafsil.job.planning.equipment import Load
from mafsil.job.planning.plan import Plan
from mafsil.job.planning.stretch import Driven, Stretch, grips, stretches
from mafsil.job.remark import Remark
from mafsil.messages.quantities import digits, quantity
from mafsil.messages.visible import visible
from mafsil.model.fingerprint import fingerprint
from mafsil.robot import Robot, as_open_tree
from mafsil.simulation import (
    ClosedPlant,
    Deadlines,
    MuJoCoPlant,
    Plant,
    Recording,
    RigidPlant,
    Scenario,
    SensorNoise,
    WrenchPulse,
    simulate,
)
from mafsil.simulation.closed_plant import plant_of
from mafsil.simulation.fused import WORTH, can_fuse
from mafsil.simulation.live_log import LiveLog, RunListener
from mafsil.simulation.recording import join_recordings
from mafsil.simulation.run import as_planned
from mafsil.simulation.scaled_gains import scale_gains
from mafsil.simulation.stepping import IMPLICIT_FRICTION, STIFF, friction_stiffness
from mafsil.simulation.variation import push_at
from mafsil.trajectory import Motion

EXPLICIT = "rk4"
"""The integrator where no friction is too stiff for it."""
WORTH_AGAIN = 2_000
"""Ticks from which on a loop is compiled that will be run several times."""
MOST_TICKS = 3_000_000
"""Longest job in steps: 50 minutes at 1 kHz, some minutes of computing, within 4 GB for an arm of seven joints."""


@dataclass(frozen=True, slots=True)
class Difference:
    """In what a simulation differs from what a job says, beside the job itself.

    Attributes:
        knows_arm: the law's model is the true arm with all that it carries.
        unlimited: no joint has an effort limit.
        gain: factor of all gains.
        compiled: whether the loop is compiled even if one such run would take less time in Python.
    """

    knows_arm: bool = False
    unlimited: bool = False
    gain: float = 1.0
    compiled: bool = False


AS_ASKED = Difference()


def simulate_plan(
    job: Job,
    text: str,
    robot: Robot,
    plan: Plan,
    progress: Callable[[float], None] = lambda share: None,
    *,
    log: str | os.PathLike[str] | RunListener | None = None,
    difference: Difference = AS_ASKED,
) -> Run:
    """Simulate a plan; the run is not judged, its remarks are those of the simulation.

    Args:
        job, text: what is asked, and its file.
        robot: with its tool.
        plan: the motion.
        progress: called with the share of the time that has been simulated.
        log: path of a live log, `.mcap`, or what else hears of the ticks; none if None.
        difference: from what the job says.

    Raises:
        JobError: friction is too stiff for the integrator that is asked
            for, or the motion is too long to be simulated.
        MafsilError: the log cannot be written.
    """
    _require_short(job, plan)
    if plan.kinematic:
        return Run(job, text, robot, plan, _as_planned(job, plan, log), ())
    planned = tuple(stretches(plan, grips(job, plan)))
    models = [loaded_robot(stretch.load, known=True) for stretch in planned]
    plants = [
        _plant(job, stretch, model if stretch.carried is None or stretch.carried.known else loaded_robot(stretch.load))
        for stretch, model in zip(planned, models, strict=True)
    ]
    method, remark = _method(job, planned, plants)
    if job.simulation.plant == "mujoco":
        remark = (*remark, Remark("good", "job.other_plant", {"plant": plants[0].engine}))
    with _listener(log, plan) as live:
        recordings, driven = _record(
            job, plan, list(zip(planned, models, plants, strict=True)), method, progress, live, difference
        )
    recording = join_recordings(recordings)
    timed = Deadlines.of(recording.metadata)
    if timed is not None:
        remark = (*remark, Remark("warning" if timed.missed else "good", "job.deadlines", {"deadlines": timed}))
    if "near_singular" in recording.metadata:
        found = recording.metadata["near_singular"]
        details = {"time": quantity(found["time"], "s"), "ratio": digits(found["ratio"])}
        remark = (*remark, Remark("warning", "simulation.near_singular", details))
    if fault := recording.metadata.get("log_fault"):
        remark = (*remark, Remark("warning", "simulation.log_fault", {"fault": visible(str(fault))}))
    stopped = None
    if not recording.status.succeeded:
        stopped = Remark("failure", "job.stopped", {"time": quantity(recording.duration, "s"), "reason": recording})
    return Run(job, text, robot, plan, recording, tuple(driven), stopped, remarks=remark)


def _listener(
    log: str | os.PathLike[str] | RunListener | None, plan: Plan
) -> AbstractContextManager[RunListener | None]:
    """What hears of the ticks: as it is given, or a log at a path, which is closed at the end."""
    return nullcontext(log) if log is None or isinstance(log, RunListener) else LiveLog(log, plan.duration)


def _as_planned(job: Job, plan: Plan, log: str | os.PathLike[str] | RunListener | None) -> Recording:
    """The recording of an arm that follows its plan exactly; also in a log, if one is asked for."""
    tape = join_recordings([as_planned(one.load.robot, one.trajectory, job.control_period) for one in stretches(plan)])
    with _listener(log, plan) as live:
        if live is not None:
            live.begin(tape.metadata)
            live.add(tape.arrays())
            live.end(tape.metadata | {"status": tape.status.name})
    return tape


def _record(
    job: Job,
    plan: Plan,
    parts: list[tuple[Stretch, Robot, Plant]],
    method: str,
    progress: Callable[[float], None],
    log: RunListener | None,
    difference: Difference,
) -> tuple[list[Recording], list[Driven]]:
    """Stretch by stretch, up to the first that fails."""
    recordings: list[Recording] = []
    driven: list[Driven] = []
    memory = LawMemory() if len(parts) > 1 else None
    clock = "real" if job.simulation.real_time else None
    arms = [(fingerprint(model.mechanism), fingerprint(plant.robot.mechanism)) for _, model, plant in parts]
    ticks = Counter[tuple[str, str]]()
    for (stretch, *_), alike in zip(parts, arms, strict=True):
        ticks[alike] += round(stretch.trajectory.duration / job.control_period)
    worth = WORTH_AGAIN if difference.compiled else WORTH
    for (stretch, model, loaded), alike in zip(parts, arms, strict=True):
        gripped = stretch.carried is None or _is_gripped(job, plan, stretch, recordings[-1], driven[-1])
        plant = loaded if gripped else _plant(job, stretch, stretch.load.robot)
        known = plant.robot if difference.knows_arm else model
        # Where one stretch ends and the next begins is no start that somebody gave: the findings judge it.
        with catch_warnings(action="ignore", category=InputWarning) if recordings else nullcontext():
            scenario = _scenario(job, plan, known, stretch, plant, recordings, method, difference)
        driven.append(Driven(stretch, gripped, scenario))

        def report(share: float, begin: float = stretch.start, length: float = stretch.trajectory.duration) -> None:
            progress((begin + share * length) / plan.duration)

        fused = True if clock is None and ticks[alike] >= worth and can_fuse(scenario) else None
        recordings.append(simulate(scenario, report, fused=fused, clock=clock, log=log, memory=memory))
        if not recordings[-1].status.succeeded:
            break
    return recordings, driven


def _is_gripped(job: Job, plan: Plan, stretch: Stretch, tape: Recording, before: Driven) -> bool:
    """Whether the tip was at the part when the pick before this stretch ended; the same as before without a pick."""
    if stretch.load is before.stretch.load:
        return before.gripped
    judged = arrival(job, plan, stretch.first - 1, tape, before.stretch.start)
    return judged is not None and judged.reached


def _require_short(job: Job, plan: Plan) -> None:
    ticks = plan.duration / job.control_period
    integration = plan.duration / job.simulation.step
    if max(ticks, integration) > MOST_TICKS:
        raise JobError("job.too_long", duration=plan.duration, ticks=max(ticks, integration), limit=MOST_TICKS)


def loaded_robot(load: Load, *, known: bool = False) -> Robot:
    """The robot with what it carries; with `known` only if the controller knows of it."""
    robot, carried = load.robot, load.carried
    if carried is None or (known and not carried.known):
        return robot
    return plant_of(robot).with_payload(carried.mass, centre_of_mass(carried), part_inertia(carried)).robot


def _plant(job: Job, stretch: Stretch, robot: Robot) -> Plant:
    """The true arm: its friction, what its tip touches and holds, and the masses that its model does not know."""
    rigid, touched = rigid_surfaces_of(job), environment_of(job, stretch.doors)
    kind = ClosedPlant if robot.mechanism.loops else MuJoCoPlant if job.simulation.plant == "mujoco" else Plant
    if not rigid:
        plant = kind(robot, friction=job.simulation.friction, environment=touched)
    else:
        if job.simulation.plant == "mujoco":
            raise JobError("job.rigid_plant", place="simulation plant")
        plant = RigidPlant(robot, job.simulation.friction, touched, surface=rigid)
    error, hung = job.simulation.mass_error, job.simulation.payload
    plant = plant if error == 0.0 else plant.with_scaled_inertia(1.0 + error)
    return plant if hung == 0.0 else plant.with_payload(hung)


def _method(job: Job, planned: tuple[Stretch, ...], plants: list[Plant]) -> tuple[str, tuple[Remark, ...]]:
    """The integrator: the one that is asked for, or the one that fits, with a remark where that is not rk4.

    Raises:
        JobError: friction is too stiff for the method that is asked for.
    """
    requested, step = job.simulation.method, job.simulation.step
    if requested == IMPLICIT_FRICTION:
        return requested, ()
    stiffest = max(
        friction_stiffness(plant, stretch.trajectory.at(np.linspace(0.0, stretch.trajectory.duration, PLACES)).u)
        for stretch, plant in zip(planned, plants, strict=True)
    )
    if stiffest * step <= STIFF:
        return requested or EXPLICIT, ()
    details = {"step": quantity(step, "s"), "needed": quantity(STIFF / stiffest, "s")}
    if requested is not None:
        raise JobError("job.stiff_method", method=requested, **details, other=IMPLICIT_FRICTION)
    return IMPLICIT_FRICTION, (Remark("good", "job.method_chosen", details | {"method": IMPLICIT_FRICTION}),)


def _scenario(
    job: Job,
    plan: Plan,
    model: Robot,
    stretch: Stretch,
    plant: Plant,
    past: list[Recording],
    method: str,
    difference: Difference,
) -> Scenario:
    settings, noise = job.simulation, job.simulation.noise
    model = _without_effort_limits(model) if difference.unlimited else model
    law = law_of(job, model, stretch.trajectory, plant)
    known = process_pulses(job, plan, stretch, known=True)
    if known and job.controller.kind not in TIP_LAWS:
        law = combine(law, _compensation(model, known))
    noisy = noise.position > 0.0 or noise.velocity > 0.0
    return Scenario(
        robot=model,
        trajectory=stretch.trajectory,
        law=law if difference.gain == 1.0 else scale_gains(law, np.array(difference.gain)),
        plant=plant,
        q=past[-1].q[-1] if past else None,
        qd=past[-1].qd[-1] if past else None,
        disturbances=_acting((*job.disturbance, *_processes(job, plan)), stretch),
        noise=SensorNoise(noise.position, noise.velocity, noise.seed + len(past)) if noisy else None,
        step=settings.step,
        period=job.control_period,
        integrator=method,
    )


def _without_effort_limits(robot: Robot) -> Robot:
    joints = (replace(one, limits=replace(one.limits, effort=np.inf)) for one in robot.mechanism.joints)
    return as_open_tree(replace(robot.mechanism, joints=tuple(joints)))


def _acting(pushes: Iterable[Disturbance], stretch: Stretch) -> tuple[WrenchPulse, ...]:
    """Those pushes that act during a stretch, in its own time."""
    found: list[WrenchPulse] = []
    for push in pushes:
        begin, end = push.start - stretch.start, push.start + push.duration - stretch.start
        if end > 0.0 and begin < stretch.trajectory.duration:
            found.append(WrenchPulse(max(begin, 0.0), end - max(begin, 0.0), np.array(push.wrench)))
    return tuple(found)


def process_pulses(job: Job, plan: Plan, stretch: Stretch, *, known: bool = False) -> tuple[WrenchPulse, ...]:
    """The forces of processes that act during a stretch, in its own time.

    Args:
        job, plan: with the moves.
        stretch: of the plan.
        known: only those that the controller knows.
    """
    return _acting(_processes(job, plan, known=known), stretch)


def _processes(job: Job, plan: Plan, *, known: bool = False) -> Iterator[Disturbance]:
    """The forces of processes of moves, all or those that the controller knows, in the time of the plan."""
    for leg, start in zip(plan.legs, plan.starts.tolist(), strict=False):
        ends = leg.ends or (leg.trajectory.duration,)
        for index, (begin, end) in enumerate(pairwise((0.0, *ends)), start=leg.index + 1 - len(ends)):
            move = job.move[index]
            if index >= 0 and move.process_wrench is not None and (move.process_known or not known):
                yield Disturbance(start=start + begin, duration=end - begin, wrench=move.process_wrench)


def _compensation(model: Robot, pulses: tuple[WrenchPulse, ...]) -> LawFunction:
    """tau = -J_b' F along the planned motion: what holds against forces that the controller knows."""

    def law(t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        push = push_at(pulses, np.array([t]))[0]
        return np.zeros(model.n) if push is None else -(model.jacobian_body(reference.u).swapaxes(-1, -2) @ push)

    return law
