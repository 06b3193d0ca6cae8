"""A geared joint ruled by friction as a system of first order, beside the same joint with its inertia."""

from __future__ import annotations

from dataclasses import dataclass

from numpy.typing import ArrayLike

from mafsil.arrays import Floats
from mafsil.one_joint.arguments import above_zero, check_batch, finite, together
from mafsil.one_joint.error_dynamics import ErrorDynamics


@dataclass(frozen=True, eq=False, slots=True)
class ViscousJoint:
    """b theta' = tau - tau_load: what is left of a joint where M / b is short against the loop.

    Attributes:
        inertia: M (*batch), left out by the first order [kg m^2 | kg].
        friction: b (*batch) of the joint, motor included [N m s/rad | N s/m].
    """

    inertia: Floats
    friction: Floats
    __post_init__ = check_batch(inertia=above_zero, friction=above_zero)

    @classmethod
    def of(cls, inertia: ArrayLike, friction: ArrayLike) -> ViscousJoint:
        """From its numbers, each a number or (*batch), above zero.

        Raises:
            InputError: a number out of its range, shapes that do not go together.
        """
        return cls(*together(inertia=inertia, friction=friction))

    def speed(self, torque: ArrayLike, load: ArrayLike = 0.0) -> Floats:
        """(*batch) theta' = (tau - tau_load) / b [rad/s | m/s].

        Args:
            torque, load: (*batch) [N m | N].
        """
        tau, pull, b = together(torque=finite("torque", torque), load=finite("load", load), friction=self.friction)
        return (tau - pull) / b

    def time_constant(self, kp: ArrayLike) -> Floats:
        """(*batch) b / Kp: in which the error falls to 37 % under proportional control [s].

        Args:
            kp: (*batch) above zero [N m/rad | N/m].
        """
        b, k = together(friction=self.friction, kp=above_zero("kp", kp))
        return b / k

    def inertia_share(self, kp: ArrayLike) -> Floats:
        """(*batch) (M / b) / (b / Kp): how slow the inertia is against the loop; small where first order holds.

        Args:
            kp: (*batch) above zero [N m/rad | N/m].
        """
        return self.inertia / self.friction / self.time_constant(kp)

    def first_order(self, kp: ArrayLike) -> ErrorDynamics:
        """b e' + Kp e = 0."""
        b, k = together(friction=self.friction, kp=above_zero("kp", kp))
        return ErrorDynamics.of(b, k)

    def second_order(self, kp: ArrayLike) -> ErrorDynamics:
        """M e'' + b e' + Kp e = 0: the same loop with the inertia, to compare."""
        M, b, k = together(inertia=self.inertia, friction=self.friction, kp=above_zero("kp", kp))
        return ErrorDynamics.of(M, b, k)
