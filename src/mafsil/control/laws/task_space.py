"""Computed torque in task space: the error of the tip obeys linear equations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, JointVector, require_function, require_kind
from mafsil.control.laws.feedback import RunningSum
from mafsil.control.laws.gains import Gains
from mafsil.control.laws.law import Law
from mafsil.control.laws.task_coordinates import TaskCoordinates
from mafsil.control.laws.task_dynamics import task_dynamics
from mafsil.control.laws.tip_motion import TipReference
from mafsil.robot import Robot, of_robot
from mafsil.trajectory import Motion


@dataclass(frozen=True, eq=False, slots=True)
class TaskComputedTorque:
    """tau = J' (Lambda (A_d + Kp X_e + Ki int X_e + Kd V_e) + gamma + eta) + N tau_0.

    The error obeys V_e' + Kd V_e + Kp X_e + Ki int X_e = 0: exactly for positions, to first order in X_e for rotations.
    A redundant arm's null space is damped and drawn to the joints' reference.

    Attributes:
        robot: the model; it may differ from the plant.
        coordinates: of the task.
        gains: (m,) in units of acceleration.
        reference: of the tip.
        rest_gains: (n,) gains of the joints' reference in the null space [1/s^2, 1/s], as efforts by M.
    """

    robot: Robot
    coordinates: TaskCoordinates
    gains: Gains
    reference: TipReference
    rest_gains: Gains

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Joint efforts (*batch, n) without the integral term, which needs a session [N m | N]."""
        return self.effort(t, q, qd, reference, np.zeros(len(self.gains.kp)))[0]

    def effort(
        self, t: float, q: JointVector, qd: JointVector, reference: Motion, more: Floats
    ) -> tuple[JointVector, Floats]:
        """Efforts (*batch, n), and the configuration error (*batch, m).

        Args:
            t: time [s].
            q, qd: (*batch, n) state.
            reference: of the joints, for the null space.
            more: (*batch, m) acceleration that is added.
        """
        now = task_dynamics(self.robot, q, qd, self.coordinates)
        X_e, V_e, ahead = self.coordinates.error(self.coordinates.pose(self.robot, q), self.reference(t), now.V)
        force = now.force(ahead + self.gains.kp * X_e + self.gains.kd * V_e + more)
        if self.robot.n == len(self.coordinates.rows):
            return now.effort(force), X_e
        pull = reference.a + self.rest_gains.kp * (reference.u - q) + self.rest_gains.kd * (reference.v - qd)
        return now.effort(force, self.robot.inverse_dynamics(q, qd, pull)), X_e

    def session(self, period: float) -> Law:
        """The law with a fresh integral; the law itself if Ki is zero."""
        return _WithIntegral(self, period) if self.gains.integrates else self


class _WithIntegral:
    """One run of a task-space law."""

    def __init__(self, law: TaskComputedTorque, period: float) -> None:
        self._law, self._weight = law, law.gains.ki * period
        self._sum = RunningSum(np.zeros(len(law.coordinates.rows)))

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        X_e = self._law.effort(t, q, qd, reference, self._sum.value)[1]
        return self._law.effort(t, q, qd, reference, self._sum.add(self._weight * X_e))[0]

    def go_on(self, before: _WithIntegral) -> None:
        self._sum.go_on(before._sum)

    def session(self, period: float) -> Law:
        return self._law.session(period)


@of_robot
def task_computed_torque(
    robot: Robot,
    reference: TipReference,
    *,
    coordinates: TaskCoordinates | None = None,
    natural_frequency: ArrayLike = 20.0,
    damping_ratio: ArrayLike = 1.0,
    integral: ArrayLike = 0.0,
    rest_frequency: float = 2.0,
) -> TaskComputedTorque:
    """Computed torque of the tip, with gains by natural frequency and damping.

    Args:
        robot: the model.
        reference: of the tip, such as a `TipMotion` or `hold(T_sd)`; its velocities in the axes of the coordinates.
        coordinates: of the task; all six, decoupled, if None.
        natural_frequency: w, a number or (m,) [rad/s].
        damping_ratio: zeta, a number or (m,).
        integral: Ki, a number or (m,) [1/s^3]; below 2 zeta w^3.
        rest_frequency: of what a redundant arm does beside the task, critically damped [rad/s].

    Raises:
        InputError: a wrong shape, a negative number, an integral gain that makes the loop unstable.

    Reference: Lynch and Park, Modern Robotics, eq. (11.47); Khatib 1987.
    """
    require_function("reference", reference, "function of time", 1)
    require_kind("robot", robot, "Robot", "mass_matrix")
    task = coordinates or TaskCoordinates()
    gains = Gains.from_natural_frequency(len(task.rows), natural_frequency, damping_ratio, integral)
    return TaskComputedTorque(robot, task, gains, reference, Gains.from_natural_frequency(robot.n, rest_frequency))
