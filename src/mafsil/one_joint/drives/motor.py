"""A DC motor in torque mode: what it can do, how fast its inner loop makes torque true, and how true at the joint.

Torque behind a gear is held by current control alone, or by a loop around a strain gauge at the gear's output.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Status
from mafsil.arrays import Booleans, Floats, require_kind
from mafsil.errors import InputError
from mafsil.one_joint.error_dynamics import ErrorDynamics
from mafsil.one_joint.polynomial import Complexes, polynomial_value
from mafsil.one_joint.rows import RowAnswer, above_zero, check_batch, finite, magnitude, row, together


@dataclass(frozen=True, eq=False, slots=True)
class Motor:
    """V = R i + L i' + k w, tau = k i, in SI units, in which k is one constant.

    Attributes:
        constant: k (*batch) [N m/A = V s/rad].
        resistance: R (*batch) [ohm].
        inductance: L (*batch) [H].
        voltage: most that the amplifier gives (*batch) [V].
    """

    constant: Floats
    resistance: Floats
    inductance: Floats
    voltage: Floats
    __post_init__ = check_batch(constant=above_zero, resistance=above_zero, inductance=above_zero, voltage=above_zero)

    @classmethod
    def of(cls, constant: ArrayLike, resistance: ArrayLike, inductance: ArrayLike, voltage: ArrayLike) -> Motor:
        """From its data sheet, each a number or (*batch).

        Raises:
            InputError: a number that is not positive, shapes that do not go together.
        """
        return cls(*together(constant=constant, resistance=resistance, inductance=inductance, voltage=voltage))

    @property
    def stall_torque(self) -> Floats:
        """(*batch) k V / R at rest [N m]."""
        return self.constant * self.voltage / self.resistance

    @property
    def no_load_speed(self) -> Floats:
        """(*batch) V / k [rad/s]."""
        return self.voltage / self.constant

    @property
    def electrical_time_constant(self) -> Floats:
        """(*batch) L / R [s]."""
        return self.inductance / self.resistance

    def torque_range(self, speed: ArrayLike) -> tuple[Floats, Floats]:
        """Least and greatest steady torque (*batch) at a speed: k (-+V - k w) / R [N m]."""
        back = self.constant * finite("speed", speed)
        scale = self.constant / self.resistance
        return scale * (-self.voltage - back), scale * (self.voltage - back)

    def current_loop(self, bandwidth: ArrayLike) -> CurrentLoop:
        """PI gains of the inner loop that cancel R / L: kp = w L, ki = w R, so i / i_d = w / (s + w).

        Args:
            bandwidth: w (*batch) [rad/s].
        """
        w = above_zero("bandwidth", bandwidth)
        return CurrentLoop(self, *together(kp=w * self.inductance, ki=w * self.resistance))


@dataclass(frozen=True, eq=False, slots=True)
class CurrentLoop:
    """The amplifier in torque mode: it senses the current and regulates it, v = kp (i_d - i) + ki int (i_d - i).

    Attributes:
        motor: what it drives.
        kp, ki: (*batch) [V/A, V/(A s)].
    """

    motor: Motor
    kp: Floats
    ki: Floats
    __post_init__ = check_batch(kp=magnitude, ki=magnitude)

    @property
    def dynamics(self) -> ErrorDynamics:
        """Of the current: L i'' + (R + kp) i' + ki i = ..."""
        return ErrorDynamics.of(self.motor.inductance, self.motor.resistance + self.kp, self.ki)

    def torque_realised(self, frequency: ArrayLike) -> Complexes:
        """Torque produced per torque commanded, (*batch, k) at frequencies (k,) [rad/s], the rotor at rest.

        (kp s + ki) / (L s^2 + (R + kp) s + ki).
        """
        s = np.asarray(1j * row("frequency", frequency), dtype=np.complex128)
        top = np.stack(np.broadcast_arrays(self.kp, self.ki), axis=-1)
        return polynomial_value(top, s) / polynomial_value(self.dynamics.coefficients, s)

    def back_emf_torque(self, frequency: ArrayLike) -> Complexes:
        """Torque per speed that the back-emf takes before the loop has answered, (*batch, k) [N m s/rad].

        -k^2 s / (L s^2 + (R + kp) s + ki): damping that vanishes at low frequency.
        """
        s = np.asarray(1j * row("frequency", frequency), dtype=np.complex128)
        k = self.motor.constant
        return -((k * k)[..., None]) * s / polynomial_value(self.dynamics.coefficients, s)

    def step_response(self, t: ArrayLike) -> Floats:
        """Share of a torque step that is there after times (k,) [s], (*batch, k), the rotor at rest."""
        L = self.motor.inductance
        start = np.stack(np.broadcast_arrays(np.ones_like(L), -self.kp / L), axis=-1)
        return 1.0 - self.dynamics.response(t, start)

    def reachable(self, torque: ArrayLike, speed: ArrayLike) -> DriveAnswer:
        """Whether torque (*batch) [N m] can be held at a speed (*batch) [rad/s] with the amplifier's voltage."""
        return operating_point(self.motor, torque, speed)


class DriveStatus(Status):
    """Whether the drive can do it."""

    REACHABLE = ("one_joint.drive_reachable", True)
    SATURATED = ("one_joint.drive_saturated", False)


@dataclass(frozen=True, eq=False, repr=False)
class DriveAnswer(RowAnswer):
    """Whether a drive holds a torque at a speed; true if it does, in every row.

    Attributes:
        verdict: (*batch) which of `statuses`.
        voltage: (*batch) that it takes [V].
        available: (*batch) that there is [V].
        current: (*batch) [A].
        losses: (*batch) R i^2 [W].
    """

    statuses: ClassVar[tuple[Status, ...]] = tuple(DriveStatus)
    verdict: NDArray[np.int8]
    voltage: Floats
    available: Floats
    current: Floats
    losses: Floats


def operating_point(motor: Motor, torque: ArrayLike, speed: ArrayLike) -> DriveAnswer:
    """The operating point of a motor at a steady torque and speed.

    Args:
        motor: with its amplifier's voltage.
        torque: (*batch) on the motor's side [N m].
        speed: (*batch) [rad/s].

    Raises:
        InputError: not finite, shapes that do not go together.
    """
    require_kind("motor", motor, "Motor", "constant", "resistance", "voltage")
    tau, w, k, R, V = together(
        torque=finite("torque", torque), speed=finite("speed", speed), constant=motor.constant,
        resistance=motor.resistance, voltage=motor.voltage,
    )  # fmt: skip
    i = tau / k
    needed = R * i + k * w
    verdict = np.where(np.abs(needed) <= V, 0, 1).astype(np.int8)
    return DriveAnswer(verdict, needed, V, i, R * i * i)


def joint_with_drive(
    inertia: ArrayLike, damping: ArrayLike, kp: ArrayLike, torque_bandwidth: ArrayLike
) -> ErrorDynamics:
    """PD control through a drive of finite bandwidth: the loop gains an order.

    M e'' + b' e' = -tau, tau' = w_t (Kp e + Kd e' - tau): M / w_t e''' + M e'' + d e' + Kp e = 0, d all damping that
    passes through the drive.

    Args:
        inertia: M (*batch) [kg m^2].
        damping: Kd (*batch) [N m s/rad]; friction of the joint itself is left out, which is on the safe side.
        kp: (*batch) [N m/rad].
        torque_bandwidth: w_t (*batch) [rad/s].

    Returns:
        Error dynamics of order 3: stable exactly if Kd w_t > Kp.
    """
    M, d, k, w = together(
        inertia=above_zero("inertia", inertia), damping=magnitude("damping", damping), kp=magnitude("kp", kp),
        torque_bandwidth=above_zero("torque_bandwidth", torque_bandwidth),
    )  # fmt: skip
    if not np.isfinite(M / w).all():
        raise InputError("input.positive", name="torque_bandwidth", value=float(w.min()))
    return ErrorDynamics.of(M / w, M, d, k)


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
