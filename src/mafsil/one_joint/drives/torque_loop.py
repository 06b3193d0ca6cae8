"""How true the torque of a joint is: current control alone, or a loop around a strain gauge at the gear's output."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Booleans, Floats
from mafsil.one_joint.arguments import above_zero, check_batch, magnitude, together
from mafsil.one_joint.error_dynamics import ErrorDynamics
from mafsil.one_joint.polynomial import Complexes


@dataclass(frozen=True, eq=False, slots=True)
class TorqueLoop:
    """tau_m = tau_d + Kp (tau_d - tau) + Ki int (tau_d - tau), with tau = k p measured by the gauge; all at the joint.

    The link is held: B p'' + b p' + k p = tau_m - f, f the dry friction of motor and gear. With Kp = Ki = 0 it is
    current control alone, as direct drives have it.

    Attributes:
        motor_inertia: B = G^2 I_m (*batch) [kg m^2].
        stiffness: k (*batch) of gear and gauge [N m/rad].
        viscous: b (*batch) [N m s/rad].
        dry: f (*batch) [N m].
        kp: (*batch) [1].
        ki: (*batch) [1/s].
    """

    motor_inertia: Floats
    stiffness: Floats
    viscous: Floats
    dry: Floats
    kp: Floats
    ki: Floats
    __post_init__ = check_batch(
        motor_inertia=above_zero, stiffness=above_zero, viscous=magnitude, dry=magnitude, kp=magnitude, ki=magnitude
    )

    @classmethod
    def of(
        cls, motor_inertia: ArrayLike, stiffness: ArrayLike, viscous: ArrayLike = 0.0, dry: ArrayLike = 0.0, *,
        kp: ArrayLike = 0.0, ki: ArrayLike = 0.0,
    ) -> TorqueLoop:  # fmt: skip
        """From its numbers, each a number or (*batch).

        Raises:
            InputError: a number out of its range, shapes that do not go together.
        """
        return cls(*together(motor_inertia=motor_inertia, stiffness=stiffness, viscous=viscous, dry=dry, kp=kp, ki=ki))

    @property
    def dynamics(self) -> ErrorDynamics:
        """Of the torque's error while friction keeps its sense: B s^3 + b s^2 + k (1 + Kp) s + k Ki.

        Where Ki = 0 one of its roots is zero: the integral that is not there.
        """
        row = [self.motor_inertia, self.viscous, self.stiffness * (1.0 + self.kp), self.stiffness * self.ki]
        return ErrorDynamics.from_row(np.stack(row, axis=-1))

    @property
    def largest_ki(self) -> Floats:
        """(*batch) the integral gain below which the loop is stable: b (1 + Kp) / B [1/s]."""
        return self.viscous * (1.0 + self.kp) / self.motor_inertia

    @property
    def stable(self) -> Booleans:
        """(*batch) whether errors of the torque die; without viscous friction they swing for ever."""
        return (self.viscous > 0.0) & (self.ki < self.largest_ki)

    @property
    def steady_error(self) -> Floats:
        """(*batch) largest error of the torque at rest, f / (1 + Kp), and 0 with an integral in the end [N m]."""
        return np.where(self.ki > 0.0, 0.0, self.dry / (1.0 + self.kp))

    def response(self, frequency: ArrayLike) -> Complexes:
        """tau / tau_d (*batch) at a frequency, friction apart: 1 where the torque is true.

        Args:
            frequency: (*batch) [rad/s].
        """
        w, B, k, b, P, I = together(
            frequency=above_zero("frequency", frequency), inertia=self.motor_inertia, stiffness=self.stiffness,
            viscous=self.viscous, kp=self.kp, ki=self.ki,
        )  # fmt: skip
        s = 1j * w
        loop = P + I / s
        return np.asarray(k * (1.0 + loop) / (B * s * s + b * s + k * (1.0 + loop)))
