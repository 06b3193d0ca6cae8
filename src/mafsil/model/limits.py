"""Bounds of motion and effort: of a joint, and of all coordinates as arrays."""

from __future__ import annotations

from dataclasses import dataclass
from math import copysign, inf, isnan

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.errors import ModelError
from mafsil.fields import checked, real

UNBOUNDED = 1e16
"""A bound of this magnitude or more means none: the default of SDFormat, written where a format demands a number."""

MEASURED = 1e-5
"""How far a measured coordinate may lie beyond a written limit and count as on it [rad | m]: files round pi to 3.14159,
drivers send four bytes."""


def bounded(value: float) -> float:
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
    _numbers = checked(**dict.fromkeys(("lower", "upper", "velocity", "acceleration", "jerk", "effort"), real))

    def __post_init__(self) -> None:
        self._numbers()
        for name in self.__slots__:
            value = getattr(self, name)
            if isnan(value) or (value < 0 and name not in ("lower", "upper")):
                raise ModelError("model.limit", name=name, value=value)
        if self.lower > self.upper:
            raise ModelError("model.limits_swapped", lower=self.lower, upper=self.upper)


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

    def admitted(self, q: Floats) -> Floats:
        """(*batch, n) measured coordinates, those beyond a limit by at most MEASURED on it, all others as they are."""
        return admitted(q, self.lower, self.upper)

    def within(self, q: Floats) -> NDArray[np.bool_]:
        """(*batch, n) which measured coordinates count as within their limits: beyond them by at most MEASURED."""
        return np.asarray((q >= self.lower - MEASURED) & (q <= self.upper + MEASURED), dtype=np.bool_)


def admitted(q: Floats, lower: Floats, upper: Floats) -> Floats:
    """(*batch, n) measured coordinates, those beyond a bound by at most MEASURED on it, all others as they are."""
    on = np.clip(q, lower, upper)
    return np.where(np.abs(on - q) <= MEASURED, on, q)
