"""Whether the arm could hold what it carries, and what processes press on it with, wherever the plan brings it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from typing import TypeAlias

import numpy as np

from mafsil.arrays import Floats, JointVector, Vector3
from mafsil.job.driving.plan_simulation import process_pulses
from mafsil.job.driving.run import Run
from mafsil.job.language.description import Grasp, Job
from mafsil.job.language.driving_tables import Simulation
from mafsil.job.language.units import centre_of_mass
from mafsil.job.planning.closed_moves import holding_efforts
from mafsil.job.planning.equipment import Equipment
from mafsil.job.planning.plan import Plan
from mafsil.job.planning.stretch import Driven, Stretch, stretches
from mafsil.job.remark import Remark
from mafsil.messages.quantities import quantity
from mafsil.messages.visible import visible
from mafsil.robot import Robot
from mafsil.simulation import ClosedPlant, Plant
from mafsil.simulation.variation import WrenchPulse, push_at

PLACES_PER_LEG = 40


@dataclass(frozen=True, slots=True)
class Overload:
    """A place of the plan that the arm could not hold.

    Attributes:
        carried: what it would carry there, besides itself.
        share: least effort that holds it, over the limit.
        joint: coordinate that needs it.
        time: when the plan is there [s].
        pressed: whether the force of a process makes it too much.
    """

    carried: Grasp | None
    share: float
    joint: int
    time: float
    pressed: bool = False


Efforts: TypeAlias = Callable[[JointVector, Floats], Floats]
"""Configurations (k, n), efforts (k, n) against processes there -> (k, n) efforts that hold both, over their limits."""
Asked: TypeAlias = tuple[Stretch, Grasp | None, Efforts]
"""A stretch, what is carried, and what that takes."""


def overloads(run: Run) -> tuple[Overload, ...]:
    """Where static equilibrium is beyond the effort limits: the hardest place of each part and of each empty tool."""
    asked = ((each.stretch, each.carried, partial(holding_effort, run, each)) for each in run.driven)
    return _hardest(asked, run.job, run.plan)


def planned_overloads(job: Job, plan: Plan) -> tuple[Overload, ...]:
    """The same of a plan that is not simulated; nothing of mechanisms with loops and without masses."""
    if plan.kinematic:
        return ()
    asked: list[Asked] = []
    for stretch in stretches(plan):
        robot = stretch.load.robot
        if robot.mechanism.loops:
            return ()
        plant = Plant(robot, friction=job.simulation.friction)
        share = partial(_share, robot, stretch.carried, plant, job.simulation)
        asked.append((stretch, stretch.carried, share))
    return _hardest(asked, job, plan)


def overload_remarks(found: Iterable[Overload], robot: Robot) -> list[Remark]:
    """A sentence for each.

    Args:
        found: places that cannot be held.
        robot: whose joints they are.
    """
    remarks: list[Remark] = []
    for overload in found:
        details: dict[str, object] = {
            "joint": visible(robot.joint_names[overload.joint]),
            "share": quantity(overload.share, "share"),
            "time": quantity(overload.time, "s"),
        }
        if overload.carried is not None:
            details |= {"mass": quantity(overload.carried.mass, "kg"), "part": visible(overload.carried.name)}
        key = "job.cannot_hold" if overload.carried is None else "job.cannot_hold_part"
        key = "job.cannot_press" if overload.pressed else key
        remarks.append(Remark("failure", key, details))
    return remarks


def _hardest(asked: Iterable[Asked], job: Job, plan: Plan) -> tuple[Overload, ...]:
    """The hardest place of each part and each empty tool, by weight alone, then with the forces of processes."""
    worst: dict[tuple[Grasp | None, Equipment, bool], Overload] = {}
    for stretch, carried, effort in asked:
        legs = sum(leg.load == stretch.load for leg in plan.legs)
        pulses, whole = process_pulses(job, plan, stretch), (0.0, stretch.trajectory.duration)
        t = np.linspace(*whole, 2 + PLACES_PER_LEG * legs)
        held = effort(q := stretch.trajectory.at(t).u, np.zeros_like(q))
        looks = [(False, t, held)]
        for pulse in pulses:
            t = np.linspace(pulse.start, pulse.start + pulse.duration, PLACES_PER_LEG, endpoint=False)
            q = stretch.trajectory.at(t).u
            both = effort(q, _against(stretch.load.robot, pulses, t, q))
            looks.append((True, t, np.where(effort(q, np.zeros_like(q)) > 1.0, 0.0, both)))
        for pressed, t, share in looks:
            row, joint = np.unravel_index(int(share.argmax()), share.shape)
            most, kind = float(share[row, joint]), (carried, stretch.load.equipment, pressed)
            before = worst.get(kind)
            if most > 1.0 and (before is None or most > before.share):
                worst[kind] = Overload(carried, most, int(joint), stretch.start + float(t[row]), pressed)
    return tuple(worst.values())


def _against(robot: Robot, pulses: tuple[WrenchPulse, ...], t: Floats, q: JointVector) -> Floats:
    """(k, n) efforts tau = -J_b' F that hold against pulses at times (k,) and configurations (k, n)."""
    pushes = np.array([np.zeros(6) if push is None else push for push in push_at(pulses, t)])
    return -np.einsum("kij,ki->kj", np.asarray(robot.jacobian_body(q)), pushes)


def holding_effort(run: Run, driven: Driven, q: JointVector, process: Floats | float = 0.0) -> Floats:
    """Least effort (k, n) that holds each joint still over its limit: gravity less what static friction carries.

    Args:
        run: whose robot moves.
        driven: what it carries, with the masses as they really are.
        q: (k, n) configurations [rad | m].
        process: (k, n) efforts against forces of processes there.
    """
    plant = driven.scenario.true_plant
    if isinstance(plant, ClosedPlant):
        return _over_limit(run.robot, plant, np.abs(holding_efforts(plant.chain, q)))
    return _share(driven.stretch.load.robot, driven.carried, plant, run.job.simulation, q, process)


def _share(
    robot: Robot, carried: Grasp | None, plant: Plant, simulated: Simulation, q: JointVector,
    process: Floats | float = 0.0,
) -> Floats:  # fmt: skip
    """As `holding_effort`, of an arm without loops."""
    gravity = np.asarray(robot.gravity_torque(q))
    if carried is not None:
        gravity = gravity + _weight(robot, carried.mass, centre_of_mass(carried), q)
    load = (1.0 + simulated.mass_error) * gravity + _weight(robot, simulated.payload, np.zeros(3), q)
    return _over_limit(robot, plant, np.abs(load + process))


def _over_limit(robot: Robot, plant: Plant, load: Floats) -> Floats:
    """Efforts (k, n) less what static friction carries, over their limits."""
    if plant.has_friction:
        law = plant.friction_law
        load = load - (np.maximum(law.positive, law.negative) + np.abs(law.offset)) @ np.abs(law.gain)
    limit = robot.limits.effort
    return np.where(np.isfinite(limit), np.maximum(load, 0.0) / np.where(limit > 0.0, limit, np.inf), 0.0)


def _weight(robot: Robot, mass: float, com: Vector3, q: JointVector) -> Floats:
    """(k, n) efforts that hold a body up: tau = -J' F, F its weight at the tip, in the tip frame."""
    R = np.asarray(robot.forward_kinematics(q))[:, :3, :3]
    force = mass * np.einsum("kij,i->kj", R, robot.mechanism.gravity)
    wrench = np.concatenate([np.cross(com, force), force], axis=1)
    return -np.einsum("kij,ki->kj", np.asarray(robot.jacobian_body(q)), wrench)
