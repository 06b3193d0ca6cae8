"""Laws of the joints: PID of every joint for itself, computed torque, and efforts known beforehand.

PID goes with or without gravity compensation. With computed torque the model turns the desired acceleration into
efforts, so the error obeys linear equations. Efforts known beforehand are those of the model for the reference, or
those learned from passes before.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, JointVector, as_batch, frozen, real_array, require_kind, whole
from mafsil.control.joints.friction_compensation import friction_along
from mafsil.control.laws.feedback import Gains, Integral, pd
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


@dataclass(frozen=True, eq=False, slots=True)
class LearnedEffort:
    """A table of efforts, one row for each call of the law; nothing after its end.

    Attributes:
        period: between rows [s].
        effort: (k, n) [N m | N].
    """

    period: float
    effort: Floats

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """The efforts of the row at this time (n,), whatever the state is."""
        k = round(t / self.period)
        if not 0 <= k < len(self.effort):
            return np.zeros(self.effort.shape[1:])
        row: Floats = self.effort[k]
        return row

    def session(self, period: float) -> Law:
        """The law itself: it has no memory."""
        return self


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
        return _TorqueRun(self, period) if self.gains.integrates else self


class _TorqueRun:
    """One run of a computed torque law."""

    def __init__(self, law: ComputedTorque, period: float) -> None:
        self._law = law
        self.integral = Integral(law.gains, period)

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        feedback = pd(self._law.gains, q, qd, reference) + self.integral(q, reference)
        return self._law.effort(q, qd, reference, feedback)

    def go_on(self, before: _TorqueRun) -> None:
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
