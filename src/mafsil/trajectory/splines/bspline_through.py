"""B-splines through points, among them those of least jerk and of least snap."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, frozen, real_array, require_finite, whole
from mafsil.errors import InputError
from mafsil.trajectory.splines.bspline import MOST_DEGREE, BSpline
from mafsil.trajectory.splines.cubic_spline import points_and_durations


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

    The system is solved as a dense one: work (k + degree)^3, memory (k + degree)^2.

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
    basis = BSpline(knots, np.eye(len(knots) - p - 1), p)
    # Derivatives over shares of the legs at the ends: rows of one size.
    rows, right = [basis.value(t)], [u.reshape(len(u), -1)]
    for moment, size, values in ((0.0, h[0], given[0]), (t[-1], h[-1], given[1])):
        for order, value in enumerate(values, start=1):
            rows.append(size**order * basis.derivative(order).value(np.array([moment])))
            right.append(size**order * value.reshape(1, -1))
    control = np.linalg.solve(np.concatenate(rows), np.concatenate(right))
    return BSpline(frozen(knots), frozen(control.reshape(-1, *u.shape[1:])), p)


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
