"""The planned motion, driven under the job's controller: one simulated stretch for each load of the tool."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import groupby

import numpy as np

from mafsil.arrays import Floats
from mafsil.control import Law, computed_torque, gravity_compensation
from mafsil.errors import JobError
from mafsil.job import judgement
from mafsil.job.description import Grasp, Job
from mafsil.job.plan import Leg, Plan
from mafsil.job.remark import Remark
from mafsil.job.run import Run
from mafsil.robot import Robot
from mafsil.simulation import Plant, Recording, Scenario, SensorNoise, WrenchPulse, simulate, suitable_integrator
from mafsil.trajectory import Trajectory, sequence

MOST_TICKS = 3_000_000
"""Longest job in steps: 50 minutes at 1 kHz, some minutes of computing, within 4 GB for an arm of seven joints."""


@dataclass(frozen=True, eq=False, slots=True)
class _Stretch:
    """Legs during which the tool holds the same thing."""

    start: float
    trajectory: Trajectory
    held: Grasp | None


def drive(job: Job, text: str, robot: Robot, plan: Plan, progress: Callable[[float], None] = lambda share: None) -> Run:
    """Simulate a plan.

    Args:
        job, text: what is asked, and its file.
        robot: with its tool.
        plan: the motion.
        progress: told the share of the time that has been simulated.

    Raises:
        JobError: the controller's gains do not fit the robot, or the motion is too long to be simulated.
    """
    _require_short(job, plan)
    recordings: list[Recording] = []
    start = 0.0
    for index, stretch in enumerate(_stretches(plan)):
        scenario = _scenario(job, robot, stretch, index, recordings[-1] if recordings else None)

        def told(share: float, begin: float = start, length: float = stretch.trajectory.duration) -> None:
            progress((begin + share * length) / plan.duration)

        recordings.append(simulate(scenario, told))
        start += stretch.trajectory.duration
        if not recordings[-1].status.succeeded:
            break
    recording = _joined(recordings)
    stopped = None
    if not recording.status.succeeded:
        stopped = Remark("failure", "job.stopped", {"time": recording.duration, "reason": recording})
    run = Run(job, text, robot, plan, recording, stopped)
    return replace(run, remarks=judgement.remarks(run, judgement.summary(run)))


def _require_short(job: Job, plan: Plan) -> None:
    rate, step = job.controller.rate, job.simulation.step
    ticks = plan.duration / (step if rate is None else 1.0 / rate)
    integration = plan.duration / step
    if max(ticks, integration) > MOST_TICKS:
        raise JobError("job.too_long", duration=plan.duration, ticks=max(ticks, integration), limit=MOST_TICKS)


def _stretches(plan: Plan) -> Iterator[_Stretch]:
    start = 0.0
    for _, group in groupby(plan.legs, key=lambda leg: id(leg.held)):
        legs: list[Leg] = list(group)
        whole = sequence(*(leg.trajectory for leg in legs))
        yield _Stretch(start, whole, legs[0].held)
        start += whole.duration


def _scenario(job: Job, robot: Robot, stretch: _Stretch, index: int, before: Recording | None) -> Scenario:
    settings, held = job.simulation, stretch.held
    loaded = Plant(robot, friction=settings.friction)
    if held is not None:
        a, b, c = (edge**2 for edge in held.size)
        loaded = loaded.with_payload(held.mass, held.offset, held.mass / 12 * np.diag([b + c, a + c, a + b]))
    model = loaded.robot if held is None or held.known else robot
    plant = loaded if settings.mass_error == 0.0 else loaded.with_scaled_inertia(1.0 + settings.mass_error)
    noise = settings.noise
    noisy = noise.position > 0.0 or noise.velocity > 0.0
    return Scenario(
        robot=model,
        trajectory=stretch.trajectory,
        law=_law(job, model),
        plant=plant,
        q=None if before is None else before.q[-1],
        qd=None if before is None else before.qd[-1],
        disturbances=tuple(_pushes(job, stretch)),
        noise=SensorNoise(noise.position, noise.velocity, noise.seed + index) if noisy else None,
        step=settings.step,
        period=None if job.controller.rate is None else 1.0 / job.controller.rate,
        integrator=suitable_integrator(plant, stretch.trajectory.at(0.0).u, settings.step, settings.method),
    )


def _pushes(job: Job, stretch: _Stretch) -> Iterator[WrenchPulse]:
    """The disturbances that act during a stretch, in its own time."""
    for push in job.disturbance:
        begin, end = push.start - stretch.start, push.start + push.duration - stretch.start
        if end > 0.0 and begin < stretch.trajectory.duration:
            yield WrenchPulse(max(begin, 0.0), end - max(begin, 0.0), np.array(push.wrench))


def _law(job: Job, model: Robot) -> Law:
    controller = job.controller
    if controller.kind == "computed_torque":
        return computed_torque(model, natural_frequency=controller.frequency, damping_ratio=controller.damping)
    kp = _gains("stiffness", controller.stiffness, model)
    return gravity_compensation(model, kp, _gains("rate_gain", controller.rate_gain, model))


def _gains(name: str, value: float | tuple[float, ...], model: Robot) -> Floats:
    gains = np.atleast_1d(np.array(value, dtype=np.float64))
    if len(gains) not in (1, model.n):
        raise JobError("job.gains_count", name=name, expected=model.n, got=len(gains))
    return np.broadcast_to(gains, (model.n,)).copy()


def _joined(recordings: list[Recording]) -> Recording:
    """One recording of all stretches: each last tick is the first one of what follows."""
    last = recordings[-1]
    starts = np.concatenate([[0.0], np.cumsum([recording.t[-1] for recording in recordings])])
    parts: dict[str, list[Floats]] = {name: [] for name in last.arrays()}
    for recording, start in zip(recordings, starts, strict=False):
        kept = slice(None) if recording is last else slice(0, -1)
        for name, array in recording.arrays().items():
            parts[name].append(array[kept] + start if name == "t" else array[kept])
    joined = {name: np.concatenate(arrays) for name, arrays in parts.items()}
    seconds = sum(float(recording.metadata["seconds"]) for recording in recordings)
    metadata = last.metadata | {"seconds": seconds, "end": float(starts[-2] + last.metadata["end"])}
    return Recording(**joined, status=last.status, metadata=metadata)
