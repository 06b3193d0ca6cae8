"""What bounds, drives and resists motion: limits of a joint, of all coordinates as arrays, actuators and friction."""

from __future__ import annotations

from dataclasses import dataclass
from math import copysign, inf, isfinite

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.errors import InputError, ModelError
from mafsil.fields import check_fields, numbers, or_none, real

UNBOUNDED = 1e16
"""A bound of this magnitude or more means none: the default of SDFormat, written where a format demands a number."""
MEASURED = 1e-5
"""How far a measured coordinate may lie beyond a written limit and count as on it [rad | m]: files round pi to 3.14159,
drivers send four bytes."""
_BOUNDS = ("lower", "upper", "velocity", "acceleration", "jerk", "effort")


def require_bound(name: str, values: Floats) -> None:
    """Numbers that can be bounds of the kind that the name says.

    Raises:
        ModelError: a NaN, or a negative magnitude.
    """
    wrong = np.isnan(values) | ((values < 0.0) & (name not in ("lower", "upper")))
    if wrong.any():
        raise ModelError("model.limit", name=name, value=float(values[wrong].flat[0]))


def require_order(lower: Floats, upper: Floats) -> None:
    """Lower bounds that lie below upper ones, or on them.

    Raises:
        ModelError: one does not.
    """
    wrong = lower > upper
    if wrong.any():
        low, high = float(lower[wrong].flat[0]), float(upper[wrong].flat[0])
        raise ModelError("model.limits_swapped", lower=low, upper=high)


def bound_value(value: float) -> float:
    """The bound that a number of a file means: infinite from UNBOUNDED on."""
    return copysign(inf, value) if abs(value) >= UNBOUNDED else value


@dataclass(frozen=True, slots=True)
class Limits:
    """Bounds of one joint; what is not known is infinite.

    Attributes:
        lower, upper: position [rad | m].
        velocity, acceleration, jerk: magnitudes [rad/s | m/s] and time derivatives.
        effort: magnitude [N m | N].

    Raises:
        ModelError: a bound is NaN, a magnitude is negative, or the lower bound lies above the upper one.
    """

    lower: float = -inf
    upper: float = inf
    velocity: float = inf
    acceleration: float = inf
    jerk: float = inf
    effort: float = inf
    _numbers = check_fields(**dict.fromkeys(_BOUNDS, real))

    def __post_init__(self) -> None:
        self._numbers()
        for name in _BOUNDS:
            require_bound(name, np.asarray(getattr(self, name)))
        require_order(np.asarray(self.lower), np.asarray(self.upper))


@dataclass(frozen=True, slots=True)
class JointLimits:
    """Bounds of all coordinates as arrays of shape (n,); unknown bounds are infinite.

    Attributes:
        lower, upper: [rad | m].
        velocity, acceleration, jerk, effort: magnitudes.
    """

    lower: Floats
    upper: Floats
    velocity: Floats
    acceleration: Floats
    jerk: Floats
    effort: Floats
    _numbers = check_fields(**dict.fromkeys(_BOUNDS, numbers(1, unbounded=True)))

    def __post_init__(self) -> None:
        self._numbers()
        for name in _BOUNDS:
            require_bound(name, getattr(self, name))
            if getattr(self, name).shape != self.lower.shape:
                got = getattr(self, name).shape
                raise InputError("input.shape", name=name, expected=self.lower.shape, got=got, hint="")
        require_order(self.lower, self.upper)

    def snap_to_limits(self, q: Floats) -> Floats:
        """(*batch, n) measured coordinates, those beyond a limit by at most MEASURED on it, all others as they are."""
        return snap_to_bounds(q, self.lower, self.upper)

    def within(self, q: Floats) -> NDArray[np.bool_]:
        """(*batch, n) which measured coordinates count as within their limits: beyond them by at most MEASURED."""
        return np.asarray((q >= self.lower - MEASURED) & (q <= self.upper + MEASURED), dtype=np.bool_)


def snap_to_bounds(q: Floats, lower: Floats, upper: Floats) -> Floats:
    """(*batch, n) measured coordinates, those beyond a bound by at most MEASURED on it, all others as they are."""
    on = np.minimum(np.maximum(q, lower), upper)
    return np.where(np.abs(on - q) <= MEASURED, on, q)


@dataclass(frozen=True, slots=True)
class Actuator:
    """Motor and gear of one joint.

    Attributes:
        rotor_inertia: inertia of the rotor about its own axis, on the motor side [kg m^2].
        gear_ratio: motor turns per joint turn (or motor radians per metre).
        armature: inertia seen at the joint in addition to the rotor's, as MuJoCo's `armature` [kg m^2 | kg].
    """

    rotor_inertia: float = 0.0
    gear_ratio: float = 1.0
    armature: float = 0.0
    _numbers = check_fields(rotor_inertia=real, gear_ratio=real, armature=real)

    def __post_init__(self) -> None:
        self._numbers()
        _require_magnitudes(rotor_inertia=self.rotor_inertia, armature=self.armature)
        if not isfinite(self.gear_ratio):
            raise ModelError("model.finite", name="gear_ratio", value=self.gear_ratio)

    @property
    def reflected_inertia(self) -> float:
        """Inertia seen at the joint: gear_ratio^2 rotor_inertia + armature [kg m^2 | kg]."""
        return self.gear_ratio**2 * self.rotor_inertia + self.armature

    @property
    def equivalent_rotor(self) -> tuple[float, float]:
        """Gear ratio, and inertia of a rotor behind it that is felt at the joint as rotor and armature together."""
        if self.armature == 0.0 or self.gear_ratio == 0.0:
            return (self.gear_ratio, self.rotor_inertia) if self.gear_ratio else (1.0, self.armature)
        return self.gear_ratio, self.reflected_inertia / self.gear_ratio**2


@dataclass(frozen=True, slots=True)
class Friction:
    """Friction of one joint, on the joint side.

    Attributes:
        viscous: effort per speed [N m s/rad | N s/m].
        coulomb: effort against the motion, positive sense [N m | N].
        coulomb_negative: the same in the negative sense (a magnitude); equal to `coulomb` if None.
        offset: constant effort of either sign, such as a sensor's or a balance spring's [N m | N].
    """

    viscous: float = 0.0
    coulomb: float = 0.0
    coulomb_negative: float | None = None
    offset: float = 0.0
    _numbers = check_fields(viscous=real, coulomb=real, coulomb_negative=or_none(real), offset=real)

    def __post_init__(self) -> None:
        self._numbers()
        negative = self.coulomb if self.coulomb_negative is None else self.coulomb_negative
        _require_magnitudes(viscous=self.viscous, coulomb=self.coulomb, coulomb_negative=negative)
        if not isfinite(self.offset):
            raise ModelError("model.finite", name="offset", value=self.offset)

    @property
    def is_uneven(self) -> bool:
        """Whether it differs for both senses of motion, or has an offset."""
        return self.coulomb_negative not in (None, self.coulomb) or bool(self.offset)

    @property
    def mean_coulomb(self) -> float:
        """Mean of the Coulomb efforts of both senses [N m | N]."""
        return self.coulomb if self.coulomb_negative is None else (self.coulomb + self.coulomb_negative) / 2


def _require_magnitudes(**values: float) -> None:
    for name, value in values.items():
        if not (isfinite(value) and value >= 0):
            raise ModelError("model.magnitude", name=name, value=value)
