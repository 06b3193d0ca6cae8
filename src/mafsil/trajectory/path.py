"""Geometric paths of joints: where they pass, not when; and motions, which are a path and a law of time."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, frozen, real_array, require_finite, require_kind
from mafsil.errors import InputError
from mafsil.model import JointLimits
from mafsil.trajectory.checks.limit_check import extremes
from mafsil.trajectory.motion import Motion, Printed, Stretchable, Trajectory, times
from mafsil.trajectory.motion_limits import MotionLimits, motion_limits, share_of
from mafsil.trajectory.profiles.polynomial import cubic_coefficients, quintic_coefficients
from mafsil.trajectory.splines.cubic_spline import spline_velocities
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial, way_length
from mafsil.trajectory.tolerances import CORNER, REPEATED

PathKind = Literal["spline", "lines"]
KINDS = ("spline", "lines")
SAMPLES_PER_BREAK = 8
"""Pieces that stand for a stretch of a trajectory that is no piecewise polynomial."""


class PathPoint(NamedTuple):
    """A path and its derivatives by the path parameter at one or many places.

    Attributes:
        u: (*places, n) position [rad | m].
        slope: the same shape, du/ds.
        curvature: the same shape, d2u/ds2.
    """

    u: Floats
    slope: Floats
    curvature: Floats


@dataclass(frozen=True, eq=False, repr=False)
class JointPath:
    """n coordinates over the path parameter s in 0 .. end; it has no time and no velocity.

    Attributes:
        curve: (n) coordinates, polynomials between the knots of s.
        merged: indices of the given points that repeat the point before them and were left out.
    """

    curve: PiecewisePolynomial
    merged: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        require_kind("curve", self.curve, "PiecewisePolynomial", "knots", "coefficients")
        if self.curve.coefficients.ndim != 3:
            shape = self.curve.coefficients.shape
            raise InputError("input.shape", name="curve", expected="(pieces, degree + 1, n)", got=shape, hint="")

    @classmethod
    def through(cls, points: ArrayLike, kind: PathKind = "spline") -> JointPath:
        """The path through points, with the distance between them as path parameter.

        Points that repeat the one before them are left out and named in `merged`; if all are one point the path has no
        length, and that is a path.

        Args:
            points: (k, n) positions in order [rad | m].
            kind: `spline`, cubics with continuous curvature that is zero at both ends; or `lines`, straight from point
                to point, with corners.

        Raises:
            InputError: a wrong shape, no point, a number that is not finite, or an unknown kind.
        """
        u = require_finite("points", real_array("points", points))
        if u.ndim != 2 or not u.size:
            raise InputError("input.shape", name="points", expected="(k, n), k >= 1", got=u.shape, hint="")
        if kind not in KINDS:
            raise InputError("input.choice", name="kind", value=kind, known=", ".join(KINDS))
        apart = np.linalg.norm(np.diff(u, axis=0), axis=1) > REPEATED * np.abs(u).max()
        merged = tuple(int(k) + 1 for k in np.flatnonzero(~apart))
        u = u[np.concatenate([[True], apart])]
        if len(u) == 1:
            return cls(PiecewisePolynomial(frozen([0.0, 0.0]), frozen(u[None])), merged)
        h = np.linalg.norm(np.diff(u, axis=0), axis=1)
        if kind == "lines":
            return cls(
                PiecewisePolynomial.from_pieces(h, np.stack([u[:-1], np.diff(u, axis=0) / h[:, None]], 1)), merged
            )
        slopes = spline_velocities(u, h, "natural")
        rows = cubic_coefficients(u[:-1], u[1:], slopes[:-1], slopes[1:], h[:, None])
        return cls(PiecewisePolynomial.from_pieces(h, rows.transpose(1, 0, 2)), merged)

    @classmethod
    def of(cls, trajectory: Trajectory) -> JointPath:
        """The path of a trajectory, without its timing; the path parameter is the trajectory's time.

        Piecewise polynomials are kept as they are; others are quintics through position, velocity and acceleration at
        their breaks and between them.

        Args:
            trajectory: of n coordinates, without batch dimensions.
        """
        if isinstance(trajectory, PiecewisePolynomial):
            return cls(trajectory)
        require_kind("trajectory", trajectory, "Trajectory", "duration", "breaks")
        breaks = trajectory.breaks()
        even = np.linspace(0.0, 1.0, SAMPLES_PER_BREAK, endpoint=False)
        s = np.append((breaks[:-1, None] + even * np.diff(breaks)[:, None]).ravel(), breaks[-1])
        # Accelerations may jump at breaks: each piece asks for them just inside.
        first, last = trajectory.at(np.nextafter(s[:-1], np.inf)), trajectory.at(np.nextafter(s[1:], 0.0))
        rows = [
            quintic_coefficients(first.u[k], last.u[k], first.v[k], last.v[k], first.a[k], last.a[k], h)
            for k, h in enumerate(np.diff(s))
        ]
        return cls(PiecewisePolynomial.from_pieces(np.diff(s), rows))

    @property
    def end(self) -> float:
        """Largest path parameter; of paths through points the length of the polygon [rad | m]."""
        return self.curve.duration

    @property
    def length(self) -> float:
        """Length of the way in the coordinates, the integral of |du/ds| [rad | m]."""
        return self._length

    @cached_property
    def _length(self) -> float:
        return way_length(lambda s: self.curve.derivative(s, 1), self.breaks())

    @property
    def n(self) -> int:
        """Number of coordinates."""
        return self.curve.n

    def breaks(self) -> Floats:
        """(pieces + 1,) path parameters between which the path is a polynomial, 0 and the end included."""
        return self.curve.knots

    def corners(self) -> Floats:
        """(k,) path parameters inside the path where its direction jumps: no motion passes them without a stop."""
        return self.curve.knots[1:-1][self._jumps(1)]

    def stops(self) -> Floats:
        """(k,) path parameters inside the path where its direction or its curvature jumps: with finite jerk, stops."""
        return self.curve.knots[1:-1][self._jumps(1) | self._jumps(2)]

    def between(self, begin: float, end: float) -> JointPath:
        """The part between two of its breaks, as a path of its own.

        Args:
            begin, end: two of `breaks()`.

        Raises:
            InputError: the end is not behind the beginning.
        """
        if not begin < end:
            raise InputError("input.range", name="begin", value=begin, low=0.0, high=end)
        first, last = (int(np.searchsorted(self.curve.knots, s)) for s in (begin, end))
        knots = self.curve.knots[first : last + 1] - self.curve.knots[first]
        return JointPath(PiecewisePolynomial(frozen(knots), frozen(self.curve.coefficients[first:last])))

    def _jumps(self, order: int) -> NDArray[np.bool_]:
        """Of each knot inside, whether a derivative jumps there; curvatures against the largest of the path."""
        if self.curve.degree < order or len(self.curve.knots) < 3:
            return np.zeros(max(len(self.curve.knots) - 2, 0), dtype=np.bool_)
        inner = self.curve.knots[1:-1]
        before = self.curve.derivative(inner, order, within=np.nextafter(inner, 0.0))
        after = self.curve.derivative(inner, order)
        size = np.maximum(np.abs(before).max(axis=1), np.abs(after).max(axis=1))
        if order > 1:
            middles = (self.curve.knots[:-1] + self.curve.knots[1:]) / 2.0
            size = np.full_like(size, max(size.max(), np.abs(self.curve.derivative(middles, order)).max()))
        return np.asarray(np.abs(after - before).max(axis=1) > CORNER * size, dtype=np.bool_)

    def at(self, s: ArrayLike) -> PathPoint:
        """Position, slope and curvature at the path parameters `s` (*places); beyond its ends the path goes on nowhere.

        Raises:
            InputError: a NaN or infinity.
        """
        return PathPoint(*self.curve.at(np.clip(times(s), 0.0, self.end)))

    def third(self, s: ArrayLike) -> Floats:
        """(*places, n) third derivative d3u/ds3 at the path parameters `s` (*places)."""
        return self.curve.jerk(np.clip(times(s), 0.0, self.end))

    def reverse(self) -> JointPath:
        """The same points from the end to the start."""
        h, rows = np.diff(self.curve.knots), self.curve.coefficients
        degree = rows.shape[1] - 1
        out = np.zeros_like(rows)
        # u(h - r) = sum_k c_k (h - r)^k, by Horner's rule on polynomials in r.
        for k in range(degree, -1, -1):
            shifted = out * h[:, None, None]
            shifted[:, 1:] -= out[:, :-1]
            shifted[:, 0] += rows[:, k]
            out = shifted
        return JointPath(PiecewisePolynomial(frozen(self.end - self.curve.knots[::-1]), frozen(out[::-1])))

    def __repr__(self) -> str:
        return f"JointPath(n={self.n}, length={self.length:.6g}, pieces={len(self.curve.knots) - 1})"


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

    def is_within(self, limits: JointLimits | MotionLimits) -> bool:
        """Whether velocity, acceleration and jerk keep their limits everywhere.

        Bounds of the derivatives of path and law decide where they can; else the motion is looked at.
        """
        bounds, law = motion_limits(limits, self.n), self.law
        if isinstance(law, PiecewisePolynomial):
            (p1, p2, p3), (s1, s2, s3) = ([each.bound(order) for order in (1, 2, 3)] for each in (self.path, law))
            most = (p1 * s1, p2 * s1**2 + p1 * s2, p3 * s1**3 + 3.0 * p2 * s1 * s2 + p1 * s3)
            sides = (bounds.velocity, bounds.acceleration, bounds.jerk)
            if all((each <= np.abs(side).min(axis=0)).all() for each, side in zip(most, sides, strict=True)):
                return True
        return self.stretch_needed(limits) <= 1.0

    def _places(self, t: ArrayLike, s: Floats) -> Floats:
        """(*times) where on the path the motion is, never beyond an end by rounding."""
        if self.places is None:
            return np.clip(s[..., 0], 0.0, self.path.duration)
        k = np.clip(np.searchsorted(self.law.breaks(), times(t), side="right") - 1, 0, len(self.places) - 2)
        ends = np.append(np.nextafter(self.places[1:-1], 0.0), self.places[-1])
        return np.clip(s[..., 0], self.places[k], np.maximum(ends[k], self.places[k]))
