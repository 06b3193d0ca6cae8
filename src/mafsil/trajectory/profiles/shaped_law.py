"""Time laws of any fixed shape: sines, exponentials, pieces of constant jerk; and the motions that follow them.

What a time law is: how a motion from rest to rest spends its time, the same for every distance and duration.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from math import exp, pi
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, frozen
from mafsil.trajectory.motion import Motion, Printed, Stretchable, moving_at, times
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial


class LawShape(Protocol):
    """s(x) from 0 to 1 over x = t/T in 0 .. 1, with its derivatives in closed form."""

    def value(self, x: Floats, order: int) -> Floats:
        """The derivative of that order, 0 to 3, at shares x of the duration."""
        ...

    @property
    def knots(self) -> tuple[float, ...]:
        """Between these the shape is smooth, 0 and 1 included."""
        ...

    @property
    def extremes(self) -> tuple[float, ...]:
        """Shares of the duration among which derivatives 1 to 3 take their extremes."""
        ...


@dataclass(frozen=True)
class Harmonic:
    """s = c + m x + A sin(w x + p).

    Attributes:
        constant, slope, amplitude, frequency, phase: c, m, A, w, p.
    """

    constant: float
    slope: float
    amplitude: float
    frequency: float
    phase: float

    knots = (0.0, 1.0)

    @property
    def extremes(self) -> tuple[float, ...]:
        """Ends, and quarters of a period, where sine and cosine are 0 or 1."""
        quarter = pi / 2 / self.frequency
        inside = (k * quarter - self.phase / self.frequency for k in range(-8, 9))
        return (0.0, *(x for x in inside if 0.0 < x < 1.0), 1.0)

    def value(self, x: Floats, order: int) -> Floats:
        """See `LawShape.value`."""
        line = self.constant + self.slope * x if order == 0 else self.slope if order == 1 else 0.0
        wave = np.sin(self.frequency * x + self.phase + order * pi / 2)
        return line + self.amplitude * self.frequency**order * wave


@dataclass(frozen=True)
class ExponentialApproach:
    """s = (1 - e^(-k x)) / (1 - e^-k): fast at first, slower and slower; starts with a jump of its speed.

    e^-k is what the true exponential 1 - e^(-t/tau) still lacks after T = k tau: it is truncated there, and stretched
    by 1 / (1 - e^-k) so that it arrives; at its end its speed jumps from k e^-k / (1 - e^-k) to zero.

    Attributes:
        time_constants: k, how many of them the motion lasts.
    """

    time_constants: float

    knots = (0.0, 1.0)
    extremes = (0.0, 1.0)

    @property
    def truncated(self) -> float:
        """e^-k, the share of the way that the truncated exponential lacks."""
        return exp(-self.time_constants)

    def value(self, x: Floats, order: int) -> Floats:
        """See `LawShape.value`."""
        k = self.time_constants
        decay = np.expm1(-k * x) if order == 0 else (-k) ** order * np.exp(-k * x)
        return decay / np.expm1(-k)


@dataclass(frozen=True, eq=False)
class Pieces:
    """s(x) made of polynomials.

    Attributes:
        motion: (1) coordinate from 0 to 1 within one second.
    """

    motion: PiecewisePolynomial

    @property
    def knots(self) -> tuple[float, ...]:
        """The motion's."""
        return tuple(self.motion.knots.tolist())

    @property
    def extremes(self) -> tuple[float, ...]:
        """Both sides of the knots, where accelerations and jerks jump, and what lies between."""
        inside = [float(x) for order in (1, 2) for x in self.motion.stationary_times(order)]
        before = [float(np.nextafter(x, 0.0)) for x in self.knots[1:]]
        return tuple(sorted({*self.knots, *before, *inside}))

    def value(self, x: Floats, order: int) -> Floats:
        """See `LawShape.value`."""
        return self.motion.jerk(x)[..., 0] if order == 3 else self.motion.at(x)[order][..., 0]


@dataclass(frozen=True, eq=False, repr=False)
class ShapedMotion(Printed):
    """u(t) = start + (goal - start) s(t/T).

    Attributes:
        start, goal: (*batch, n) [rad | m].
        duration: T [s].
        shape: s.
    """

    start: Floats
    goal: Floats
    duration: float
    shape: LawShape

    @property
    def n(self) -> int:
        """Number of coordinates."""
        return self.start.shape[-1]

    def breaks(self) -> Floats:
        """Times between which the motion is smooth [s]."""
        return np.array(self.shape.knots) * self.duration

    def at(self, t: ArrayLike) -> Motion:
        """Position, velocity and acceleration at the times `t` (*times) [s]; at rest outside 0 .. duration."""
        moment = times(t)
        moving = moving_at(moment, self.duration, self.start.ndim)
        s, v, a = (self._share(moment, order) for order in range(3))
        way = self.goal - self.start
        return Motion(self.start + way * s, way * v * moving, way * a * moving)

    def jerk(self, t: ArrayLike) -> Floats:
        """(*times, *batch, n) third derivative at the times `t` [rad/s^3 | m/s^3]; zero outside 0 .. duration."""
        moment = times(t)
        return (self.goal - self.start) * self._share(moment, 3) * moving_at(moment, self.duration, self.start.ndim)

    def scale_time(self, factor: float) -> ShapedMotion:
        """The same path, `factor` times as slow."""
        return replace(self, duration=self.duration * factor)

    def _share(self, t: Floats, order: int) -> Floats:
        """(*times, 1 ..) a derivative of s by time."""
        if self.duration == 0.0:
            return np.full(t.shape + (1,) * self.start.ndim, float(order == 0))
        x = np.clip(t, 0.0, self.duration) / self.duration
        return (self.shape.value(x, order) / self.duration**order).reshape(t.shape + (1,) * self.start.ndim)


@dataclass(frozen=True, eq=False)
class ShapedLaw:
    """A time law of one fixed shape.

    Attributes:
        shape: s(x).
    """

    shape: LawShape

    @property
    def peaks(self) -> tuple[float, float, float]:
        """Largest |ds/dx|, |d2s/dx2| and |d3s/dx3|; see `TimeLaw.peaks`."""
        return self._peaks

    @cached_property
    def _peaks(self) -> tuple[float, float, float]:
        x = np.array(self.shape.extremes)
        first, second, third = (float(np.abs(self.shape.value(x, order)).max()) for order in (1, 2, 3))
        return first, second, third

    def unit(self) -> ShapedMotion:
        """s(t) from 0 to 1 within one second."""
        return self.between(np.zeros(1), np.ones(1), 1.0)

    def between(self, start: Floats, goal: Floats, duration: float) -> ShapedMotion:
        """The motion from `start` to `goal` (*batch, n) that takes `duration` [s]."""
        return ShapedMotion(frozen(start), frozen(goal), duration, self.shape)

    def fastest(
        self,
        start: Floats,
        goal: Floats,
        *,
        velocity: Floats | float,
        acceleration: Floats | float,
        margin: float = 0.0,
        least: float = 0.0,
    ) -> ShapedMotion:
        """The shortest motion whose peaks keep the limits; see `TimeLaw.fastest`."""
        shortest = shortest_duration(self.peaks, goal - start, velocity, acceleration)
        return self.between(start, goal, max(shortest * (1.0 + margin), least))


class TimeLaw(Protocol):
    """All coordinates on one share s(t) of their way, or each with its own blends."""

    @property
    def peaks(self) -> tuple[float, float, float]:
        """Largest |ds/dx|, |d2s/dx2| and |d3s/dx3| over x = t/T: peak velocity T/D, acceleration T^2/D, jerk T^3/D."""
        ...

    def unit(self) -> Stretchable:
        """s(t) from 0 to 1 within one second."""
        ...

    def between(self, start: Floats, goal: Floats, duration: float) -> Stretchable:
        """The motion from `start` to `goal` (*batch, n) that takes `duration` [s]."""
        ...

    def fastest(
        self,
        start: Floats,
        goal: Floats,
        *,
        velocity: Floats | float,
        acceleration: Floats | float,
        margin: float = 0.0,
        least: float = 0.0,
    ) -> Stretchable:
        """The shortest motion whose peaks keep the limits.

        Args:
            start, goal: (n,) positions [rad | m | 1].
            velocity, acceleration: (n,) or a number, largest magnitudes.
            margin: share of time on top, where peaks that equal a limit by formula exceed it by rounding.
            least: shortest duration of a motion whose formula divides by it [s].
        """
        ...


def shortest_duration(
    peaks: tuple[float, float, float], distance: Floats, velocity: Floats | float, acceleration: Floats | float
) -> float:
    """Shortest time of all coordinates together [s]: peak velocity p_1 |D| / T, peak acceleration p_2 |D| / T^2.

    Args:
        peaks: of the law.
        distance: (n,) D to go [rad | m | 1].
        velocity, acceleration: (n,) or a number, largest magnitudes.
    """
    way = np.abs(distance)
    each = np.maximum(peaks[0] * way / velocity, np.sqrt(peaks[1] * way / acceleration))
    return float(each.max(initial=0.0))
