"""Virtual walls and fixtures: an arm that lets the hand feel what is not there."""

from __future__ import annotations

from dataclasses import dataclass

from mafsil.arrays import JointVector, require_kind
from mafsil.control.contact.environment import Environment, tip_wrench_of
from mafsil.control.laws.law import Law
from mafsil.robot import Robot, of_robot
from mafsil.trajectory import Motion


@dataclass(frozen=True, eq=False, slots=True)
class VirtualEnvironment:
    """tau = g(q) + J' F: the arm weighs nothing, and its tip feels the wrench F of an environment that is not there.

    Attributes:
        robot: the model.
        environment: what is felt.
    """

    robot: Robot
    environment: Environment

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Joint efforts (*batch, n) [N m | N]."""
        wrench = tip_wrench_of(self.robot, self.environment, q, qd)
        J = self.robot.jacobian_body(q)
        return self.robot.gravity_torque(q) + (wrench[..., None, :] @ J)[..., 0, :]

    def session(self, period: float) -> Law:
        """The law itself: it has no memory."""
        return self


@of_robot
def virtual_environment(robot: Robot, environment: Environment) -> VirtualEnvironment:
    """The law of a haptic arm: a wall that must not be entered, a guide that leads the hand, anything with a wrench.

    A sampled arm renders walls up to k = 2 b / T only, b being what damps the hand: `stiffest_wall` and
    `sampled_wall_radius` say what is stable.

    Args:
        robot: the model.
        environment: what is felt.

    Raises:
        InputError: an environment without a wrench.
    """
    require_kind("environment", environment, "Environment", "wrench")
    return VirtualEnvironment(robot, environment)
