"""Computed torque: the model turns the desired acceleration into efforts, so the error obeys linear equations."""

from __future__ import annotations

from dataclasses import dataclass

from numpy.typing import ArrayLike

from mafsil.arrays import Floats, JointVector, require_kind
from mafsil.control.joints.friction_compensation import friction_along
from mafsil.control.laws.feedback import Integral, pd
from mafsil.control.laws.gains import Gains
from mafsil.control.laws.law import Law
from mafsil.robot import Robot, of_robot
from mafsil.trajectory import Motion


@dataclass(frozen=True, eq=False, slots=True)
class ComputedTorque:
    """tau = M(q) (a + Kd (v - qd) + Kp (u - q) + Ki int (u - q)) + c(q, qd) + g(q) + friction(v).

    Attributes:
        robot: the model; it may differ from the plant.
        gains: in units of acceleration.
        friction: whether the friction of the model is compensated, at the rates of the reference.
    """

    robot: Robot
    gains: Gains
    friction: bool = True

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Joint efforts (*batch, n) without the integral term, which needs a session [N m | N]."""
        return self.effort(q, qd, reference, pd(self.gains, q, qd, reference))

    def effort(self, q: JointVector, qd: JointVector, reference: Motion, feedback: Floats) -> JointVector:
        """Joint efforts (*batch, n) [N m | N].

        Args:
            q, qd: (*batch, n) state.
            reference: where they should be.
            feedback: (*batch, n) acceleration that is added to that of the reference.
        """
        effort = self.robot.inverse_dynamics(q, qd, reference.a + feedback)
        return effort + friction_along(self.robot, reference) if self.friction else effort

    def session(self, period: float) -> Law:
        """The law with a fresh integral; the law itself if Ki is zero."""
        return _WithIntegral(self, period) if self.gains.integrates else self


class _WithIntegral:
    """One run of a computed torque law."""

    def __init__(self, law: ComputedTorque, period: float) -> None:
        self._law = law
        self.integral = Integral(law.gains, period)

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        feedback = pd(self._law.gains, q, qd, reference) + self.integral(q, reference)
        return self._law.effort(q, qd, reference, feedback)

    def go_on(self, before: _WithIntegral) -> None:
        self.integral.go_on(before.integral)

    def session(self, period: float) -> Law:
        return self._law.session(period)


@of_robot
def computed_torque(
    robot: Robot, *, natural_frequency: ArrayLike = 20.0, damping_ratio: ArrayLike = 1.0, integral: ArrayLike = 0.0,
    friction: bool = True,
) -> ComputedTorque:  # fmt: skip
    """Computed torque with gains by natural frequency and damping; the error obeys e'' + 2 zeta w e' + w^2 e = 0.

    Args:
        robot: the model.
        natural_frequency: w, a number or (n,) [rad/s].
        damping_ratio: zeta, a number or (n,); 1 is critical damping.
        integral: Ki, a number or (n,) [1/s^3]; below 2 zeta w^3.
        friction: whether the friction that the description has is compensated; False for a plant without friction.

    Raises:
        InputError: a wrong shape, a negative number, an integral gain that makes the loop unstable.

    Reference: Lynch and Park, Modern Robotics, sec. 11.4.2.
    """
    require_kind("robot", robot, "Robot", "inverse_dynamics")
    gains = Gains.from_natural_frequency(robot.n, natural_frequency, damping_ratio, integral)
    return ComputedTorque(robot, gains, friction)
