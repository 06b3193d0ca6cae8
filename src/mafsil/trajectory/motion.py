"""The protocol of all trajectories: a duration, a width, and position, velocity and acceleration at any time."""

from __future__ import annotations

from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, real_array, require_finite


class Motion(NamedTuple):
    """Position, velocity and acceleration of all coordinates at one or many times.

    Attributes:
        u: (*times, *batch, n) position [rad | m | 1].
        v: the same shape, du/dt.
        a: the same shape, d2u/dt2.
    """

    u: Floats
    v: Floats
    a: Floats


@runtime_checkable
class Trajectory(Protocol):
    """A motion of n coordinates over the time 0 .. duration; before and after it rests at its ends."""

    @property
    def duration(self) -> float:
        """Length in time [s]."""
        ...

    @property
    def n(self) -> int:
        """Number of coordinates."""
        ...

    def at(self, t: ArrayLike) -> Motion:
        """Position, velocity and acceleration at the times `t` (*times) [s]; at rest outside 0 .. duration."""
        ...

    def jerk(self, t: ArrayLike) -> Floats:
        """(*times, *batch, n) third derivative at the times `t` [rad/s^3 | m/s^3]."""
        ...

    def breaks(self) -> Floats:
        """(k + 1,) times between which the motion is smooth, 0 and the duration included [s]."""
        ...


@runtime_checkable
@runtime_checkable
class Stretchable(Trajectory, Protocol):
    """A trajectory that can be run slower or faster on the same path."""

    def scale_time(self, factor: float) -> Stretchable:
        """The same path, `factor` times as slow."""
        ...


def derivative(trajectory: Trajectory, t: Floats, order: int) -> Floats:
    """A derivative of a trajectory.

    Args:
        trajectory: of n coordinates.
        t: (k,) times [s].
        order: 0 to 3, position to jerk.

    Returns:
        (k, n) [rad | m] and time derivatives.
    """
    return trajectory.jerk(t) if order == 3 else trajectory.at(t)[order]


def times(t: ArrayLike) -> Floats:
    """Times as a finite float64 array.

    Raises:
        InputError: not real numbers, or a NaN or infinity.
    """
    return require_finite("t", real_array("t", t))


def moving_at(t: Floats, duration: float, trailing: int) -> Floats:
    """Whether a trajectory moves: 1 inside 0 .. duration and 0 outside.

    Args:
        t: (*times) [s].
        duration: of the trajectory [s].
        trailing: number of axes of length one that are appended.
    """
    inside = ((t >= 0.0) & (t <= duration)).astype(np.float64)
    return inside.reshape(t.shape + (1,) * trailing)
