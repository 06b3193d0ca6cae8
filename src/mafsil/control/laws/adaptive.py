"""Adaptive control after Slotine and Li: the law learns the payload that the model does not know."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, JointVector, as_batch
from mafsil.control.laws.feedback import Gains, RunningSum
from mafsil.control.laws.law import Law
from mafsil.errors import InputError
from mafsil.robot import Robot, of_robot
from mafsil.trajectory import Motion

PARAMETERS = 10
"""Of a rigid body: mass, first moments, inertia about the tip frame's origin."""


@dataclass(frozen=True, eq=False, slots=True)
class AdaptiveControl:
    """tau = M qdd_r + C qd_r + g + Y a + Kd s,  da/dt = G Y' s,  s = (v - qd) + L (u - q).

    qd_r = v + L (u - q) is the rate that would reduce the error. V = s' M s/2 + (a - a*)' G^-1 (a - a*)/2 falls by
    s' Kd s whatever the true a* is, so the error goes to zero; a goes to a* where the motion excites it.

    Attributes:
        robot: the model without payload.
        rates: (n,) L [1/s].
        damping: (n,) Kd [N m s/rad | N s/m].
        learning: (10,) diagonal of G: mass, first moments, and the inertias (xx, yy, zz, xy, xz, yz) at the tip frame.
        initial: (10,) a at the start.
    """

    robot: Robot
    rates: Floats
    damping: Floats
    learning: Floats
    initial: Floats

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Joint efforts (*batch, n) with the parameters of the start; a session learns [N m | N]."""
        return self.effort(q, qd, reference, self.initial)[0]

    def effort(self, q: JointVector, qd: JointVector, reference: Motion, parameters: Floats) -> tuple[Floats, Floats]:
        """Efforts (*batch, n), and by what the parameters grow in time, Y' s (*batch, 10).

        The Coriolis terms are those of Christoffel's symbols, symmetric in both rates: C(q, x) y is half of what
        c(x + y) has beyond c(x) and c(y).

        Args:
            q, qd: (*batch, n) state.
            reference: desired motion.
            parameters: (*batch, 10) a.
        """
        e = reference.u - q
        rate = reference.v + self.rates * e
        growth = reference.a + self.rates * (reference.v - qd)
        s = rate - qd
        model = self.robot
        c = 0.5 * (model.velocity_torque(q, qd + rate) - model.velocity_torque(q, qd) - model.velocity_torque(q, rate))
        still = np.zeros_like(q + rate)
        known = model.inverse_dynamics(q, still, growth) + c
        Y = self._regressor(q, qd, rate, growth)
        tau = known + (Y @ parameters[..., None])[..., 0] + self.damping * s
        return tau, (np.swapaxes(Y, -1, -2) @ s[..., None])[..., 0]

    def _regressor(self, q: JointVector, qd: JointVector, rate: Floats, growth: Floats) -> Floats:
        """(*batch, n, 10) of the payload, with the Coriolis terms as above."""
        model = self.robot
        still = np.zeros_like(rate)
        at_rest = model.payload_regressor(q, still, still)
        terms = [model.payload_regressor(q, x, still) - at_rest for x in (qd + rate, qd, rate)]
        return model.payload_regressor(q, still, growth) + 0.5 * (terms[0] - terms[1] - terms[2])

    def session(self, period: float) -> Law:
        """The law with parameters that learn from the start."""
        return Learning(self, period)


class Learning:
    """One run of an adaptive law.

    Args:
        law: whose run it is.
        period: between calls [s].
    """

    def __init__(self, law: AdaptiveControl, period: float) -> None:
        self._law, self._period = law, period
        self._sum = RunningSum(law.initial)

    @property
    def parameters(self) -> Floats:
        """(*batch, 10) what has been learned."""
        return self._sum.value

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Efforts (*batch, n) with what has been learned, and one step of learning."""
        tau, slope = self._law.effort(q, qd, reference, self.parameters)
        self._sum.add(self._period * self._law.learning * slope)
        return tau

    def go_on(self, before: Learning) -> None:
        """Take over what an earlier session knows.

        Args:
            before: which has ended.
        """
        self._sum.go_on(before._sum)

    def session(self, period: float) -> Law:
        """A new run."""
        return self._law.session(period)


@of_robot
def adaptive_control(
    robot: Robot,
    *,
    rate: ArrayLike = 5.0,
    damping: ArrayLike = 20.0,
    learning: ArrayLike = 1.0,
    initial: ArrayLike | None = None,
) -> AdaptiveControl:
    """Adaptive control: mass, first moments and inertia of a payload are estimated while a motion is tracked.

    Args:
        robot: the model without payload.
        rate: L, a number or (n,) [1/s].
        damping: Kd, a number or (n,) [N m s/rad | N s/m].
        learning: diagonal of G, a number or (10,); zero keeps a parameter as it is.
        initial: (10,) parameters at the start; none if None.

    Raises:
        InputError: a wrong shape, a negative gain.
        ModelError: the robot has no masses.

    Reference: Slotine and Li, On the adaptive control of robot manipulators, IJRR 6(3), 1987.
    """
    start = np.zeros(PARAMETERS) if initial is None else as_batch("initial", initial, (PARAMETERS,), finite=True)
    speed = np.asarray(learning, dtype=np.float64)
    if speed.shape not in ((), (PARAMETERS,)) or not (speed >= 0.0).all():
        raise InputError("input.shape", name="learning", expected=(PARAMETERS,), got=speed.shape, hint="")
    gains = Gains.of(robot.n, rate, damping)
    return AdaptiveControl(robot, gains.kp, gains.kd, np.broadcast_to(speed, (PARAMETERS,)).copy(), np.array(start))
