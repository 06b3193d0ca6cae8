"""What was asked of a motion: way points, durations, a kind of curve, and the limits it must keep."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, frozen, real_array, require_finite
from mafsil.errors import InputError
from mafsil.robot import Robot
from mafsil.trajectory.motion_limits import Limits, MotionLimits, motion_limits
from mafsil.trajectory.profiles.laws import QUINTIC
from mafsil.trajectory.profiles.polynomial import cubic_coefficients
from mafsil.trajectory.splines.cubic_spline import cubic_through
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial

Curve: TypeAlias = Literal["spline", "stops"]


def _spline(points: Floats, durations: Floats, stops: Sequence[int]) -> PiecewisePolynomial:
    """Cubic splines from stop to stop, at rest there and at both ends."""
    return _between_stops(lambda u, h: cubic_through(u, h).coefficients, points, durations, stops)


def _soft_spline(points: Floats, durations: Floats, stops: Sequence[int]) -> PiecewisePolynomial:
    """The same with accelerations of zero at rest, as limits of jerk ask: the pieces next to a stop are quartics."""
    return _between_stops(_quartic_ends, points, durations, stops)


def _between_stops(
    curve: Callable[[Floats, Floats], Floats], points: Floats, durations: Floats, stops: Sequence[int]
) -> PiecewisePolynomial:
    ends = [0, *stops, len(points) - 1]
    parts = [curve(points[a : b + 1], durations[a:b]) for a, b in pairwise(ends)]
    degree = max(part.shape[1] for part in parts)
    padded = [np.pad(part, ((0, 0), (0, degree - part.shape[1]), (0, 0))) for part in parts]
    return PiecewisePolynomial.from_pieces(durations, np.concatenate(padded))


def _quartic_ends(u: Floats, h: Floats) -> Floats:
    """(k, 6, n) cubics that end at rest without acceleration: first and last are quartics, a single one a quintic.

    The velocities v of the inner points make the acceleration continuous. Seen from rest at distance D a quartic ends
    with the acceleration  6 v/h - 12 D/h^2,  a cubic between two points begins with  6 D/h^2 - (4 v + 2 v')/h.
    """
    k, n = len(h), u.shape[1]
    if k == 1:
        return QUINTIC.between(u[0], u[1], float(h[0])).coefficients
    D = np.diff(u, axis=0)
    A, right = np.zeros((k - 1, k - 1)), np.zeros((k - 1, n))
    for i in range(k - 1):
        for leg, other in ((i, i - 1), (i + 1, i + 1)):
            at_end = leg in (0, k - 1)
            A[i, i] += (6.0 if at_end else 4.0) / h[leg]
            right[i] += (12.0 if at_end else 6.0) * D[leg] / h[leg] ** 2
            if not at_end:
                A[i, other] += 2.0 / h[leg]
    v = np.concatenate([np.zeros((1, n)), np.linalg.solve(A, right), np.zeros((1, n))])
    pieces = np.zeros((k, 6, n))
    for i in range(k):
        T = float(h[i])
        slope, rise = (v[i], v[i + 1]), D[i]
        if i == 0:
            pieces[i, 0] = u[0]
            pieces[i, 3], pieces[i, 4] = (4.0 * rise - slope[1] * T) / T**3, (slope[1] * T - 3.0 * rise) / T**4
        elif i == k - 1:
            c3, c4 = (4.0 * rise - slope[0] * T) / T**3, (slope[0] * T - 3.0 * rise) / T**4
            # Seen from the end backwards: u(t) = u_k - c3 (T - t)^3 - c4 (T - t)^4.
            pieces[i, 0] = u[i]
            pieces[i, 1] = slope[0]
            pieces[i, 2] = -3.0 * c3 * T - 6.0 * c4 * T**2
            pieces[i, 3] = c3 + 4.0 * c4 * T
            pieces[i, 4] = -c4
        else:
            pieces[i, :4] = cubic_coefficients(u[i], u[i + 1], *slope, T)
    return pieces


def _stops(points: Floats, durations: Floats, _stops: Sequence[int]) -> PiecewisePolynomial:
    """A quintic from rest to rest for every leg."""
    legs = zip(points[:-1], points[1:], durations.tolist(), strict=True)
    return PiecewisePolynomial.from_pieces(durations, [QUINTIC.between(a, b, T).coefficients[0] for a, b, T in legs])


CURVES: dict[Curve, Callable[[Floats, Floats, Sequence[int]], PiecewisePolynomial]] = {
    "spline": _spline,
    "stops": _stops,
}
"""Kinds of curves through way points, with the inner points at which they stop."""


@dataclass(frozen=True, eq=False, slots=True)
class MotionRequest:
    """A motion as it was asked for, whether it is possible or not.

    Attributes:
        points: (k + 1, n) way points [rad | m].
        durations: (k,) of the legs between them [s].
        limits: bounds of the n coordinates.
        curve: `spline`: a cubic spline, at rest at both ends, where a jerk is limited with quartic ends that begin
            and end without acceleration; `stops`: quintics that rest at every point.
        joints: (n) names.
        stops: inner points at which a spline stops.
    """

    points: Floats
    durations: Floats
    limits: MotionLimits
    curve: Curve
    joints: tuple[str, ...]
    stops: tuple[int, ...] = ()

    @property
    def duration(self) -> float:
        """Of the whole motion [s]."""
        return float(self.durations.sum())

    def trajectory(self) -> PiecewisePolynomial:
        """The motion, limits or not."""
        soft = self.curve == "spline" and np.isfinite(self.limits.jerk).any()
        return (_soft_spline if soft else CURVES[self.curve])(self.points, self.durations, self.stops)

    def slower(self, factor: float, leg: int | None = None) -> MotionRequest:
        """The same with more time: for one leg, or for all."""
        factors = np.ones_like(self.durations)
        factors[slice(None) if leg is None else leg] = factor
        return replace(self, durations=frozen(self.durations * factors))

    def without(self, point: int) -> MotionRequest:
        """The same without an inner point; the legs on both sides become one that takes as long as both."""
        durations = np.delete(self.durations, point)
        durations[point - 1] += self.durations[point]
        stops = tuple(stop - (stop > point) for stop in self.stops if stop != point)
        points = np.delete(self.points, point, axis=0)
        return replace(self, points=frozen(points), durations=frozen(durations), stops=stops)

    def stopping_at(self, point: int) -> MotionRequest:
        """The same with a stop at an inner point."""
        return replace(self, stops=tuple(sorted({*self.stops, point})))


def motion_request(
    points: ArrayLike,
    durations: ArrayLike,
    limits: Limits,
    *,
    curve: Curve = "spline",
    joints: Sequence[str] = (),
) -> MotionRequest:
    """A request, its numbers checked.

    Args:
        points: (k + 1, n) way points [rad | m].
        durations: (k,) of the legs between them [s].
        limits: a robot, or bounds of n coordinates.
        curve: `spline` or `stops`.
        joints: (n) names; those of the robot if `limits` is one, else indices.

    Raises:
        InputError: a wrong shape, a number that is not finite, a duration that is not positive, an unknown curve.
    """
    q, T = (
        require_finite(name, real_array(name, value)) for name, value in (("points", points), ("durations", durations))
    )
    if q.ndim != 2 or len(q) < 2:
        raise InputError("input.shape", name="points", expected="(k + 1, n), k >= 1", got=q.shape, hint="")
    if T.shape != (len(q) - 1,):
        raise InputError("input.shape", name="durations", expected=(len(q) - 1,), got=T.shape, hint="")
    if (T <= 0.0).any():
        raise InputError("trajectory.leg_duration", leg=int((T <= 0.0).argmax()) + 1, value=float(T.min()))
    if curve not in CURVES:
        raise InputError("input.choice", name="curve", value=curve, known=", ".join(CURVES))
    known = limits.joint_names if isinstance(limits, Robot) else ()
    names = tuple(joints) or known or tuple(str(k) for k in range(q.shape[1]))
    return MotionRequest(frozen(q), frozen(T), motion_limits(limits, q.shape[1]), curve, names)
