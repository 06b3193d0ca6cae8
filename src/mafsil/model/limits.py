"""Bounds of a joint's motion and effort."""

from __future__ import annotations

from dataclasses import dataclass
from math import copysign, inf, isnan

from mafsil.errors import ModelError
from mafsil.fields import checked, real

UNBOUNDED = 1e16
"""A bound of this magnitude or more means none: the default of SDFormat, written where a format demands a number."""


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
