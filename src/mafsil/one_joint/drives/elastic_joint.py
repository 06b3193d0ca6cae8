"""Joints that give way: an elastic transmission and the bandwidth that it allows, stiffness chosen by two motors.

An elastic transmission has a first mode and loops of fourth order. For variable stiffness two cables run over a pulley,
each with a spring whose force grows as the square of its extension, f = c x^2. Motors stretch them to x1 and x2; the
joint feels

    tau = c R (x1^2 - x2^2),    k = -d tau/d q = 2 c R^2 (x1 + x2).

Linear springs would not do: their stiffness is the same at every extension.

Reference: Migliore, Brown and DeWeerth, Biologically inspired joint stiffness control, ICRA 2005.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Status
from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.one_joint.error_dynamics import ErrorDynamics
from mafsil.one_joint.polynomial import Complexes
from mafsil.one_joint.rows import RowAnswer, above_zero, check_batch, finite, magnitude, together
from mafsil.one_joint.tolerances import SOFTEST

Side = Literal["motor", "link"]
SAFE_SHARE = 0.5
"""Of the locked frequency up to which a loop designed for a rigid joint may go. Reference: Paul, Robot Manipulators,
1981, sec. 7.3."""
KEPT = 0.9
"""Share of the wanted damping ratio that the dominant roots must keep."""
HALVINGS = 100
"""In the search for the largest gain."""


@dataclass(frozen=True, eq=False, slots=True)
class ElasticJoint:
    """Two inertias and a spring with a damper between them, all seen at the link.

    M q'' + b q' = k (p - q) + d (p' - q'),  B p'' + b_m p' = tau - k (p - q) - d (p' - q')

    Attributes:
        link_inertia: M (*batch) [kg m^2].
        motor_inertia: B = G^2 I_m (*batch) [kg m^2].
        stiffness: k (*batch) [N m/rad].
        damping: d (*batch) of the transmission [N m s/rad].
        link_friction, motor_friction: b, b_m (*batch), viscous [N m s/rad].
    """

    link_inertia: Floats
    motor_inertia: Floats
    stiffness: Floats
    damping: Floats
    link_friction: Floats
    motor_friction: Floats
    __post_init__ = check_batch(
        link_inertia=above_zero,
        motor_inertia=above_zero,
        stiffness=above_zero,
        damping=magnitude,
        link_friction=magnitude,
        motor_friction=magnitude,
    )

    @classmethod
    def of(
        cls, link_inertia: ArrayLike, motor_inertia: ArrayLike, stiffness: ArrayLike, damping: ArrayLike = 0.0,
        link_friction: ArrayLike = 0.0, motor_friction: ArrayLike = 0.0,
    ) -> ElasticJoint:  # fmt: skip
        """From its numbers, each a number or (*batch).

        Raises:
            InputError: a number out of its range, shapes that do not go together.
        """
        return cls(
            *together(
                link_inertia=link_inertia,
                motor_inertia=motor_inertia,
                stiffness=stiffness,
                damping=damping,
                link_friction=link_friction,
                motor_friction=motor_friction,
            )
        )

    @property
    def locked_frequency(self) -> Floats:
        """(*batch) sqrt(k / M) [rad/s]: the link against a locked motor, the antiresonance of the motor's side."""
        return np.sqrt(self.stiffness / self.link_inertia)

    @property
    def first_mode(self) -> Floats:
        """(*batch) sqrt(k (1 / M + 1 / B)) [rad/s]: both swing against each other."""
        return np.sqrt(self.stiffness * (1.0 / self.link_inertia + 1.0 / self.motor_inertia))

    @property
    def plant(self) -> Floats:
        """(*batch, 5) polynomial of s that multiplies both positions: (M s^2 + ...)(B s^2 + ...) - (d s + k)^2."""
        M, B, k, d = self.link_inertia, self.motor_inertia, self.stiffness, self.damping
        b, b_m = self.link_friction, self.motor_friction
        return np.stack(
            [
                M * B,
                M * (b_m + d) + B * (b + d),
                k * (M + B) + b * b_m + d * (b + b_m),
                k * (b + b_m),
                np.zeros_like(M),
            ],
            axis=-1,
        )

    def pd_loop(self, kp: ArrayLike, kd: ArrayLike, side: Side = "motor") -> ErrorDynamics:
        """The error dynamics of order 4 under tau = Kp e + Kd e' of the motor's or the link's position.

        Args:
            kp, kd: (*batch) at the link [N m/rad], [N m s/rad].
            side: where position and speed are measured.

        Raises:
            InputError: another side, a negative gain.
        """
        P, D, M, b, k, d = together(
            kp=magnitude("kp", kp), kd=magnitude("kd", kd), link_inertia=self.link_inertia, b=self.link_friction,
            stiffness=self.stiffness, damping=self.damping,
        )  # fmt: skip
        if side not in ("motor", "link"):
            raise InputError("input.choice", name="side", value=side, known="motor, link")
        zero = np.zeros_like(P)
        a2, a1, a0 = (M, b + d, k) if side == "motor" else (zero, d, k)
        closing = np.stack([zero, D * a2, P * a2 + D * a1, P * a1 + D * a0, P * a0], axis=-1)
        return ErrorDynamics.from_row(self.plant + closing)

    def largest_kp(self, kd: ArrayLike, side: Side = "link") -> Floats:
        """(*batch) the proportional gain below which the PD loop is stable; infinite if all are, 0 if none is.

        Found by halving on Routh's test, to rounding. On the motor's side no gain destabilises a damped joint.

        Args:
            kd: (*batch) [N m s/rad].
            side: where position and speed are measured.
        """
        D = magnitude("kd", kd) + np.zeros_like(self.stiffness)
        low, high = np.zeros_like(D), np.full_like(D, SOFTEST) * self.stiffness
        for _ in range(80):
            fine = self.pd_loop(high, D, side).stability().stable
            low, high = np.where(fine, high, low), np.where(fine, 4.0 * high, high)
            if not fine.any() or (high > 1e12 * self.stiffness).all():
                break
        free = high > 1e12 * self.stiffness
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            fine = self.pd_loop(middle, D, side).stability().stable
            low, high = np.where(fine, middle, low), np.where(fine, high, middle)
        return np.where(free, np.inf, low)

    def allowed_bandwidth(self, wanted: ArrayLike, damping_ratio: ArrayLike = 1.0, side: Side = "motor") -> Bandwidth:
        """What becomes of gains that were designed as if the joint were rigid.

        Kp = (M + B) w^2, Kd = 2 zeta w (M + B); then the true loop of order 4 is asked.

        Args:
            wanted: w (*batch) natural frequency [rad/s].
            damping_ratio: zeta (*batch).
            side: where position and speed are measured.

        Returns:
            Whether the dominant roots (the two nearest to zero) keep the damping ratio within a tenth, and what the
            rule of half the locked frequency says.
        """
        w, zeta, inertia = together(
            wanted=above_zero("wanted", wanted),
            damping_ratio=above_zero("damping_ratio", damping_ratio),
            inertia=self.link_inertia + self.motor_inertia,
        )
        dynamics = self.pd_loop(inertia * w * w, 2.0 * zeta * w * inertia, side)
        s = dynamics.roots
        ratio = -s.real / np.maximum(np.abs(s), LEAST_DIVISOR)
        near = np.argsort(np.abs(s), axis=-1)[..., :2]
        dominant = np.asarray(np.take_along_axis(ratio, near, axis=-1).min(axis=-1))
        stable = dynamics.stability().stable
        verdict = np.where(~stable, 2, np.where(dominant < KEPT * np.minimum(zeta, 1.0), 1, 0)).astype(np.int8)
        limit = SAFE_SHARE * self.locked_frequency + np.zeros_like(w)
        return Bandwidth(verdict, w, limit, dominant, np.asarray(ratio.min(axis=-1)), np.asarray(-s.real.max(axis=-1)))


class BandwidthStatus(Status):
    """Whether a bandwidth can be had with an elastic joint."""

    ALLOWED = ("one_joint.bandwidth_allowed", True)
    POORLY_DAMPED = ("one_joint.bandwidth_poor", False)
    UNSTABLE = ("one_joint.bandwidth_unstable", False)


@dataclass(frozen=True, eq=False, repr=False)
class Bandwidth(RowAnswer):
    """A wanted bandwidth of an elastic joint; true if the loop is damped as required.

    Attributes:
        verdict: (*batch) which of `statuses`.
        wanted: (*batch) natural frequency [rad/s].
        by_rule: (*batch) half the locked frequency [rad/s].
        damping_ratio: (*batch) of the dominant roots, at most 1.
        least_damping: (*batch) least damping ratio of the four roots; negative if unstable.
        slowest: (*batch) least decay rate [1/s].
    """

    statuses: ClassVar[tuple[Status, ...]] = tuple(BandwidthStatus)
    verdict: NDArray[np.int8]
    wanted: Floats
    by_rule: Floats
    damping_ratio: Floats
    least_damping: Floats
    slowest: Floats


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
