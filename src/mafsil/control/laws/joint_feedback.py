"""Laws without inertia: PID of every joint for itself, with or without gravity compensation; pure feedforward."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, JointVector, as_batch, frozen, real_array, require_kind, whole
from mafsil.control.joints.friction_compensation import friction_along
from mafsil.control.laws.feedback import Integral, pd
from mafsil.control.laws.gains import Gains
from mafsil.control.laws.law import Law
from mafsil.errors import InputError
from mafsil.robot import Robot, of_robot
from mafsil.trajectory import Motion


@dataclass(frozen=True, eq=False, slots=True)
class JointFeedback:
    """tau = Kp (u - q) + Kd (v - qd) + Ki int (u - q), plus g(q) + friction(v) if there is a model.

    Attributes:
        gains: in units of effort.
        model: the robot whose gravity is compensated, or None.
        effort_limit: (n,) at which the integral of a joint waits (anti-windup), or None.
        friction: whether the friction of the model is compensated, too, at the rates of the reference.
    """

    gains: Gains
    model: Robot | None = None
    effort_limit: Floats | None = None
    friction: bool = True

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Joint efforts (*batch, n) without the integral term, which needs a session [N m | N]."""
        effort = pd(self.gains, q, qd, reference)
        if self.model is None:
            return effort
        effort = effort + self.model.gravity_torque(q)
        return effort + friction_along(self.model, reference) if self.friction else effort

    def session(self, period: float) -> Law:
        """The law with a fresh integral; the law itself if Ki is zero."""
        return _WithIntegral(self, period) if self.gains.integrates else self


class _WithIntegral:
    """One run of a joint feedback law."""

    def __init__(self, law: JointFeedback, period: float) -> None:
        self._law = law
        self.integral = Integral(law.gains, period)

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        effort, limit = self._law(t, q, qd, reference), self._law.effort_limit
        if limit is None:
            return effort + self.integral(q, reference)
        return self.integral.within(effort, limit, q, reference)

    def go_on(self, before: _WithIntegral) -> None:
        self.integral.go_on(before.integral)

    def session(self, period: float) -> Law:
        return self._law.session(period)


@dataclass(frozen=True, eq=False, slots=True)
class Feedforward:
    """tau = M(u) a + c(u, v) + g(u) + friction(v): the efforts of the reference, blind to the state.

    Attributes:
        robot: the model.
        friction: whether the friction of the model is compensated.
    """

    robot: Robot
    friction: bool = True

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Joint efforts (*batch, n) [N m | N]."""
        effort = self.robot.inverse_dynamics(reference.u, reference.v, reference.a) + 0.0 * q
        return effort + friction_along(self.robot, reference) if self.friction else effort

    def session(self, period: float) -> Law:
        """The law itself: it has no memory."""
        return self


def pid(
    n: int, kp: ArrayLike, kd: ArrayLike = 0.0, ki: ArrayLike = 0.0, *, effort_limit: ArrayLike | None = None
) -> JointFeedback:
    """Independent PID of n joints.

    Args:
        n: number of joints.
        kp, kd, ki: a number or (n,) [N m/rad | N/m], per (rad/s | m/s), per (rad s | m s).
        effort_limit: a number or (n,): nothing is added to the integral of a joint while that would drive its effort
            further beyond this (anti-windup); if None the integral always grows [N m | N].

    Raises:
        InputError: no number of joints, a wrong shape, a negative gain, a limit that is not positive.

    Reference: Lynch and Park, Modern Robotics, sec. 11.4.1.
    """
    return JointFeedback(Gains.of(whole("n", n, least=1), kp, kd, ki), None, _limits(n, effort_limit))


@of_robot
def gravity_compensation(
    robot: Robot, kp: ArrayLike, kd: ArrayLike, ki: ArrayLike = 0.0, *, effort_limit: ArrayLike | None = None,
    friction: bool = True,
) -> JointFeedback:  # fmt: skip
    """PD (or PID) of every joint plus the model's gravity and friction: globally stable at a set point.

    Args:
        robot: the model.
        kp, kd, ki: a number or (n,) [N m/rad | N/m], per (rad/s | m/s), per (rad s | m s).
        effort_limit: as of `pid`.
        friction: whether the friction that the description has is compensated; False for a plant without friction.

    Reference: Lynch and Park, Modern Robotics, sec. 11.4.2.
    """
    require_kind("robot", robot, "Robot", "gravity_torque")
    limits = _limits(robot.n, effort_limit)
    return JointFeedback(Gains.of(robot.n, kp, kd, ki), robot, limits, friction)


def _limits(n: int, given: ArrayLike | None) -> Floats | None:
    """(n,) limits; None where all are infinite."""
    if given is None:
        return None
    limits = real_array("effort_limit", given)
    limits = as_batch("effort_limit", np.full(n, limits) if limits.ndim == 0 else limits, (n,))
    if not (limits > 0.0).all():
        raise InputError("input.positive", name="effort_limit", value=float(limits.min()))
    return frozen(limits) if np.isfinite(limits).any() else None


@of_robot
def feedforward(robot: Robot, *, friction: bool = True) -> Feedforward:
    """Feedforward: the model's efforts for the reference; combine it with a feedback law.

    Args:
        robot: the model.
        friction: whether the friction that the description has is compensated; False for a plant without friction.
    """
    return Feedforward(robot, friction)
