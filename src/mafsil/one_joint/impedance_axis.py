"""Impedance along one axis: Z and Y, a mass that meets a wall, and what a sampled robot can render at all."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Status
from mafsil.arrays import Floats, whole
from mafsil.errors import InputError
from mafsil.one_joint.arguments import above_zero, finite, magnitude, row, together
from mafsil.one_joint.joint_arm import JointArm
from mafsil.one_joint.joint_law import JointLaw
from mafsil.one_joint.polynomial import Complexes
from mafsil.one_joint.row_answer import RowAnswer
from mafsil.one_joint.sampled_stability import SampledStability, sampled_stability
from mafsil.one_joint.second_order import SecondOrder

HALVINGS = 60
"""In the searches for instants and for the stiffest wall."""

SAMPLES = 4097
"""Of a motion in which a crossing is looked for, denser at the start, where it is fast."""


@dataclass(frozen=True, eq=False, slots=True)
class Impedance:
    """D x'' + B x' + K x = F: Z(s) = D s^2 + B s + K = F / X, Y = 1 / Z.

    Attributes:
        mass, damping, stiffness: D, B, K (*batch) [kg, N s/m, N/m].
    """

    mass: Floats
    damping: Floats
    stiffness: Floats

    @classmethod
    def of(cls, mass: ArrayLike, damping: ArrayLike, stiffness: ArrayLike) -> Impedance:
        """From its numbers, each a number or (*batch).

        Raises:
            InputError: a negative number, shapes that do not go together.
        """
        return cls(
            *together(
                mass=magnitude("mass", mass),
                damping=magnitude("damping", damping),
                stiffness=magnitude("stiffness", stiffness),
            )
        )

    def at(self, frequency: ArrayLike) -> Complexes:
        """Z(jw) (*batch, k) [N/m]: near K at low, near -D w^2 at high frequency."""
        s = np.asarray(1j * row("frequency", frequency), dtype=np.complex128)
        return self.mass[..., None] * s * s + self.damping[..., None] * s + self.stiffness[..., None]

    def admittance(self, frequency: ArrayLike) -> Complexes:
        """Y(jw) = 1 / Z (*batch, k) [m/N]."""
        return 1.0 / self.at(frequency)

    @property
    def motion(self) -> SecondOrder:
        """Free motion: natural frequency and damping ratio; mass and stiffness above zero."""
        return SecondOrder.of_joint(self.mass, self.damping, self.stiffness)

    def acceleration(self, force: ArrayLike, displacement: ArrayLike, speed: ArrayLike) -> Floats:
        """Acceleration (*batch) that an admittance controller commands: (F - B v - K x) / D [m/s^2]."""
        F, x, v = finite("force", force), finite("displacement", displacement), finite("speed", speed)
        return (F - self.damping * v - self.stiffness * x) / above_zero("mass", self.mass)


class WallStatus(Status):
    """What happens at the first contact."""

    LOST = ("one_joint.wall_lost", True)
    KEPT = ("one_joint.wall_kept", True)
    NOT_REACHED = ("one_joint.wall_not_reached", False)


@dataclass(frozen=True, eq=False, repr=False)
class WallContact(RowAnswer):
    """First contact of an impedance with a wall; true if there is one.

    Attributes:
        verdict: (*batch) which of `statuses`.
        contact_time, contact_speed: (*batch) [s], [m/s]; NaN if not reached.
        peak_force, time_of_peak: (*batch) largest force and when after contact [N], [s].
        release: (*batch) how long after contact it is lost [s]; NaN if it is kept.
        rest_position, rest_force: (*batch) in the end [m], [N].
    """

    statuses: ClassVar[tuple[Status, ...]] = tuple(WallStatus)
    verdict: NDArray[np.int8]
    contact_time: Floats
    contact_speed: Floats
    peak_force: Floats
    time_of_peak: Floats
    release: Floats
    rest_position: Floats
    rest_force: Floats


def meet_wall(
    impedance: Impedance, reference: ArrayLike, wall_stiffness: ArrayLike, start: ArrayLike, speed: ArrayLike = 0.0
) -> WallContact:
    """An impedance drawn to a reference behind a wall at x = 0: first contact in closed form.

    D x'' + B x' + K (x - x_ref) = F, F = -k x for x > 0, none else.

    Args:
        impedance: D, B, K, all above zero.
        reference: x_ref (*batch) [m].
        wall_stiffness: k (*batch) [N/m].
        start: x < 0 at t = 0 (*batch) [m].
        speed: x' there (*batch) [m/s].

    Raises:
        InputError: a start that is not before the wall, a number out of its range.
    """
    D, B, K, ref, k, x, v = together(
        mass=above_zero("mass", impedance.mass), damping=above_zero("damping", impedance.damping),
        stiffness=above_zero("stiffness", impedance.stiffness), reference=finite("reference", reference),
        wall_stiffness=above_zero("wall_stiffness", wall_stiffness), start=finite("start", start),
        speed=finite("speed", speed),
    )  # fmt: skip
    if (x >= 0.0).any():
        raise InputError("input.range", name="start", value=float(x.max()), low=-np.inf, high=0.0)
    # 1. Free motion about x_ref, until x = 0: the error x - x_ref rises through -x_ref.
    free = SecondOrder.of_joint(D, B, K)
    when = _first_crossing(free, x - ref, v, -ref, 1.0)
    reached = np.isfinite(when)
    v_contact = free.state_at(np.where(reached, when, 0.0), x - ref, v)[1]
    # 2. Contact about the rest position K x_ref / (K + k).
    pressed = SecondOrder.of_joint(D, B, K + k)
    rest = K * ref / (K + k)
    turn = pressed.first_extremum(-rest, v_contact)
    peak_time = np.where(np.isfinite(turn), turn, 0.0)
    peak = pressed.state_at(peak_time, -rest, v_contact)[0] + rest
    release = _first_crossing(pressed, -rest, v_contact, -rest, -1.0)
    lost = np.isfinite(release)
    verdict = np.where(~reached, 2, np.where(lost, 0, 1)).astype(np.int8)
    nothing = np.nan
    end = np.where(ref > 0.0, rest, ref)
    return WallContact(
        verdict,
        np.where(reached, when, nothing),
        np.where(reached, v_contact, nothing),
        np.where(reached, k * np.where(np.isfinite(turn), peak, rest), nothing),
        np.where(reached, turn, nothing),
        np.where(reached & lost, release, nothing),
        end,
        k * np.maximum(end, 0.0),
    )


def _first_crossing(loop: SecondOrder, e0: Floats, v0: Floats, level: Floats, sense: float) -> Floats:
    """First time at which the error passes a level upwards (sense 1) or downwards (-1); infinite if never."""
    horizon = loop.settling_time(np.where(e0 == 0.0, 1.0, e0), v0, 1e-6)
    t = horizon[..., None] * np.linspace(0.0, 1.0, SAMPLES) ** 2
    rows = SecondOrder(loop.natural_frequency[..., None], loop.damping_ratio[..., None])
    value = sense * (rows.state_at(t, e0[..., None], v0[..., None])[0] - level[..., None])
    rising = (value[..., :-1] < 0.0) & (value[..., 1:] >= 0.0)
    # The start itself stands on the level where contact has just been made: only what comes after counts.
    at = np.argmax(rising, axis=-1)[..., None]
    low, high = (np.take_along_axis(t, at + k, axis=-1)[..., 0] for k in (0, 1))
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        before = sense * (loop.state_at(middle, e0, v0)[0] - level) < 0.0
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    return np.where(rising.any(axis=-1), high, np.inf)


@dataclass(frozen=True, eq=False, slots=True)
class AdmittanceStep:
    """One step of an admittance controller, V' = D^-1 (F - B V - K X), then V and X over a period.

    Attributes:
        impedance: what is to be rendered.
        period: (*batch) [s].
    """

    impedance: Impedance
    period: Floats

    @classmethod
    def of(cls, impedance: Impedance, period: ArrayLike) -> AdmittanceStep:
        """From what is to be rendered, its mass above zero, and the period (*batch) [s]."""
        above_zero("mass", impedance.mass)
        return cls(impedance, above_zero("period", period))

    def semi_implicit(self) -> SampledStability:
        """V += T V'(X, V), then X += T V with the new V: stable exactly if D > B T / 2 + K T^2 / 4."""
        return SampledStability.of_matrix(self._matrix(implicit=True))

    def explicit(self) -> SampledStability:
        """X += T V with the old V, as the book prints it: needs besides B > K T."""
        return SampledStability.of_matrix(self._matrix(implicit=False))

    @property
    def smallest_mass(self) -> Floats:
        """(*batch) B T / 2 + K T^2 / 4 [kg]: the least virtual mass of the semi-implicit step."""
        T = self.period
        return self.impedance.damping * T / 2.0 + self.impedance.stiffness * T * T / 4.0

    def through_tracking(self, kp: ArrayLike, kd: ArrayLike) -> Impedance:
        """What is rendered when the step starts from the measured state and goes through a computed-torque law.

        V'= V_d' + Kp (X_d - X) + Kd (V_d - V) with X_d = X + T V, V_d = V + T V_d': D_eff = D / (1 + Kd T), B_eff = B -
        D Kp T / (1 + Kd T), which can be negative; K stays.

        Args:
            kp, kd: gains of the law (*batch) [1/s^2, 1/s].

        Returns:
            The impedance, whose damping may be negative: then the free robot is unstable.
        """
        T, share_ = self.period, 1.0 + magnitude("kd", kd) * self.period
        one = self.impedance
        D, B, K = np.broadcast_arrays(
            one.mass / share_, one.damping - one.mass * magnitude("kp", kp) * T / share_, one.stiffness
        )
        return Impedance(D, B, K)

    def tracked_acceleration(
        self, kp: ArrayLike, kd: ArrayLike, force: ArrayLike, displacement: ArrayLike, speed: ArrayLike
    ) -> Floats:
        """(*batch) acceleration that such a law commands: V_d' (1 + Kd T) + Kp T V [m/s^2]."""
        wanted = self.impedance.acceleration(force, displacement, speed)
        T = self.period
        return wanted * (1.0 + magnitude("kd", kd) * T) + magnitude("kp", kp) * T * finite("speed", speed)

    def _matrix(self, implicit: bool) -> Floats:
        D, B, K, T = np.broadcast_arrays(
            self.impedance.mass, self.impedance.damping, self.impedance.stiffness, self.period
        )
        A = np.empty((*D.shape, 2, 2))
        A[..., 1, 0], A[..., 1, 1] = -T * K / D, 1.0 - T * B / D
        A[..., 0, 0] = 1.0 + (T * A[..., 1, 0] if implicit else 0.0)
        A[..., 0, 1] = T * (A[..., 1, 1] if implicit else 1.0)
        return A


def passive_wall_stiffness(friction: ArrayLike, period: ArrayLike, wall_damping: ArrayLike = 0.0) -> Floats:
    """Stiffest virtual wall that is passive whatever touches it: K <= 2 (b - |B|) / T (*batch) [N/m].

    Args:
        friction: b (*batch) of the device itself [N s/m].
        period: T (*batch) [s].
        wall_damping: B (*batch) of the wall [N s/m].

    Returns:
        At least 0.

    Reference: Colgate and Schenkel, Passivity of a class of sampled-data systems, 1997.
    """
    b, T, B = together(
        friction=magnitude("friction", friction), period=above_zero("period", period),
        wall_damping=finite("wall_damping", wall_damping),
    )  # fmt: skip
    return np.maximum(2.0 * (b - np.abs(B)) / T, 0.0)


def stiffest_stable_wall(
    mass: ArrayLike, friction: ArrayLike, period: ArrayLike, wall_damping: ArrayLike = 0.0, delay: int = 0
) -> Floats:
    """Stiffest virtual wall against which a free device is stable by itself (*batch) [N/m].

    The wall is a sampled spring and differenced damper; by halving on the spectral radius of the exact step, to
    rounding. A hand that holds the device may still make it unstable: for that ask `passive_wall_stiffness`.

    Args:
        mass: of the device (*batch) [kg].
        friction: b (*batch) of the device [N s/m].
        period: T (*batch) [s].
        wall_damping: B (*batch) [N s/m].
        delay: whole periods.

    Returns:
        0 where no wall is stable.
    """
    m, b, T, B = together(
        mass=above_zero("mass", mass), friction=magnitude("friction", friction), period=above_zero("period", period),
        wall_damping=magnitude("wall_damping", wall_damping),
    )  # fmt: skip
    late, device = whole("delay", delay), JointArm.of(m, friction=b)
    low, high = np.zeros_like(m), 16.0 * m / (T * T) + 16.0 * (b + B) / T
    for _ in range(HALVINGS + 20):
        middle = 0.5 * (low + high)
        fine = sampled_stability(device, JointLaw.pid(middle, 0.0, B), T, late).verdict == 0
        low, high = np.where(fine, middle, low), np.where(fine, high, middle)
    return low
