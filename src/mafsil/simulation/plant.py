"""What moves: a robot with its friction, and with the errors that its model does not know."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, JointVector, Vector6, as_batch, real_array
from mafsil.control.contact.environment import Environment, tip_wrench_of
from mafsil.errors import InputError
from mafsil.kernels.lazy import lazy
from mafsil.mechanics.friction import FrictionLaw, friction_law, has_friction
from mafsil.model import Inertial
from mafsil.robot import Robot, as_open_tree, as_robot
from mafsil.version import __version__


@dataclass(frozen=True, eq=False)
class Plant:
    """The simulated arm: M(q) qdd + c(q, qd) + g(q) + friction(qd) = tau + J' push.

    Attributes:
        robot: the true arm; its model in the controller may differ.
        friction: whether the joints' friction acts.
        environment: what the tip touches, or None.
        keeps_loops: whether the plant keeps loops closed; robots with loops are refused if not.

    Raises:
        ModelError: the robot has loops: `ClosedPlant` moves it.
    """

    robot: Robot
    friction: bool = True
    environment: Environment | None = None
    keeps_loops: ClassVar[bool] = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "robot", as_open_tree(self.robot) if self.keeps_loops else as_robot(self.robot))

    def acceleration(self, q: JointVector, qd: JointVector, tau: JointVector, push: Vector6 | None = None) -> Floats:
        """Joint accelerations (*batch, n) [rad/s^2 | m/s^2].

        Args:
            q, qd: (*batch, n) state.
            tau: (*batch, n) efforts of the motors [N m | N].
            push: (*batch, 6) wrench (m, f) that the world exerts on the tip, in the tip frame [N m, N].
        """
        if self.has_friction:
            tau = tau - self.robot.friction_torque(qd)
        push = self.tip_push(q, qd, push)
        if push is None:
            return self.robot.forward_dynamics(q, qd, tau)
        return self.robot.forward_dynamics(q, qd, tau, -push)

    def tip_push(self, q: JointVector, qd: JointVector, push: Vector6 | None) -> Vector6 | None:
        """(*batch, 6) wrench on the tip, in the tip frame: the push and what the environment adds; None if nothing."""
        if push is not None:
            push = as_batch("push", push, (6,))
        if self.environment is None:
            return push
        touch = tip_wrench_of(self.robot, self.environment, q, qd)
        return touch if push is None else push + touch

    @property
    def engine(self) -> str:
        """Who computes the motion, and its version, as a recording names it."""
        return f"mafsil {__version__}"

    @lazy
    def has_friction(self) -> bool:
        """Whether any joint loses effort to friction."""
        return self.friction and has_friction(self.robot.mechanism)

    @lazy
    def friction_law(self) -> FrictionLaw:
        """Friction of all joints that have any, those that follow others included."""
        return friction_law(self.robot.mechanism)

    def with_payload(self, mass: float, com: ArrayLike = (0.0, 0.0, 0.0), inertia: ArrayLike | None = None) -> Plant:
        """The same plant carrying a body that the controller's model does not know.

        Args:
            mass: of the payload [kg].
            com: (3,) its centre of mass in the tip frame [m].
            inertia: (3, 3) about its centre of mass, in the axes of the tip frame; a point mass if None [kg m^2].

        Raises:
            InputError: a wrong shape, a number that is not finite, a negative mass.
        """
        return replace(self, robot=self.robot.with_payload(mass, com=com, inertia=inertia))

    def with_scaled_inertia(self, factor: ArrayLike) -> Plant:
        """The same plant whose masses and inertias differ from the model's by a factor.

        Args:
            factor: one number, or one per link (base first); 1 changes nothing.

        Raises:
            InputError: a wrong shape, or a factor that is not positive and finite.
        """
        mechanism = self.robot.mechanism
        factors = real_array("factor", factor)
        if factors.shape not in ((), (len(mechanism.links),)):
            raise InputError("input.shape", name="factor", expected=(len(mechanism.links),), got=factors.shape, hint="")
        if not (np.isfinite(factors) & (factors > 0.0)).all():
            raise InputError("input.positive", name="factor", value=factors.min())
        links = tuple(
            replace(link, inertial=_scale(link.inertial, float(scale)))
            for link, scale in zip(mechanism.links, np.broadcast_to(factors, len(mechanism.links)), strict=True)
        )
        return replace(self, robot=as_open_tree(replace(mechanism, links=links)))


def _scale(inertial: Inertial | None, factor: float) -> Inertial | None:
    if inertial is None:
        return None
    return Inertial(inertial.mass * factor, inertial.com, inertial.inertia * factor)
