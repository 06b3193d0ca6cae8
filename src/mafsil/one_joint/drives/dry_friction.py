"""Friction of a joint by its speed, set-valued at rest: six laws of one formula, holding, dither, stick-slip.

What friction depends on beside speed: load, time at rest, temperature, and the way gone since it stuck.

Reference: Armstrong-Helouvry, Dupont and Canudas de Wit, A survey of models, analysis tools and compensation methods
for the control of machines with friction, Automatica 30(7), 1994; Dahl, A solid friction model, 1968.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Status
from mafsil.arrays import Floats, require_kind
from mafsil.errors import InputError
from mafsil.one_joint.rows import (
    RowAnswer,
    above_zero,
    above_zero_or_unbounded,
    check_batch,
    finite,
    magnitude,
    together,
)


@dataclass(frozen=True, eq=False, slots=True)
class SpeedFriction:
    """(b_k + (b_s - b_k) exp(-|w / w_s|^delta)) sgn(w) + b_v w in motion; anything in [-b_s, b_s] at rest.

    Attributes:
        static: b_s (*batch), the most that it holds at rest [N m | N].
        kinetic: b_k (*batch), against motion; at most b_s [N m | N].
        viscous: b_v (*batch) [N m s/rad | N s/m].
        stribeck_speed: w_s (*batch) [rad/s | m/s]; 0 lets friction fall from b_s to b_k at once.
        exponent: delta (*batch).
    """

    static: Floats
    kinetic: Floats
    viscous: Floats
    stribeck_speed: Floats
    exponent: Floats
    _numbers = check_batch(
        static=magnitude, kinetic=magnitude, viscous=magnitude, stribeck_speed=magnitude, exponent=above_zero
    )

    def __post_init__(self) -> None:
        self._numbers()
        if (self.kinetic > self.static).any():
            raise InputError("one_joint.kinetic_above_static")

    @classmethod
    def of(
        cls,
        static: ArrayLike = 0.0,
        kinetic: ArrayLike | None = None,
        viscous: ArrayLike = 0.0,
        stribeck_speed: ArrayLike = 0.0,
        exponent: ArrayLike = 2.0,
    ) -> SpeedFriction:
        """The general law; `kinetic` is `static` if None.

        Raises:
            InputError: a negative number, kinetic above static friction, shapes that do not go together.
        """
        slides = static if kinetic is None else kinetic
        return cls(
            *together(static=static, kinetic=slides, viscous=viscous, stribeck_speed=stribeck_speed, exponent=exponent)
        )

    @classmethod
    def viscous_only(cls, viscous: ArrayLike) -> SpeedFriction:
        """b_v w."""
        return cls.of(viscous=viscous)

    @classmethod
    def coulomb(cls, kinetic: ArrayLike) -> SpeedFriction:
        """B sgn(w), in [-b, b] at rest."""
        return cls.of(kinetic)

    @classmethod
    def static_viscous(cls, static: ArrayLike, viscous: ArrayLike) -> SpeedFriction:
        """b_s sgn(w) + b_v w."""
        return cls.of(static, None, viscous)

    @classmethod
    def static_kinetic(cls, static: ArrayLike, kinetic: ArrayLike) -> SpeedFriction:
        """Holds up to b_s, resists by b_k."""
        return cls.of(static, kinetic)

    @classmethod
    def static_kinetic_viscous(cls, static: ArrayLike, kinetic: ArrayLike, viscous: ArrayLike) -> SpeedFriction:
        """Holds up to b_s, resists by b_k sgn(w) + b_v w."""
        return cls.of(static, kinetic, viscous)

    @classmethod
    def stribeck(
        cls, static: ArrayLike, kinetic: ArrayLike, viscous: ArrayLike, speed: ArrayLike, exponent: ArrayLike = 2.0
    ) -> SpeedFriction:
        """Falls smoothly from b_s to b_k over speeds about w_s."""
        return cls.of(static, kinetic, viscous, above_zero("speed", speed), exponent)

    @property
    def dry(self) -> bool:
        """Whether any of it holds at rest."""
        return bool((self.static > 0.0).any())

    def torque(self, speed: ArrayLike, applied: ArrayLike = 0.0) -> Floats:
        """Torque (*batch) that friction takes; the joint feels minus that [N m | N].

        Args:
            speed: w (*batch) [rad/s | m/s].
            applied: all other torques (*batch) [N m | N]: at rest friction balances them, as far as it can.
        """
        w, push, low, high = together(
            speed=finite("speed", speed), applied=finite("applied", applied), low=-self.static, high=self.static
        )
        return np.where(w == 0.0, np.clip(push, low, high), self._moving(w))

    def interval(self, speed: ArrayLike) -> tuple[Floats, Floats]:
        """Least and greatest torque (*batch) that friction can take at a speed: equal in motion."""
        w, static = together(speed=finite("speed", speed), static=self.static)
        value = self._moving(w)
        return np.where(w == 0.0, -static, value), np.where(w == 0.0, static, value)

    def holds(self, applied: ArrayLike) -> Holding:
        """Whether a joint at rest stays at rest under an applied torque (*batch) [N m | N]."""
        push, static = together(applied=finite("applied", applied), static=self.static)
        margin = static - np.abs(push)
        return Holding(np.where(margin >= 0.0, 0, 1).astype(np.int8), push, static, margin)

    def _moving(self, w: Floats) -> Floats:
        ws = np.where(self.stribeck_speed > 0.0, self.stribeck_speed, 1.0)
        fallen = np.where(self.stribeck_speed > 0.0, np.exp(-(np.abs(w / ws) ** self.exponent)), 0.0)
        return (self.kinetic + (self.static - self.kinetic) * fallen) * np.sign(w) + self.viscous * w


class HoldingStatus(Status):
    """Whether stiction holds."""

    HOLDS = ("one_joint.holds", True)
    MOVES = ("one_joint.moves", False)


@dataclass(frozen=True, eq=False, repr=False)
class Holding(RowAnswer):
    """Whether friction holds a joint at rest; true if it does, in every row.

    Attributes:
        verdict: (*batch) which of `statuses`.
        applied: (*batch) torque on the joint [N m | N].
        static: (*batch) what friction can hold.
        margin: (*batch) how much more would be held; negative: what accelerates the joint, and more once it moves.
    """

    statuses: ClassVar[tuple[Status, ...]] = tuple(HoldingStatus)
    verdict: NDArray[np.int8]
    applied: Floats
    static: Floats
    margin: Floats


def dithered_friction(kinetic: ArrayLike, speed: ArrayLike, amplitude: ArrayLike) -> Floats:
    """Mean of Coulomb friction when a fast oscillation of the speed is added: it becomes smooth.

    Args:
        kinetic: b (*batch) [N m | N].
        speed: mean speed w (*batch) [rad/s | m/s].
        amplitude: A of the added speed A sin (*batch) [rad/s | m/s].

    Returns:
        (*batch) b (2 / pi) asin(w / A) for |w| < A, b sgn(w) beyond.
    """
    b, w, A = together(
        kinetic=magnitude("kinetic", kinetic),
        speed=finite("speed", speed),
        amplitude=above_zero("amplitude", amplitude),
    )
    return b * (2.0 / np.pi) * np.arcsin(np.clip(w / A, -1.0, 1.0))


class StickSlipStatus(Status):
    """How a joint creeps after a slow reference."""

    STICK_SLIP = ("one_joint.stick_slip", True)
    SMOOTH = ("one_joint.no_stick_slip", False)


@dataclass(frozen=True, eq=False, repr=False)
class StickSlip(RowAnswer):
    """The cycle of sticking and slipping; true if there is one.

    Attributes:
        verdict: (*batch) which of `statuses`.
        first_motion: (*batch) time from zero error to the first motion [s].
        error_at_breakaway, error_at_restick: (*batch) [rad | m].
        slip_time, stick_time, period: (*batch) [s].
        slip_distance: (*batch) [rad | m].
        peak_speed: (*batch) [rad/s | m/s].
    """

    statuses: ClassVar[tuple[Status, ...]] = tuple(StickSlipStatus)
    verdict: NDArray[np.int8]
    first_motion: Floats
    error_at_breakaway: Floats
    error_at_restick: Floats
    slip_time: Floats
    stick_time: Floats
    period: Floats
    slip_distance: Floats
    peak_speed: Floats


def stick_slip(inertia: ArrayLike, kp: ArrayLike, static: ArrayLike, kinetic: ArrayLike, speed: ArrayLike) -> StickSlip:
    """Proportional control after a slow ramp, static above kinetic friction, nothing else that damps.

    While it slips, x = e - b_k / Kp obeys M x'' + Kp x = 0 from x = (b_s - b_k) / Kp, x' = V; it stops when x' = V
    again, at -x.

    Args:
        inertia: M (*batch) [kg m^2 | kg].
        kp: (*batch) [N m/rad | N/m].
        static, kinetic: b_s >= b_k (*batch) [N m | N].
        speed: V > 0 of the reference (*batch) [rad/s | m/s].

    Returns:
        The cycle in closed form; false where static friction is not above kinetic friction.

    Raises:
        InputError: a number out of its range, kinetic above static friction, shapes that do not go together.
    """
    M, k, bs, bk, V = together(
        inertia=above_zero("inertia", inertia),
        kp=above_zero("kp", kp),
        static=magnitude("static", static),
        kinetic=magnitude("kinetic", kinetic),
        speed=above_zero("speed", speed),
    )
    if (bk > bs).any():
        raise InputError("one_joint.kinetic_above_static")
    w, x = np.sqrt(k / M), (bs - bk) / k
    slips = bs > bk
    slip = np.where(slips, 2.0 * (np.pi - np.arctan(x * w / V)) / w, np.nan)
    stick = np.where(slips, 2.0 * x / V, np.nan)
    peak = np.where(slips, V + np.hypot(V, x * w), np.nan)
    return StickSlip(
        np.where(slips, 0, 1).astype(np.int8),
        bs / (k * V),
        bs / k,
        np.where(slips, bk / k - x, np.nan),
        slip,
        stick,
        slip + stick,
        V * slip + 2.0 * x,
        peak,
    )


@dataclass(frozen=True, eq=False, slots=True)
class FrictionConditions:
    """How the numbers of a friction law move with load, rest and temperature.

    Dry friction: b + load_share |load|, kinetic and static alike. Static: it grows at rest from b_k to b_s as
    T / (T + rest_time). Viscous: b_v exp(-thinning (temperature - reference)), as a lubricant that gets thinner.
    Pre-sliding: a spring of the stiffness given, until the bristles slide.

    Attributes:
        friction: at no load, after a long rest, at the reference temperature.
        load_share: (*batch) dry friction per effort that the gear passes [1].
        rest_time: (*batch) after which half of the difference of static and kinetic is there; 0 is at once [s].
        thinning: (*batch) [1/K].
        reference: (*batch) temperature [degrees Celsius].
        stiffness: (*batch) of pre-sliding; infinite if there is none [N m/rad | N/m].
    """

    friction: SpeedFriction
    load_share: Floats
    rest_time: Floats
    thinning: Floats
    reference: Floats
    stiffness: Floats
    __post_init__ = check_batch(
        load_share=magnitude,
        rest_time=magnitude,
        thinning=magnitude,
        reference=finite,
        stiffness=above_zero_or_unbounded,
    )

    @classmethod
    def of(
        cls, friction: SpeedFriction, *, load_share: ArrayLike = 0.0, rest_time: ArrayLike = 0.0,
        thinning: ArrayLike = 0.0, reference: ArrayLike = 20.0, stiffness: ArrayLike = np.inf,
    ) -> FrictionConditions:  # fmt: skip
        """From its numbers, each a number or (*batch).

        Raises:
            InputError: a negative number, a stiffness of zero, shapes that do not go together.
        """
        require_kind("friction", friction, "SpeedFriction", "torque", "interval")
        parts = together(
            load_share=load_share, rest_time=rest_time, thinning=thinning, reference=reference, stiffness=stiffness
        )
        return cls(friction, *parts)

    def at(self, load: ArrayLike = 0.0, rest: ArrayLike = 1e6, temperature: ArrayLike | None = None) -> SpeedFriction:
        """The friction law (*batch) under these conditions, for a run or the test of holding.

        Args:
            load: effort that the gear passes (*batch) [N m | N].
            rest: time since the last motion (*batch) [s].
            temperature: (*batch), that of the reference if None [degrees Celsius].

        Raises:
            InputError: not finite, a negative time, shapes that do not go together.
        """
        law, warm = self.friction, self.reference if temperature is None else finite("temperature", temperature)
        waited = magnitude("rest", rest)
        added = self.load_share * np.abs(finite("load", load))
        grown = np.divide(waited, waited + self.rest_time, out=np.ones_like(waited + self.rest_time),
                          where=waited + self.rest_time > 0.0)  # fmt: skip
        kinetic = law.kinetic + added
        static = kinetic + (law.static - law.kinetic) * grown
        viscous = law.viscous * np.exp(-self.thinning * (warm - self.reference))
        return SpeedFriction.of(static, kinetic, viscous, law.stribeck_speed, law.exponent)

    def presliding(self, way: ArrayLike, load: ArrayLike = 0.0) -> Floats:
        """Torque (*batch) after a way from where nothing was strained: b (1 - exp(-k |x| / b)) sgn(x), b kinetic.

        Dahl's law: its slope at the start is the stiffness, and it ends at kinetic friction.

        Args:
            way: x (*batch) gone in one sense [rad | m].
            load: effort that the gear passes (*batch) [N m | N].
        """
        x = finite("way", way)
        b = above_zero("kinetic friction", self.friction.kinetic + self.load_share * np.abs(finite("load", load)))
        with np.errstate(invalid="ignore"):
            strained = np.where(x == 0.0, 0.0, self.stiffness * np.abs(x) / b)
        return b * -np.expm1(-strained) * np.sign(x)

    def breakaway(self, load: ArrayLike = 0.0) -> Floats:
        """(*batch) way after which 98 % of the kinetic friction is there: 4 b / k [rad | m]."""
        return 4.0 * (self.friction.kinetic + self.load_share * np.abs(finite("load", load))) / self.stiffness
