"""A geometric path and a time law: the same path can be run at any speed."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats
from mafsil.model import JointLimits
from mafsil.trajectory.checks.limit_check import extremes
from mafsil.trajectory.motion import Motion, Printed, Stretchable, times
from mafsil.trajectory.motion_limits import MotionLimits, motion_limits, share_of
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial


@dataclass(frozen=True, eq=False, repr=False)
class PathMotion(Printed):
    """u(t) = path(s(t)).

    Attributes:
        path: (n) coordinates over the path parameter s, from 0 to its length.
        law: (1) s over time, from 0 to that length.
        places: (pieces + 1,) s at the knots of a law that only grows; each piece of the law then keeps to its own piece
            of the path, also where rounding would lead it over a knot at which the path's derivatives jump.
    """

    path: PiecewisePolynomial
    law: Stretchable
    places: Floats | None = None

    @property
    def duration(self) -> float:
        """Length in time [s]."""
        return self.law.duration

    @property
    def n(self) -> int:
        """Number of coordinates."""
        return self.path.n

    def breaks(self) -> Floats:
        """The knots of the time law [s]; the path is twice continuously differentiable."""
        return self.law.breaks()

    def at(self, t: ArrayLike) -> Motion:
        """Position, velocity and acceleration at the times `t` (*times) [s]; at rest outside 0 .. duration.

        v = path' s',  a = path'' s'^2 + path' s''
        """
        s, rate, growth = self.law.at(t)
        here = self.path.at(self._places(t, s))
        return Motion(here.u, here.v * rate, here.a * rate**2 + here.v * growth)

    def jerk(self, t: ArrayLike) -> Floats:
        """(*times, n) third derivative path''' s'^3 + 3 path'' s' s'' + path' s''' [rad/s^3 | m/s^3]."""
        s, rate, growth = self.law.at(t)
        place = self._places(t, s)
        here, third = self.path.at(place), self.path.jerk(place)
        return third * rate**3 + 3 * here.a * rate * growth + here.v * self.law.jerk(times(t))

    def scale_time(self, factor: float) -> PathMotion:
        """The same path, `factor` times as slow."""
        return replace(self, law=self.law.scale_time(factor))

    def stretch_needed(self, limits: JointLimits | MotionLimits) -> float:
        """The factor of time at which velocity, acceleration and jerk just keep their limits; 0 if none is finite.

        Derivative k shrinks with the k-th power of the factor.
        """
        bounds, needed = motion_limits(limits, self.n), [0.0]
        for order, sides in ((1, bounds.velocity), (2, bounds.acceleration), (3, bounds.jerk)):
            if np.isfinite(sides).any():
                shares = share_of(extremes(self, order)[1], sides)
                needed.append(float(shares.max()) ** (1.0 / order))
        return max(needed)

    def _places(self, t: ArrayLike, s: Floats) -> Floats:
        """(*times) where on the path the motion is, never beyond an end by rounding."""
        if self.places is None:
            return np.clip(s[..., 0], 0.0, self.path.duration)
        k = np.clip(np.searchsorted(self.law.breaks(), times(t), side="right") - 1, 0, len(self.places) - 2)
        ends = np.append(np.nextafter(self.places[1:-1], 0.0), self.places[-1])
        return np.clip(s[..., 0], self.places[k], np.maximum(ends[k], self.places[k]))
