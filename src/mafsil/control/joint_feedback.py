"""Laws without inertia: PID of every joint for itself, with or without gravity compensation; pure feedforward."""

from __future__ import annotations

from dataclasses import dataclass

from numpy.typing import ArrayLike

from mafsil.arrays import JointVector, require_kind, whole
from mafsil.control.feedback import Integral, pd
from mafsil.control.gains import Gains
from mafsil.control.law import Law
from mafsil.robot import Robot, of_robot
from mafsil.trajectory import Motion


@dataclass(frozen=True, eq=False, slots=True)
class JointFeedback:
    """tau = Kp (u - q) + Kd (v - qd) + Ki int (u - q), plus g(q) if there is a model.

    Attributes:
        gains: in units of effort.
        model: the robot whose gravity is compensated, or None.
    """

    gains: Gains
    model: Robot | None = None

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Joint efforts (*batch, n) without the integral term, which needs a session [N m | N]."""
        effort = pd(self.gains, q, qd, reference)
        return effort if self.model is None else effort + self.model.gravity_torque(q)

    def session(self, period: float) -> Law:
        """The law with a fresh integral; the law itself if Ki is zero."""
        return _WithIntegral(self, period) if self.gains.integrates else self


class _WithIntegral:
    """One run of a joint feedback law."""

    def __init__(self, law: JointFeedback, period: float) -> None:
        self._law = law
        self._integral = Integral(law.gains, period)

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        return self._law(t, q, qd, reference) + self._integral(q, reference)

    def go_on(self, before: _WithIntegral) -> None:
        self._integral.go_on(before._integral)

    def session(self, period: float) -> Law:
        return self._law.session(period)


@dataclass(frozen=True, eq=False, slots=True)
class Feedforward:
    """tau = M(u) a + c(u, v) + g(u): the efforts of the reference, blind to the state."""

    robot: Robot

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Joint efforts (*batch, n) [N m | N]."""
        return self.robot.inverse_dynamics(reference.u, reference.v, reference.a) + 0.0 * q

    def session(self, period: float) -> Law:
        """The law itself: it has no memory."""
        return self


def pid(n: int, kp: ArrayLike, kd: ArrayLike = 0.0, ki: ArrayLike = 0.0) -> JointFeedback:
    """Independent PID of n joints.

    Args:
        n: number of joints.
        kp, kd, ki: a number or (n,) [N m/rad | N/m], per (rad/s | m/s), per (rad s | m s).

    Raises:
        InputError: no number of joints, a wrong shape, a negative gain.

    Reference: Lynch and Park, Modern Robotics, sec. 11.4.1.
    """
    return JointFeedback(Gains.of(whole("n", n, least=1), kp, kd, ki))


@of_robot
def gravity_compensation(robot: Robot, kp: ArrayLike, kd: ArrayLike, ki: ArrayLike = 0.0) -> JointFeedback:
    """PD (or PID) of every joint plus the model's gravity: globally stable at a set point.

    Args:
        robot: the model.
        kp, kd, ki: a number or (n,) [N m/rad | N/m], per (rad/s | m/s), per (rad s | m s).

    Reference: Lynch and Park, Modern Robotics, sec. 11.4.2.
    """
    require_kind("robot", robot, "Robot", "gravity_torque")
    return JointFeedback(Gains.of(robot.n, kp, kd, ki), robot)


@of_robot
def feedforward(robot: Robot) -> Feedforward:
    """The efforts that the model needs for the reference; combine it with a feedback law.

    Args:
        robot: the model.
    """
    return Feedforward(robot)
