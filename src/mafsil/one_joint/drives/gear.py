"""Gears: speeds, torques and losses in both directions, the motor's inertia at the link, the ratio that suits.

Play of a gear (backlash): the link follows the motor with a gap, so that its place depends on what was before. Where
friction rules a geared joint, it is a system of first order, beside the same joint with its inertia.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.one_joint.error_dynamics import ErrorDynamics
from mafsil.one_joint.rows import above_zero, check_batch, finite, magnitude, share, together
from mafsil.one_joint.tolerances import ROUNDOFF


@dataclass(frozen=True, eq=False, slots=True)
class Gear:
    """A motor behind a reduction.

    Attributes:
        ratio: G (*batch), motor turns per link turn.
        motor_inertia: I_m (*batch) of the rotor about its own axis [kg m^2].
        efficiency: eta (*batch), share of the power that passes; 1 without loss.
        motor_friction: b_m (*batch), viscous, on the motor's side [N m s/rad].
    """

    ratio: Floats
    motor_inertia: Floats
    efficiency: Floats
    motor_friction: Floats
    __post_init__ = check_batch(ratio=above_zero, motor_inertia=magnitude, efficiency=share, motor_friction=magnitude)

    @classmethod
    def of(
        cls, ratio: ArrayLike, motor_inertia: ArrayLike = 0.0, efficiency: ArrayLike = 1.0,
        motor_friction: ArrayLike = 0.0,
    ) -> Gear:  # fmt: skip
        """From its numbers, each a number or (*batch).

        Raises:
            InputError: a number out of its range, shapes that do not go together.
        """
        return cls(
            *together(ratio=ratio, motor_inertia=motor_inertia, efficiency=efficiency, motor_friction=motor_friction)
        )

    def link_speed(self, motor_speed: ArrayLike) -> Floats:
        """(*batch) motor speed / G [rad/s]."""
        return np.asarray(finite("motor_speed", motor_speed) / self.ratio)

    def link_torque(self, motor_torque: ArrayLike, motor_speed: ArrayLike = 1.0) -> Floats:
        """Torque at the link for a torque at the gear's motor side, without acceleration (*batch) [N m].

        Losses have a direction: eta G tau when the motor drives (torque and speed of one sense, or at rest), and
        G tau / eta when the link drives the motor. Power balances: P_out = eta P_in, or P_in = eta P_out.

        Args:
            motor_torque: (*batch) [N m].
            motor_speed: (*batch) [rad/s].
        """
        tau, w, _ = together(
            motor_torque=finite("motor_torque", motor_torque), motor_speed=finite("motor_speed", motor_speed),
            ratio=self.ratio,
        )  # fmt: skip
        driving = tau * w >= 0.0
        return self.ratio * tau * np.where(driving, self.efficiency, 1.0 / self.efficiency)

    @property
    def reflected_inertia(self) -> Floats:
        """(*batch) G^2 I_m [kg m^2]: what the rotor adds at the link."""
        return self.ratio**2 * self.motor_inertia

    @property
    def reflected_friction(self) -> Floats:
        """(*batch) G^2 b_m [N m s/rad]."""
        return self.ratio**2 * self.motor_friction

    def apparent_inertia(self, link_inertia: ArrayLike) -> Floats:
        """(*batch) I_link + G^2 I_m [kg m^2]."""
        link, rotor = together(link_inertia=magnitude("link_inertia", link_inertia), ratio=self.reflected_inertia)
        return link + rotor

    def motor_share(self, link_inertia: ArrayLike) -> Floats:
        """(*batch) share of the torque that accelerates the rotor: G^2 I_m / (I_link + G^2 I_m)."""
        return self.reflected_inertia / above_zero("apparent inertia", self.apparent_inertia(link_inertia))

    def link_acceleration(self, link_inertia: ArrayLike, motor_torque: ArrayLike) -> Floats:
        """(*batch) eta G tau / (I_link + G^2 I_m) of a motor that drives from rest [rad/s^2]."""
        inertia = above_zero("apparent inertia", self.apparent_inertia(link_inertia))
        tau, inertia = together(motor_torque=finite("motor_torque", motor_torque), link_inertia=inertia)
        return self.efficiency * self.ratio * tau / inertia

    def kinetic_energy(self, link_inertia: ArrayLike, link_speed: ArrayLike) -> Floats:
        """(*batch) of link and rotor [J]."""
        inertia, w = together(
            link_inertia=self.apparent_inertia(link_inertia), link_speed=finite("link_speed", link_speed)
        )
        return 0.5 * inertia * w**2

    def kinetic_power(self, link_inertia: ArrayLike, link_speed: ArrayLike, link_acceleration: ArrayLike) -> Floats:
        """(*batch) rate of the kinetic energy, (I_link + G^2 I_m) theta'' theta' [W].

        Args:
            link_inertia: (*batch) [kg m^2].
            link_speed, link_acceleration: (*batch) [rad/s, rad/s^2].
        """
        inertia, w, a = together(
            link_inertia=self.apparent_inertia(link_inertia), link_speed=finite("link_speed", link_speed),
            link_acceleration=finite("link_acceleration", link_acceleration),
        )  # fmt: skip
        return np.asarray(inertia * w * a)

    def payload_sensitivity(self, link_inertia: ArrayLike, payload_inertia: ArrayLike) -> Floats:
        """(*batch) relative rise of the apparent inertia with a payload: small behind a high ratio."""
        load, inertia = together(
            payload_inertia=magnitude("payload_inertia", payload_inertia),
            link_inertia=above_zero("apparent inertia", self.apparent_inertia(link_inertia)),
        )
        return load / inertia


def matching_ratio(link_inertia: ArrayLike, motor_inertia: ArrayLike) -> Floats:
    """The ratio that accelerates the link most for a given motor torque: sqrt(I_link / I_m) (*batch).

    Args:
        link_inertia, motor_inertia: (*batch), above zero [kg m^2].
    """
    link, motor = together(
        link_inertia=above_zero("link_inertia", link_inertia), motor_inertia=above_zero("motor_inertia", motor_inertia)
    )
    return np.sqrt(link / motor)


def staged_efficiency(ratio: ArrayLike, stage_ratio: ArrayLike = 10.0, stage_efficiency: ArrayLike = 0.9) -> Floats:
    """Efficiency of a reduction in equal stages: eta_stage^ceil(log G / log G_stage) (*batch).

    A rule, no law of nature: losses grow with the number of stages.

    Args:
        ratio: G >= 1 (*batch).
        stage_ratio: most of one stage, above 1.
        stage_efficiency: of one stage.
    """
    G, stage, eta = together(
        ratio=above_zero("ratio", ratio),
        stage_ratio=above_zero("stage_ratio", stage_ratio),
        stage_efficiency=share("stage_efficiency", stage_efficiency),
    )
    above_zero("stage_ratio - 1", stage - 1.0)
    count = np.ceil(np.log(np.maximum(G, 1.0)) / np.log(stage) - ROUNDOFF)
    return eta**count


@dataclass(frozen=True, eq=False, slots=True)
class Backlash:
    """A gap between motor and link, both measured at the link.

    Attributes:
        gap: g (*batch) whole width [rad | m].
        stiffness: k (*batch) of the teeth once they touch [N m/rad | N/m].
    """

    gap: Floats
    stiffness: Floats
    __post_init__ = check_batch(gap=magnitude, stiffness=above_zero)

    @classmethod
    def of(cls, gap: ArrayLike, stiffness: ArrayLike = 1.0) -> Backlash:
        """From its numbers, each a number or (*batch).

        Raises:
            InputError: a negative gap, a stiffness that is not positive, shapes that do not go together.
        """
        return cls(*together(gap=gap, stiffness=stiffness))

    def torque(self, twist: ArrayLike) -> Floats:
        """(*batch) what passes for a twist of the motor against the link: nothing within the gap, k beyond [N m | N].

        Args:
            twist: (*batch) motor minus link [rad | m].
        """
        u = finite("twist", twist)
        return self.stiffness * np.sign(u) * np.maximum(np.abs(u) - self.gap / 2.0, 0.0)

    def link_position(self, motor: ArrayLike, start: ArrayLike | None = None) -> Floats:
        """(*batch, k) where a link with friction and without inertia stands while the motor goes its way: hysteresis.

        The link rests until a tooth touches: y_k is the place nearest to y_(k-1) within half a gap of the motor.

        Args:
            motor: (*batch, k) places of the motor in time [rad | m].
            start: (*batch) of the link before; the motor's first place if None.
        """
        u = finite("motor", motor)
        if u.ndim == 0:
            raise InputError("input.shape", name="motor", expected="(*batch, k)", got=u.shape, hint="")
        half = self.gap / 2.0
        shape = np.broadcast_shapes(u.shape[:-1], half.shape)
        y = np.empty((*shape, u.shape[-1]))
        here = np.broadcast_to(u[..., :1].sum(axis=-1) if start is None else finite("start", start), shape)
        for k in range(u.shape[-1]):
            here = np.clip(here, u[..., k] - half, u[..., k] + half)
            y[..., k] = here
        return y

    def describing_function(self, amplitude: ArrayLike) -> NDArray[np.complex128]:
        """(*batch) N(A): the first harmonic of the link over that of the motor, for a motor that swings by A.

        With z = 1 - g / A: pi Re N = pi/2 + arcsin z + z sqrt(1 - z^2), pi Im N = -(1 - z^2). Zero below A = g / 2.

        Args:
            amplitude: A (*batch) of the motor [rad | m].

        Reference: A. Gelb, W. E. Vander Velde, Multiple-input describing functions, 1968, table of hysteresis elements.
        """
        A = above_zero("amplitude", amplitude)
        z = np.clip(1.0 - self.gap / A, -1.0, 1.0)
        real = (np.pi / 2.0 + np.arcsin(z) + z * np.sqrt(1.0 - z**2)) / np.pi
        return np.asarray(real - 1j * (1.0 - z**2) / np.pi)


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
