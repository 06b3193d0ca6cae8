"""What a redundant arm does beside its task: its joints are drawn to their reference without moving the tip."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import JointVector
from mafsil.control.laws.gains import Gains
from mafsil.control.laws.law import Law
from mafsil.control.laws.task_coordinates import TaskCoordinates
from mafsil.control.laws.task_dynamics import task_dynamics
from mafsil.robot import Robot, of_robot
from mafsil.trajectory import Motion


@dataclass(frozen=True, eq=False, slots=True)
class NullSpaceFeedback:
    """tau = (I - J' Jbar') (M (a + Kp (u - q) + Kd (v - qd)) + c + g): efforts that do not accelerate the tip.

    Laws of the tip bear what they feel of gravity; the rest of it, along motions that leave the tip at rest, is borne
    here.

    Attributes:
        robot: the model.
        coordinates: of the task that is left alone.
        gains: (n,) in units of acceleration.
    """

    robot: Robot
    coordinates: TaskCoordinates
    gains: Gains

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Joint efforts (*batch, n) [N m | N]."""
        now = task_dynamics(self.robot, q, qd, self.coordinates)
        pull = reference.a + self.gains.kp * (reference.u - q) + self.gains.kd * (reference.v - qd)
        return now.effort(np.zeros_like(now.V), self.robot.inverse_dynamics(q, qd, pull))

    def session(self, period: float) -> Law:
        """The law itself: it has no memory."""
        return self


@of_robot
def null_space_feedback(
    robot: Robot, *, coordinates: TaskCoordinates | None = None, natural_frequency: ArrayLike = 2.0
) -> NullSpaceFeedback:
    """Feedback of the joints in what the task leaves free; to be combined with a law of the tip.

    Args:
        robot: the model, with more joints than the task has coordinates.
        coordinates: of the task; all six, decoupled, if None.
        natural_frequency: w, a number or (n,), critically damped [rad/s].

    Reference: Khatib, A unified approach for motion and force control of robot manipulators, 1987.
    """
    gains = Gains.from_natural_frequency(robot.n, natural_frequency)
    return NullSpaceFeedback(robot, coordinates or TaskCoordinates(), gains)
