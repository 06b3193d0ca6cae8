"""B-splines of any degree: a trajectory that stays in the convex hull of its control points.

B-splines through points, among them those of least jerk and of least snap.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import factorial
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, frozen, positive, real_array, require_finite, whole
from mafsil.errors import InputError
from mafsil.fields import check_fields, numbers
from mafsil.solvers.decompositions import solve_banded
from mafsil.trajectory.motion import Motion, Printed, moving_at, times
from mafsil.trajectory.splines.cubic_spline import points_and_durations
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial
from mafsil.trajectory.tolerances import GIVEN

MOST_DEGREE = 15
KnotRule = Literal["clamped", "uniform"]


@dataclass(frozen=True, eq=False, repr=False)
class BSpline(Printed):
    """u(t) = sum_i N_i(t) control[i] over knots[degree] <= t <= knots[-1 - degree].

    Attributes:
        knots: (k + degree + 1,) not decreasing, knots[degree] zero [s].
        control: (k, *batch, n) control points [rad | m].
        degree: of the pieces.
    """

    knots: Floats
    control: Floats
    degree: int
    __post_init__ = check_fields(knots=numbers(1), control=numbers())

    @property
    def duration(self) -> float:
        """Length in time [s]."""
        return float(self.knots[-1 - self.degree])

    @property
    def n(self) -> int:
        """Number of coordinates."""
        return self.control.shape[-1]

    def breaks(self) -> Floats:
        """Times between which the motion is one polynomial [s]."""
        return np.unique(self.knots[self.degree : len(self.knots) - self.degree])

    def at(self, t: ArrayLike) -> Motion:
        """Position, velocity and acceleration at the times `t` (*times) [s]; at rest outside 0 .. duration."""
        moment = times(t)
        moving = moving_at(moment, self.duration, self.control.ndim - 1)
        return Motion(self.value(moment), *(self.derivative(k).value(moment) * moving for k in (1, 2)))

    def jerk(self, t: ArrayLike) -> Floats:
        """(*times, *batch, n) third derivative at the times `t` [rad/s^3 | m/s^3]; zero outside 0 .. duration."""
        moment = times(t)
        return self.derivative(3).value(moment) * moving_at(moment, self.duration, self.control.ndim - 1)

    def derivative(self, order: int = 1) -> BSpline:
        """The derivative of that order, a B-spline too: control points p (c_{i+1} - c_i)/(t_{i+p+1} - t_{i+1})."""
        if order == 0:
            return self
        return self._slope if order == 1 else self._slope.derivative(order - 1)

    def hull(self, order: int = 0) -> Floats:
        """(2, *batch, n) least and largest control points of a derivative: between them it stays at all times."""
        control = self.derivative(order).control
        return np.stack([control.min(axis=0), control.max(axis=0)])

    def insert(self, t: ArrayLike) -> BSpline:
        """The same motion with more knots, so with a closer hull (Boehm).

        Args:
            t: (k,) new knots inside 0 .. duration, each as often as it is given; at most `degree` of one place [s].

        Raises:
            InputError: a time outside, or a knot too many at one place.
        """
        spline = self
        for moment in np.atleast_1d(times(t)).tolist():
            if not 0.0 <= moment <= self.duration:
                raise InputError("input.range", name="t", value=moment, low=0.0, high=self.duration)
            spline = spline._insert(moment)
        return spline

    def to_polynomial(self) -> PiecewisePolynomial:
        """The same motion as a list of polynomials."""
        breaks = self.breaks()
        pieces = [self.derivative(k).value(breaks[:-1]) / factorial(k) for k in range(self.degree + 1)]
        return PiecewisePolynomial.from_pieces(np.diff(breaks), np.stack(pieces, axis=1))

    def scale_time(self, factor: float) -> BSpline:
        """The same path, `factor` times as slow."""
        return replace(self, knots=frozen(self.knots * factor))

    @cached_property
    def _slope(self) -> BSpline:
        p, t = self.degree, self.knots
        if p == 0:
            return replace(self, control=np.zeros_like(self.control))
        return BSpline(frozen(t[1:-1]), frozen(_slope_of(self.control, t, p)), p - 1)

    def _insert(self, moment: float) -> BSpline:
        """One knot more."""
        p, t = self.degree, self.knots
        if (t == moment).sum() >= p:
            raise InputError("trajectory.knots", degree=p)
        span = int(np.clip(np.searchsorted(t, moment, side="right") - 1, p, len(self.control) - 1))
        share = np.ones(len(self.control) + 1)
        inner = np.arange(span - p + 1, span + 1)
        share[inner] = (moment - t[inner]) / (t[inner + p] - t[inner])
        share[span + 1 :] = 0.0
        share = share.reshape((-1,) + (1,) * (self.control.ndim - 1))
        after = np.concatenate([self.control, self.control[-1:]])
        before = np.concatenate([self.control[:1], self.control])
        return BSpline(frozen(np.insert(t, span + 1, moment)), frozen(share * after + (1.0 - share) * before), p)

    def value(self, t: Floats) -> Floats:
        """(*times, *batch, n) at the times `t`, before and after those of the ends [rad | m]."""
        first, basis = _basis_at(self.knots, self.degree, np.clip(t, 0.0, self.duration).ravel())
        value = np.zeros((len(first), *self.control.shape[1:]))
        for j in range(self.degree + 1):
            value += basis[j].reshape((-1,) + (1,) * (value.ndim - 1)) * self.control[first + j]
        return value.reshape(*t.shape, *self.control.shape[1:])


def _basis_at(knots: Floats, degree: int, t: Floats) -> tuple[NDArray[np.intp], Floats]:
    """(k,) first basis function that is not zero at each time, and (degree + 1, k) the values from it on."""
    span = np.clip(np.searchsorted(knots, t, side="right") - 1, degree, len(knots) - degree - 2)
    # The last time belongs to the last span that has a length.
    while (empty := knots[span + 1] <= knots[span]).any() and (span[empty] > degree).all():
        span = span - empty
    return span - degree, _basis(knots, degree, span, t)


def _basis(knots: Floats, degree: int, span: NDArray[np.intp], t: Floats) -> Floats:
    """(degree + 1, times) basis functions that are not zero in a span, by the recursion of Cox and de Boor."""
    basis = np.zeros((degree + 1, len(t)))
    basis[0] = 1.0
    for p in range(1, degree + 1):
        carried = np.zeros(len(t))
        for j in range(p):
            right, left = knots[span + j + 1] - t, t - knots[span + 1 - p + j]
            part = basis[j] / (right + left)
            basis[j] = carried + right * part
            carried = left * part
        basis[p] = carried
    return basis


def bspline(
    control_points: ArrayLike, duration: float, *, degree: int = 3, knots: KnotRule | ArrayLike = "clamped"
) -> BSpline:
    """The B-spline of given control points.

    Args:
        control_points: (*batch, k, n) with k > degree [rad | m]; (k,) is one coordinate.
        duration: T [s].
        degree: of its pieces, at least 1.
        knots: `clamped` evenly from 0 to T, ends repeated: it starts and ends in its first and last control point, at
            rest where two control points are equal; `uniform` evenly, also beyond both ends; or (k + degree + 1,) times
            themselves, of which knots[degree] is the start and knots[-1 - degree] the end.

    Raises:
        InputError: a wrong shape, too few control points, knots that decrease or lie more than `degree` times at an
            inner place.

    Reference: de Boor, A Practical Guide to Splines, ch. IX.
    """
    p = whole("degree", degree, 1, MOST_DEGREE)
    control = require_finite("control_points", real_array("control_points", control_points))
    control = control[:, None] if control.ndim == 1 else control
    if control.ndim < 2 or control.shape[-2] <= p:
        expected = f"(*batch, k, n), k > {p}"
        raise InputError("input.shape", name="control_points", expected=expected, got=control.shape, hint="")
    T, k = positive("duration", duration), control.shape[-2]
    if isinstance(knots, str):
        if knots not in ("clamped", "uniform"):
            raise InputError("input.choice", name="knots", value=knots, known="clamped, uniform")
        inner = np.linspace(0.0, T, k - p + 1)
        beyond = p * T / (k - p) if knots == "uniform" else 0.0
        ends = np.linspace(beyond / p, beyond, p)
        t = np.concatenate([-ends[::-1], inner, T + ends])
    else:
        t = _own_knots(require_finite("knots", real_array("knots", knots)), k, p, T)
    return BSpline(frozen(t), frozen(np.moveaxis(control, -2, 0)), p)


def _own_knots(t: Floats, k: int, p: int, T: float) -> Floats:
    """Knots as given, from 0 to T."""
    if t.shape != (k + p + 1,):
        raise InputError("input.shape", name="knots", expected=(k + p + 1,), got=t.shape, hint="")
    wrong = (np.diff(t) < 0.0).any() or t[p] >= t[k] or (t[p + 1 : -1] <= t[1 : -1 - p]).any()
    if wrong or abs(t[k] - t[p] - T) > GIVEN * T:
        raise InputError("trajectory.knots", degree=p)
    return t - t[p]


def bspline_through(
    points: ArrayLike,
    durations: ArrayLike,
    *,
    degree: int = 5,
    start_derivatives: Sequence[ArrayLike] | None = None,
    goal_derivatives: Sequence[ArrayLike] | None = None,
) -> BSpline:
    """The B-spline through points at their times, degree - 1 times continuously differentiable.

    Odd degrees have their knots at the points and (degree - 1)/2 derivatives given at each end. Of all motions through
    the points with these ends that of degree 3 has the least integral of squared acceleration, 5 of jerk, 7 of snap.
    Even degrees, without derivatives, have their knots at means of the times and free ends.

    Args:
        points: (*batch, k + 1, n) [rad | m]; (k + 1,) is one coordinate.
        durations: (k,) times from point to point, or one number for all [s].
        degree: of its pieces, from 1 on; an even one needs more points than its number.
        start_derivatives, goal_derivatives: velocity, acceleration, ... of odd degrees, each a number or (*batch, n);
            those that are not given are zero.

    Raises:
        InputError: a wrong shape, a number that is not finite, a duration that is not positive, too few points,
            too many derivatives.

    Work and memory grow with k.

    Reference: de Boor, A Practical Guide to Splines, ch. XIII; Kyriakopoulos and Saridis, Minimum jerk path generation,
    ICRA 1988.
    """
    u, h = points_and_durations(points, durations)
    p = whole("degree", degree, 1, MOST_DEGREE)
    t = np.concatenate([[0.0], np.cumsum(h)])
    each = (p - 1) // 2 if p % 2 else 0
    given = [
        _derivatives(name, values, each, u[0].shape)
        for name, values in (("start_derivatives", start_derivatives), ("goal_derivatives", goal_derivatives))
    ]
    if p % 2:
        inner = t[1:-1]
    else:
        if len(t) <= p:
            raise InputError("trajectory.few_points", count=len(t), degree=p, least=p + 1)
        inner = np.array([t[j : j + p].mean() for j in range(1, len(t) - p)])
    knots = np.concatenate([np.zeros(p + 1), inner, np.full(p + 1, t[-1])])
    points_first, basis = _basis_at(knots, p, t)
    # Derivatives over shares of the legs at the ends: rows of one size.
    start, goal = (_end_rows(knots, p, *end, each) for end in ((0, h[0]), (-1, h[-1])))
    N, order = len(knots) - p - 1, np.arange(1, each + 1)
    row = np.concatenate([[0], np.arange(each + 1, N - each - 1), [N - 1], order, N - 1 - order])
    first = np.concatenate([points_first, np.zeros(each, np.intp), np.full(each, N - p - 1)])
    bands, column = np.zeros((2 * p + 1, N)), first[:, None] + np.arange(p + 1)
    bands[p + row[:, None] - column, column] = np.concatenate([basis.T, start, goal])
    right = np.empty((N, u[0].size))
    wanted = [size**k * value for size, side in zip(h[[0, -1]], given, strict=True) for k, value in enumerate(side, 1)]
    right[row] = np.concatenate([u, wanted] if wanted else [u]).reshape(N, -1)
    control = solve_banded(bands, right)
    if not np.isfinite(control).all():
        raise InputError("trajectory.overflow", duration=float(t[-1]))
    return BSpline(frozen(knots), frozen(control.reshape(-1, *u.shape[1:])), p)


def _end_rows(knots: Floats, p: int, end: int, size: float, orders: int) -> Floats:
    """(orders, p + 1) derivatives of order 1, 2, ... of the basis functions at an end, times size^order.

    Args:
        knots: clamped at both ends.
        p: degree.
        end: 0 for the start, -1 for the goal.
        size: length of the leg there [s].
        orders: how many derivatives.
    """
    t = knots[: 2 * p + 2] if end == 0 else knots[-2 * p - 2 :]
    rows, control = np.empty((orders, p + 1)), np.eye(p + 1)
    for k in range(orders):
        control, t = _slope_of(control, t, p - k), t[1:-1]
        rows[k] = size ** (k + 1) * control[end]  # At an end whose knots are repeated the first is the value.
    return rows


def _slope_of(control: Floats, t: Floats, p: int) -> Floats:
    """(k - 1, ...) control points of the derivative, on the knots but the first and the last."""
    spans = (t[p + 1 : -1] - t[1 : -1 - p]).reshape((-1,) + (1,) * (control.ndim - 1))
    return p * np.diff(control, axis=0) / spans


def minimum_jerk_through(points: ArrayLike, durations: ArrayLike, **ends: Sequence[ArrayLike]) -> BSpline:
    """The motion of least integrated squared jerk through points, velocity and acceleration given at both ends.

    Args:
        points: (*batch, k + 1, n) [rad | m].
        durations: (k,) or one number [s].
        ends: `start_derivatives`, `goal_derivatives`: velocity, acceleration; zero if not given.
    """
    return bspline_through(points, durations, degree=5, **ends)


def minimum_snap_through(points: ArrayLike, durations: ArrayLike, **ends: Sequence[ArrayLike]) -> BSpline:
    """The motion of least integrated squared snap through points, derivatives one to three given at both ends.

    Args:
        points: (*batch, k + 1, n) [rad | m].
        durations: (k,) or one number [s].
        ends: `start_derivatives`, `goal_derivatives`: velocity, acceleration, jerk; zero if not given.
    """
    return bspline_through(points, durations, degree=7, **ends)


def _derivatives(name: str, values: Sequence[ArrayLike] | None, most: int, shape: tuple[int, ...]) -> list[Floats]:
    """`most` derivatives at an end, what is not given zero."""
    given = [] if values is None else list(values)
    if len(given) > most:
        raise InputError("trajectory.many_derivatives", name=name, count=len(given), most=most)
    found: list[Floats] = []
    for value in [*given, *[0.0] * (most - len(given))]:
        array = require_finite(name, real_array(name, value))
        if array.shape not in ((), shape[-1:], shape):
            raise InputError("input.shape", name=name, expected=shape, got=array.shape, hint="")
        found.append(np.broadcast_to(array, shape))
    return found
