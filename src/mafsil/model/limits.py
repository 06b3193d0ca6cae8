"""Bounds of motion and effort: of a joint, and of all coordinates as arrays."""

from __future__ import annotations

from dataclasses import dataclass
from math import copysign, inf

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.errors import InputError, ModelError
from mafsil.fields import check_fields, numbers, real

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
