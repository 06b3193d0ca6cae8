"""An arm whose motors drive its links through springs: motors and links move each for themselves."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, JointVector, frozen, real_array, require_finite
from mafsil.errors import InputError
from mafsil.robot import Robot, of_robot


class ElasticState(NamedTuple):
    """Where links and motors are, all at the joint: motor angles are divided by the gear ratio.

    Attributes:
        q, qd: (*batch, n) of the links [rad | m] and per second.
        motor, motor_rate: (*batch, n) of the motors, in the same units.
    """

    q: JointVector
    qd: JointVector
    motor: JointVector
    motor_rate: JointVector


@dataclass(frozen=True, eq=False, slots=True)
class ElasticArm:
    """M(q) qdd + c(q, qd) + g(q) = f,  B motor'' + f = tau,  f = K (motor - q) + D (motor' - qd).

    The rotors turn about their own axes only: gear ratios are high (Spong 1987).

    Attributes:
        links: the arm without its rotors.
        motor_inertia: (n,) B at the joint [kg m^2 | kg].
        stiffness, damping: (n,) K and D of the transmissions [N m/rad | N/m], times a second.
    """

    links: Robot
    motor_inertia: Floats
    stiffness: Floats
    damping: Floats

    @property
    def n(self) -> int:
        """Number of joints."""
        return self.links.n

    def spring_effort(self, state: ElasticState) -> JointVector:
        """f (*batch, n) that the springs exert on the links [N m | N]."""
        return self.stiffness * (state.motor - state.q) + self.damping * (state.motor_rate - state.qd)

    def accelerations(self, state: ElasticState, tau: ArrayLike) -> tuple[JointVector, JointVector]:
        """(*batch, n) of the links and of the motors.

        Args:
            state: where they are.
            tau: (*batch, n) efforts of the motors at the joint [N m | N].
        """
        f = self.spring_effort(state)
        return self.links.forward_dynamics(state.q, state.qd, f), (np.asarray(tau) - f) / self.motor_inertia

    def energy(self, state: ElasticState) -> Floats:
        """(*batch) kinetic and potential energy of links, motors and springs [J]."""
        links = self.links.kinetic_energy(state.q, state.qd) + self.links.potential_energy(state.q)
        motors = 0.5 * (self.motor_inertia * state.motor_rate**2).sum(axis=-1)
        return links + motors + 0.5 * (self.stiffness * (state.motor - state.q) ** 2).sum(axis=-1)

    def at_rest(self, q: ArrayLike) -> ElasticState:
        """Links at rest at q (*batch, n), the motors ahead by what gravity winds up the springs."""
        places = require_finite("q", real_array("q", q))
        still = np.zeros_like(places)
        return ElasticState(places, still, places + self.links.gravity_torque(places) / self.stiffness, still)


@of_robot
def elastic_arm(
    robot: Robot, stiffness: ArrayLike, *, damping: ArrayLike = 0.0, motor_inertia: ArrayLike | None = None
) -> ElasticArm:
    """An arm with springs between its motors and its links.

    Args:
        robot: its model.
        stiffness: of each transmission, seen at the joint, a number or (n,) [N m/rad | N/m].
        damping: of each transmission, a number or (n,) [N m s/rad | N s/m].
        motor_inertia: at the joint, a number or (n,); G^2 I_m of the model's rotors if None [kg m^2 | kg].

    Raises:
        InputError: a wrong shape, a stiffness or motor inertia that is not positive.
        ModelError: the robot has no masses.

    Reference: Spong, Modeling and control of elastic joint robots, J. Dyn. Syst. Meas. Control 109, 1987.
    """
    joints = robot.mechanism.coordinates
    rotors = [0.0 if joint.actuator is None else joint.actuator.reflected_inertia for joint in joints]
    B = _row("motor_inertia", np.array(rotors) if motor_inertia is None else motor_inertia, robot.n, positive=True)
    bare = tuple(replace(joint, actuator=None) for joint in robot.mechanism.joints)
    links = Robot(replace(robot.mechanism, joints=bare))
    K, D = _row("stiffness", stiffness, robot.n, positive=True), _row("damping", damping, robot.n, positive=False)
    return ElasticArm(links, B, K, D)


def _row(name: str, value: ArrayLike, n: int, *, positive: bool) -> Floats:
    array = require_finite(name, real_array(name, value))
    if array.shape not in ((), (1,), (n,)):
        raise InputError("input.shape", name=name, expected=(n,), got=array.shape, hint="")
    if positive and not (array > 0.0).all():
        raise InputError("input.positive", name=name, value=float(array.min()))
    if not (array >= 0.0).all():
        raise InputError("input.range", name=name, value=float(array.min()), low=0.0, high=np.inf)
    return frozen(np.broadcast_to(array, (n,)))
