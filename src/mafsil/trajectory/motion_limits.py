"""What a motion must keep: bounds of position, velocity, acceleration, jerk and effort, each side of its own."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, frozen, require_kind
from mafsil.errors import InputError
from mafsil.fields import numbers
from mafsil.model import JointLimits
from mafsil.robot import Robot

Bound: TypeAlias = ArrayLike | tuple[ArrayLike, ArrayLike]
"""A magnitude for both directions, a number or (n,); or a pair (lower, upper) of such."""

UNBOUNDED = np.inf

_BOUNDS, _SIDE = numbers(2, unbounded=True), numbers(unbounded=True)


@dataclass(frozen=True, eq=False, slots=True)
class MotionLimits:
    """Bounds of n coordinates; what is not bounded is infinite.

    Attributes:
        position: (2, n) lower and upper bounds [rad | m].
        velocity, acceleration, jerk: (2, n) lower bounds, not positive, and upper ones, not negative, in SI units.
        effort: (2, n) of torques and forces [N m | N].
    """

    position: Floats
    velocity: Floats
    acceleration: Floats
    jerk: Floats
    effort: Floats

    def __post_init__(self) -> None:
        for name in self.__slots__:
            bounds = _two_rows(name, getattr(self, name))
            object.__setattr__(self, name, bounds)
            if bounds.shape != self.position.shape:
                raise InputError("input.shape", name=name, expected=self.position.shape, got=bounds.shape, hint="")

    @property
    def n(self) -> int:
        """Number of coordinates."""
        return self.position.shape[1]

    @classmethod
    def of(
        cls,
        n: int,
        *,
        position: Bound = UNBOUNDED,
        velocity: Bound = UNBOUNDED,
        acceleration: Bound = UNBOUNDED,
        jerk: Bound = UNBOUNDED,
        effort: Bound = UNBOUNDED,
    ) -> MotionLimits:
        """Bounds from magnitudes or from pairs (lower, upper).

        Args:
            n: number of coordinates.
            position, velocity, acceleration, jerk, effort: a magnitude that holds in both directions, a number or (n,);
                or a tuple (lower, upper) of such, or an array (2, n) of both. Other lists and arrays are magnitudes.

        Raises:
            InputError: a shape that does not fit n, a NaN, a lower bound above the upper one, or bounds of a derivative
                that do not allow rest.
        """
        given = {"velocity": velocity, "acceleration": acceleration, "jerk": jerk, "effort": effort}
        return cls(_bounds("position", position, n), **{name: _bounds(name, bound, n) for name, bound in given.items()})

    @property
    def unbounded(self) -> tuple[str, ...]:
        """Of position, velocity, acceleration and jerk those that no coordinate has a bound of."""
        names = ("position", "velocity", "acceleration", "jerk")
        return tuple(name for name in names if not np.isfinite(getattr(self, name)).any())

    @classmethod
    def of_joints(cls, limits: JointLimits) -> MotionLimits:
        """The limits of a robot's joints."""
        return cls.of(
            len(limits.lower),
            position=(limits.lower, limits.upper),
            velocity=limits.velocity,
            acceleration=limits.acceleration,
            jerk=limits.jerk,
            effort=limits.effort,
        )


Limits: TypeAlias = MotionLimits | JointLimits | Robot
"""Wherever limits are expected: bounds of their own, or those of a robot's joints."""


def motion_limits(limits: Limits, n: int) -> MotionLimits:
    """The bounds of n coordinates.

    Raises:
        InputError: they are of another number of coordinates, or no limits.
    """
    joints = limits.limits if isinstance(limits, Robot) else limits
    require_kind("limits", joints, "MotionLimits, JointLimits or Robot", "velocity", "acceleration")
    bounds = joints if isinstance(joints, MotionLimits) else MotionLimits.of_joints(joints)
    if bounds.n != n:
        raise InputError("input.shape", name="limits", expected=(n,), got=(bounds.n,), hint="")
    return bounds


def share_of(value: Floats, bound: Floats) -> Floats:
    """(k, n) of the bound in the direction of each value; zero where that bound is zero.

    Args:
        value: (k, n).
        bound: (2, n) lower and upper ones.
    """
    size: Floats = np.where(value >= 0.0, bound[1:2], -bound[0:1]).astype(np.float64)
    return np.divide(np.abs(value), size, out=np.zeros_like(value), where=size > 0.0)


def _bounds(name: str, bound: Bound, n: int) -> Floats:
    """(2, n) lower and upper bounds."""
    if (isinstance(bound, tuple) and len(bound) == 2) or getattr(bound, "shape", None) == (2, n):
        pair = cast("tuple[ArrayLike, ArrayLike]", bound)
        lower, upper = (_row(f"{name}[{k}]", side, n) for k, side in enumerate(pair))
    else:
        upper = _row(name, cast("ArrayLike", bound), n)
        lower = -upper
    return np.stack([lower, upper])


def _two_rows(name: str, bounds: ArrayLike) -> Floats:
    """(2, n) lower bounds and upper ones above them; of derivatives, zero lies between."""
    array = _BOUNDS(name, bounds)
    if len(array) != 2:
        raise InputError("input.shape", name=name, expected="(2, n)", got=array.shape, hint="")
    lower, upper = array
    wrong = lower > upper
    if name != "position":
        wrong |= (lower > 0.0) | (upper < 0.0)
    if wrong.any():
        k = int(wrong.argmax())
        raise InputError("trajectory.bounds", name=name, index=k, lower=float(lower[k]), upper=float(upper[k]))
    return frozen(array)


def _row(name: str, side: ArrayLike, n: int) -> Floats:
    values = _SIDE(name, side)
    if values.shape not in ((), (n,)):
        raise InputError("input.shape", name=name, expected=(n,), got=values.shape, hint="")
    return np.broadcast_to(values, (n,)).astype(np.float64)
