"""Whether the arm could hold what it carries, still, wherever the plan brings it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats, JointVector, Vector3
from mafsil.job.closed_moves import holding_efforts
from mafsil.job.description import Grasp
from mafsil.job.equipment import Equipment
from mafsil.job.payload import centre_of_mass
from mafsil.job.run import Run
from mafsil.job.stretch import Driven
from mafsil.robot import Robot
from mafsil.simulation import ClosedPlant

PLACES_PER_LEG = 40


@dataclass(frozen=True, slots=True)
class Overload:
    """A place of the plan that the arm could not hold.

    Attributes:
        carried: what it would carry there, besides itself.
        share: least effort that holds it, over the limit.
        joint: coordinate that needs it.
        time: when the plan is there [s].
    """

    carried: Grasp | None
    share: float
    joint: int
    time: float


def overloads(run: Run) -> tuple[Overload, ...]:
    """Where static equilibrium is beyond the effort limits: the hardest place of each part and of each empty tool."""
    worst: dict[tuple[Grasp | None, Equipment], Overload] = {}
    for driven in run.driven:
        legs = sum(leg.load == driven.stretch.load for leg in run.plan.legs)
        t = np.linspace(0.0, driven.stretch.trajectory.duration, 2 + PLACES_PER_LEG * legs)
        share = holding_effort(run, driven, driven.stretch.trajectory.at(t).u)
        row, joint = np.unravel_index(int(share.argmax()), share.shape)
        most = float(share[row, joint])
        kind = (driven.carried, driven.stretch.load.equipment)
        before = worst.get(kind)
        if most > 1.0 and (before is None or most > before.share):
            worst[kind] = Overload(driven.carried, most, int(joint), driven.stretch.start + float(t[row]))
    return tuple(worst.values())


def holding_effort(run: Run, driven: Driven, q: JointVector) -> Floats:
    """Least effort (k, n) that holds each joint still over its limit: gravity less what static friction carries.

    Args:
        run: whose robot moves.
        driven: what it carries, with the masses as they really are.
        q: (k, n) configurations [rad | m].
    """
    plant = driven.scenario.true_plant
    if isinstance(plant, ClosedPlant):
        load = np.abs(holding_efforts(plant.chain, q))
    else:
        robot = driven.stretch.load.robot
        gravity = np.asarray(robot.gravity_torque(q))
        if driven.carried is not None:
            gravity = gravity + _weight(robot, driven.carried.mass, centre_of_mass(driven.carried), q)
        simulated = run.job.simulation
        load = np.abs((1.0 + simulated.mass_error) * gravity + _weight(robot, simulated.payload, np.zeros(3), q))
    if plant.has_friction:
        law = plant.friction_law
        load = load - (np.maximum(law.positive, law.negative) + np.abs(law.offset)) @ np.abs(law.gain)
    limit = run.robot.limits.effort
    return np.where(np.isfinite(limit), np.maximum(load, 0.0) / np.where(limit > 0.0, limit, np.inf), 0.0)


def _weight(robot: Robot, mass: float, com: Vector3, q: JointVector) -> Floats:
    """(k, n) efforts that hold a body up: tau = -J' F, F its weight at the tip, in the tip frame."""
    R = np.asarray(robot.forward_kinematics(q))[:, :3, :3]
    force = mass * np.einsum("kij,i->kj", R, robot.mechanism.gravity)
    wrench = np.concatenate([np.cross(com, force), force], axis=1)
    return -np.einsum("kij,ki->kj", np.asarray(robot.jacobian_body(q)), wrench)
