"""Curves of a point over s in 0 .. 1: line, arc, and splines through points; each with three derivatives."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, Vector3, real_array, require_finite, single
from mafsil.errors import InputError
from mafsil.trajectory.splines.cubic_spline import cubic_through
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial, way_length
from mafsil.trajectory.tolerances import GIVEN, ROUNDING


class PositionCurve(Protocol):
    """A point that moves over s in 0 .. 1."""

    @property
    def length(self) -> float:
        """Length of the curve [m]."""
        ...

    @property
    def breaks(self) -> Floats:
        """(k + 1,) places between which it is smooth, 0 and 1 included."""
        ...

    def derivatives(self, s: Floats) -> Floats:
        """(4, *s, 3) the point [m] and its three derivatives by s."""
        ...


@dataclass(frozen=True, eq=False)
class LineCurve:
    """p = p_0 + s (p_1 - p_0).

    Attributes:
        start, goal: (3,) ends in {s} [m].
    """

    start: Vector3
    goal: Vector3

    @property
    def length(self) -> float:
        """Distance of the ends [m]."""
        return float(np.linalg.norm(self.goal - self.start))

    @property
    def breaks(self) -> Floats:
        """0 and 1."""
        return np.array([0.0, 1.0])

    def derivatives(self, s: Floats) -> Floats:
        """(4, *s, 3) the point and its derivatives."""
        found = np.zeros((4, *s.shape, 3))
        found[0] = self.start + s[..., None] * (self.goal - self.start)
        found[1] = self.goal - self.start
        return found


@dataclass(frozen=True, eq=False)
class ArcCurve:
    """p = c + cos(phi s) x + sin(phi s) y, around c from c + x, with y = axis x x.

    Attributes:
        centre: (3,) in {s} [m].
        axis: (3,) unit normal of its plane.
        radius: (3,) x, from the centre to the start [m].
        angle: phi, that it covers in the sense of the axis; negative ones run the other way round [rad].
    """

    centre: Vector3
    axis: Vector3
    radius: Vector3
    angle: float

    @classmethod
    def through(cls, start: ArrayLike, via: ArrayLike, goal: ArrayLike) -> ArcCurve:
        """The arc from a start over a point to a goal.

        Raises:
            InputError: the three points lie on a line, or two of them are one point.
        """
        a, b, c = (single(name, p, (3,)) for name, p in (("start", start), ("via", via), ("goal", goal)))
        u, v = b - a, c - a
        normal = np.cross(u, v)
        if np.linalg.norm(normal) <= GIVEN * np.linalg.norm(u) * np.linalg.norm(v) or not normal.any():
            points = {name: str((np.round(p, 9) + 0.0).tolist()) for name, p in (("start", a), ("via", b), ("goal", c))}
            raise InputError("trajectory.arc_points", **points)
        # From the start to the centre: (|v|^2 n x u + |u|^2 v x n) / 2 |n|^2 with n = u x v.
        to_centre = ((v @ v) * np.cross(normal, u) + (u @ u) * np.cross(v, normal)) / (2 * normal @ normal)
        centre = a + to_centre
        axis, x = normal / np.linalg.norm(normal), -to_centre
        y, end = np.cross(axis, x), c - centre
        return cls(centre, axis, x, float(np.arctan2(end @ y, end @ x) % (2 * np.pi)))

    @classmethod
    def about(cls, start: ArrayLike, centre: ArrayLike, axis: ArrayLike, angle: float) -> ArcCurve:
        """The arc from a start around an axis through a centre; its plane is that of the start.

        Raises:
            InputError: the start lies on the axis, an axis without direction, an angle of zero.
        """
        a, c = single("start", start, (3,)), single("centre", centre, (3,))
        n = single("axis", axis, (3,))
        if not np.linalg.norm(n) > 0.0:
            raise InputError("trajectory.arc_axis", axis=str(n))
        n = n / np.linalg.norm(n)
        middle = c + n * (n @ (a - c))
        if np.linalg.norm(a - middle) <= ROUNDING * max(1.0, float(np.linalg.norm(a - c))):
            raise InputError("trajectory.arc_on_axis", start=str(a), centre=str(c))
        turn = float(single("angle", angle, ()))
        if turn == 0.0:
            raise InputError("trajectory.arc_angle")
        return cls(middle, n, a - middle, turn)

    @property
    def length(self) -> float:
        """Of the arc [m]."""
        return float(np.linalg.norm(self.radius)) * abs(self.angle)

    @property
    def breaks(self) -> Floats:
        """0 and 1."""
        return np.array([0.0, 1.0])

    def derivatives(self, s: Floats) -> Floats:
        """(4, *s, 3) the point and its derivatives."""
        x, y = self.radius, np.cross(self.axis, self.radius)
        quarter = self.angle * s[..., None] + np.pi / 2 * np.arange(4).reshape((4,) + (1,) * (s.ndim + 1))
        found = np.cos(quarter) * x + np.sin(quarter) * y
        found *= (self.angle ** np.arange(4)).reshape((4,) + (1,) * (s.ndim + 1))
        found[0] += self.centre
        return found


@dataclass(frozen=True, eq=False)
class SplineCurve:
    """Coordinates that are piecewise polynomials over s.

    Attributes:
        polynomial: (3) coordinates over 0 .. 1.
    """

    polynomial: PiecewisePolynomial

    @property
    def length(self) -> float:
        """By Gauss and Legendre in every piece [m]."""
        return self._length

    @cached_property
    def _length(self) -> float:
        return way_length(lambda s: self.derivatives(s)[1], self.breaks)

    @property
    def breaks(self) -> Floats:
        """Its knots."""
        return self.polynomial.knots

    def derivatives(self, s: Floats) -> Floats:
        """(4, *s, 3) the point and its derivatives."""
        inside = np.clip(s, 0.0, 1.0)
        return np.stack([*self.polynomial.at(inside), self.polynomial.jerk(inside)])


def spline_knots(points: Floats, extra: Floats | None = None) -> Floats:
    """(k + 1,) places of points on a spline, by the distances between them.

    Args:
        points: (k + 1, m).
        extra: (k,) lengths that count besides.

    Raises:
        InputError: two points that follow each other are one.
    """
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    steps = steps if extra is None else np.hypot(steps, extra)
    if not (steps > ROUNDING * max(1.0, float(steps.sum()))).all():
        raise InputError("trajectory.repeated_point", index=int(steps.argmin()) + 1)
    knots = np.concatenate([[0.0], np.cumsum(steps)]) / steps.sum()
    knots[-1] = 1.0
    return knots


def natural_spline(values: ArrayLike, knots: Floats, *, closed: bool = False) -> PiecewisePolynomial:
    """Cubic spline through values: second derivative zero at the ends, or alike at both ends of a closed one.

    Args:
        values: (k + 1, m).
        knots: (k + 1,) from 0 to 1.
        closed: the ends agree in value, and shall in both derivatives.
    """
    u = require_finite("values", real_array("values", values))
    h = np.diff(knots)
    m = u.shape[1]
    if len(h) == 1 and not closed:
        return PiecewisePolynomial.from_pieces(h, [np.stack([u[0], (u[1] - u[0]) / h[0]])])
    zero = np.zeros(m)
    # Second derivatives at the ends are linear in the velocities there: three splines show how.
    plain, first, last = (
        cubic_through(values, h, start_velocity=v, goal_velocity=w)
        for values, v, w in ((u, zero, zero), (0 * u, zero + 1, zero), (0 * u, zero, zero + 1))
    )
    ends = [_end_bends(curve, h) for curve in (plain, first, last)]
    if closed:
        slope = -(ends[0][0] - ends[0][1]) / (ends[1][0] + ends[2][0] - ends[1][1] - ends[2][1])
        return cubic_through(u, h, start_velocity=slope, goal_velocity=slope)
    M = np.array([[ends[1][0][0], ends[2][0][0]], [ends[1][1][0], ends[2][1][0]]])
    v, w = np.linalg.solve(M, -np.stack(ends[0]))
    return cubic_through(u, h, start_velocity=v, goal_velocity=w)


def _end_bends(curve: PiecewisePolynomial, h: Floats) -> tuple[Floats, Floats]:
    """Second derivatives at both ends."""
    c = curve.coefficients
    return 2 * c[0, 2], 2 * c[-1, 2] + 6 * c[-1, 3] * h[-1]
