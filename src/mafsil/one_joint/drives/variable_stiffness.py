"""Joints whose stiffness is chosen beside their torque, by two motors; and what a spring of software is worth.

Two cables run over a pulley, each with a spring whose force grows as the square of its extension, f = c x^2. Motors
stretch them to x1 and x2; the joint feels

    tau = c R (x1^2 - x2^2),    k = -d tau/d q = 2 c R^2 (x1 + x2).

Linear springs would not do: their stiffness is the same at every extension.

Reference: Migliore, Brown and DeWeerth, Biologically inspired joint stiffness control, ICRA 2005.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Status
from mafsil.arrays import Floats
from mafsil.one_joint.arguments import above_zero, check_batch, finite, magnitude, together
from mafsil.one_joint.polynomial import Complexes
from mafsil.one_joint.row_answer import RowAnswer


@dataclass(frozen=True, eq=False, slots=True)
class VariableStiffness:
    """Two motors that pull a joint by springs of quadratic force.

    Attributes:
        spring: c (*batch) [N/m^2].
        radius: R (*batch) of the joint's pulley [m].
        motor_radius: r (*batch) of the motors' pulleys [m].
        longest: most that a spring may be stretched (*batch) [m].
    """

    spring: Floats
    radius: Floats
    motor_radius: Floats
    longest: Floats
    __post_init__ = check_batch(spring=above_zero, radius=above_zero, motor_radius=above_zero, longest=above_zero)

    @classmethod
    def of(cls, spring: ArrayLike, radius: ArrayLike, motor_radius: ArrayLike, longest: ArrayLike) -> VariableStiffness:
        """From its numbers, each a number or (*batch).

        Raises:
            InputError: a number that is not positive, shapes that do not go together.
        """
        return cls(*together(spring=spring, radius=radius, motor_radius=motor_radius, longest=longest))

    def extensions(self, q: ArrayLike, first: ArrayLike, second: ArrayLike) -> tuple[Floats, Floats]:
        """x1, x2 (*batch) of the springs [m]; a slack one has 0.

        Args:
            q: (*batch) of the joint [rad].
            first, second: (*batch) of the motors, each positive where it pulls its own cable in [rad].
        """
        angle, one, two, _ = together(
            q=finite("q", q), first=finite("first", first), second=finite("second", second), radius=self.radius
        )
        turn = self.radius * angle
        pulls = (self.motor_radius * one - turn, self.motor_radius * two + turn)
        return np.maximum(pulls[0], 0.0), np.maximum(pulls[1], 0.0)

    def torque(self, q: ArrayLike, first: ArrayLike, second: ArrayLike) -> Floats:
        """(*batch) on the joint [N m]."""
        x, y = self.extensions(q, first, second)
        return self.spring * self.radius * (x * x - y * y)

    def stiffness(self, q: ArrayLike, first: ArrayLike, second: ArrayLike) -> Floats:
        """(*batch) of the joint with the motors held [N m/rad]."""
        x, y = self.extensions(q, first, second)
        return 2.0 * self.spring * self.radius**2 * (x + y)

    def energy(self, q: ArrayLike, first: ArrayLike, second: ArrayLike) -> Floats:
        """(*batch) in both springs [J]."""
        x, y = self.extensions(q, first, second)
        return self.spring * (x**3 + y**3) / 3.0

    def command(self, q: ArrayLike, torque: ArrayLike, stiffness: ArrayLike) -> StiffnessCommand:
        """Where both motors go for a torque and a stiffness at once.

        x1 + x2 follows from the stiffness, x1 - x2 = tau / (c R (x1 + x2)) from the torque.

        Args:
            q: (*batch) of the joint [rad].
            torque: (*batch) [N m].
            stiffness: (*batch), above zero [N m/rad].

        Raises:
            InputError: not finite, out of range, shapes that do not go together.
        """
        angle, tau, k, c, R, r, longest = together(
            q=finite("q", q), torque=finite("torque", torque), stiffness=above_zero("stiffness", stiffness),
            spring=self.spring, radius=self.radius, motor_radius=self.motor_radius, longest=self.longest,
        )  # fmt: skip
        both = k / (2.0 * c * R * R)
        apart = tau / (c * R * both)
        x, y = 0.5 * (both + apart), 0.5 * (both - apart)
        slack, torn = np.minimum(x, y) < 0.0, np.maximum(x, y) > longest
        verdict = np.where(slack, 1, np.where(torn, 2, 0)).astype(np.int8)
        # Both springs pull while |x1 - x2| <= x1 + x2; the longer one ends at its limit.
        softest = 2.0 * R * np.sqrt(c * R * np.abs(tau))
        stiffest = 2.0 * c * R * R * (longest + np.sqrt(np.maximum(longest**2 - np.abs(tau) / (c * R), 0.0)))
        reachable = np.abs(tau) <= c * R * longest**2
        bounds = (np.where(reachable, softest, np.nan), np.where(reachable, stiffest, np.nan))
        fine = verdict == 0
        motors = (np.where(fine, (x + R * angle) / r, np.nan), np.where(fine, (y - R * angle) / r, np.nan))
        return StiffnessCommand(verdict, *motors, *bounds)


class StiffnessStatus(Status):
    """Whether torque and stiffness can be had together."""

    REACHED = ("one_joint.stiffness_reached", True)
    SLACK = ("one_joint.stiffness_slack", False)
    OVERSTRETCHED = ("one_joint.stiffness_overstretched", False)


@dataclass(frozen=True, eq=False, repr=False)
class StiffnessCommand(RowAnswer):
    """Where two motors go for a torque and a stiffness; true if they can, in every row.

    Attributes:
        verdict: (*batch) which of `statuses`.
        first, second: (*batch) angles of the motors; NaN where they cannot [rad].
        softest, stiffest: (*batch) the stiffnesses that can be had with this torque; NaN if the torque itself is too
            much [N m/rad].
    """

    statuses: ClassVar[tuple[Status, ...]] = tuple(StiffnessStatus)
    verdict: NDArray[np.int8]
    first: Floats
    second: Floats
    softest: Floats
    stiffest: Floats


def software_stiffness(
    stiffness: ArrayLike, bandwidth: ArrayLike, frequency: ArrayLike, delay: ArrayLike = 0.0
) -> Complexes:
    """What a spring of software is to a disturbance at a frequency: k e^(-jwT) / (1 + jw/w_b) (*batch) [N m/rad].

    Its real part is the spring, its imaginary part over w a damper; that is negative: such a spring gives energy.
    Only far below the bandwidth is it the spring that was asked for; springs of steel are so at every frequency.

    Args:
        stiffness: k (*batch) that was asked for [N m/rad].
        bandwidth: w_b (*batch) of the motor's torque [rad/s].
        frequency: w (*batch) of the disturbance [rad/s].
        delay: T (*batch) of sensor and computer [s].
    """
    k, w_b, w, T = together(
        stiffness=magnitude("stiffness", stiffness), bandwidth=above_zero("bandwidth", bandwidth),
        frequency=magnitude("frequency", frequency), delay=magnitude("delay", delay),
    )  # fmt: skip
    return np.asarray(k * np.exp(-1j * w * T) / (1.0 + 1j * w / w_b))
