"""Friction of the joints compensated along the reference: at its rates, never at measured ones, so nothing chatters."""

from __future__ import annotations

from dataclasses import dataclass

from mafsil.arrays import Floats, JointVector, require_kind
from mafsil.control.laws.law import Law
from mafsil.robot import Robot, of_robot
from mafsil.trajectory import Motion


def friction_along(robot: Robot, reference: Motion) -> Floats:
    """(*batch, n) efforts that the friction of a description takes at the rates of a reference [N m | N].

    Dry friction changes its sign where the reference turns round, smoothly, and is zero where the reference rests: a
    measured rate, whose sign is noise at rest, has no part in it.

    Args:
        robot: the model.
        reference: whose rates count.
    """
    return robot.friction_torque(reference.v)


@dataclass(frozen=True, eq=False, slots=True)
class FrictionCompensation:
    """tau = friction(v): what the friction of the model takes at the rates of the reference; for sums of laws.

    Attributes:
        robot: the model.
    """

    robot: Robot

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Joint efforts (*batch, n) [N m | N]."""
        return friction_along(self.robot, reference) + 0.0 * q

    def session(self, period: float) -> Law:
        """The law itself: it has no memory."""
        return self


@of_robot
def friction_compensation(robot: Robot) -> FrictionCompensation:
    """Friction compensation along the reference, for laws without a friction model: `combine(law, ...)`.

    Args:
        robot: the model.
    """
    require_kind("robot", robot, "Robot", "friction_torque")
    return FrictionCompensation(robot)
