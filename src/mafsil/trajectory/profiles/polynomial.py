"""Cubic and quintic polynomials between boundary conditions, and rest.

The polynomial of least degree that meets given conditions: values and derivatives at any times.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import perm
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Advice, Floats, positive, real_array, require_finite, whole
from mafsil.errors import InputError
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial
from mafsil.trajectory.tolerances import FEW_ROUNDINGS

Condition: TypeAlias = tuple[float, int, ArrayLike]
"""Time [s], order of the derivative (0 for the position), value (*batch, n)."""
MOST = 24
"""Conditions beyond these cannot be met by one polynomial in double precision; splines can."""


def cubic(
    start: ArrayLike,
    goal: ArrayLike,
    duration: float,
    *,
    start_velocity: ArrayLike = 0.0,
    goal_velocity: ArrayLike = 0.0,
) -> PiecewisePolynomial:
    """The cubic with given positions and velocities at both ends.

    u = u0 + v0 t + (3 (uf - u0)/T^2 - (2 v0 + vf)/T) t^2 + (-2 (uf - u0)/T^3 + (v0 + vf)/T^2) t^3

    Args:
        start, goal: (*batch, n) positions [rad | m]; a number is one coordinate.
        duration: T [s].
        start_velocity, goal_velocity: (*batch, n) [rad/s | m/s].

    Raises:
        InputError: a wrong shape, a number that is not finite, or a duration that is not positive.

    Reference: Craig, Introduction to Robotics, sec. 7.3.
    """
    u0, uf, v0, vf = _conditions(start=start, goal=goal, start_velocity=start_velocity, goal_velocity=goal_velocity)
    T = positive("duration", duration)
    return PiecewisePolynomial.from_pieces([T], cubic_coefficients(u0, uf, v0, vf, T)[None])


def quintic(
    start: ArrayLike,
    goal: ArrayLike,
    duration: float,
    *,
    start_velocity: ArrayLike = 0.0,
    goal_velocity: ArrayLike = 0.0,
    start_acceleration: ArrayLike = 0.0,
    goal_acceleration: ArrayLike = 0.0,
) -> PiecewisePolynomial:
    """The quintic with given positions, velocities and accelerations at both ends.

    Args:
        start, goal: (*batch, n) positions [rad | m]; a number is one coordinate.
        duration: T [s].
        start_velocity, goal_velocity: (*batch, n) [rad/s | m/s].
        start_acceleration, goal_acceleration: (*batch, n) [rad/s^2 | m/s^2].

    Raises:
        InputError: a wrong shape, a number that is not finite, or a duration that is not positive.

    Reference: Craig, Introduction to Robotics, eq. (7.18).
    """
    u0, uf, v0, vf, a0, af = _conditions(
        start=start,
        goal=goal,
        start_velocity=start_velocity,
        goal_velocity=goal_velocity,
        start_acceleration=start_acceleration,
        goal_acceleration=goal_acceleration,
    )
    T = positive("duration", duration)
    return PiecewisePolynomial.from_pieces([T], quintic_coefficients(u0, uf, v0, vf, a0, af, T)[None])


def rest(position: ArrayLike, duration: float) -> PiecewisePolynomial:
    """A rest at `position` (*batch, n) for `duration` [s]."""
    (u,) = _conditions(position=position)
    return PiecewisePolynomial.from_pieces([positive("duration", duration)], u[None, None])


def cubic_coefficients(u0: Floats, uf: Floats, v0: Floats, vf: Floats, T: float) -> Floats:
    """(4, *shape) ascending coefficients of the cubic with these end values.

    Args:
        u0, uf: positions at 0 and T.
        v0, vf: velocities.
        T: duration [s].
    """
    D = uf - u0
    return np.stack([u0, v0, 3 * D / T**2 - (2 * v0 + vf) / T, -2 * D / T**3 + (v0 + vf) / T**2])


def quintic_coefficients(u0: Floats, uf: Floats, v0: Floats, vf: Floats, a0: Floats, af: Floats, T: float) -> Floats:
    """(6, *shape) ascending coefficients of the quintic with these end values.

    Args:
        u0, uf: positions at 0 and T.
        v0, vf: velocities.
        a0, af: accelerations.
        T: duration [s].
    """
    D = uf - u0
    return np.stack(
        [
            u0,
            v0,
            a0 / 2,
            (20 * D - (8 * vf + 12 * v0) * T - (3 * a0 - af) * T**2) / (2 * T**3),
            (-30 * D + (14 * vf + 16 * v0) * T + (3 * a0 - 2 * af) * T**2) / (2 * T**4),
            (12 * D - 6 * (vf + v0) * T - (a0 - af) * T**2) / (2 * T**5),
        ]
    )


def _conditions(**values: ArrayLike) -> list[Floats]:
    """All end values as finite arrays of one shape (*batch, n); plain numbers stand for every coordinate.

    Rows of coordinates must be of one length: a goal of one coordinate is not that of two.
    """
    arrays = [require_finite(name, real_array(name, value)) for name, value in values.items()]
    first = next((array for array in arrays if array.ndim), np.zeros(1))
    for name, array in zip(values, arrays, strict=True):
        if array.ndim and array.shape[-1] != first.shape[-1]:
            expected, advice = f"(*batch, {first.shape[-1]})", Advice(first.shape[-1:], array.shape)
            raise InputError("input.shape", name=name, expected=expected, got=array.shape, hint=advice)
    arrays = [np.atleast_1d(array) for array in arrays]
    shape = arrays[0].shape
    for name, array in zip(values, arrays, strict=True):
        try:
            shape = np.broadcast_shapes(shape, array.shape)
        except ValueError:
            raise InputError("input.shape", name=name, expected=shape, got=array.shape, hint="") from None
    return [np.broadcast_to(array, shape) for array in arrays]


def polynomial(conditions: Iterable[Condition]) -> PiecewisePolynomial:
    """The polynomial of degree k - 1 through k conditions: u, du/dt, ... at the start, the end and times between.

    [(0, 0, u0), (0, 1, v0), (T, 0, uf), (T, 1, vf)] is a cubic, with accelerations at both ends a quintic; an inner
    position makes it a degree higher.

    Args:
        conditions: (time, order, value) each; times from 0 on, the largest is the duration; the value (*batch, n), or a
            number for one coordinate.

    Returns:
        One piece, from 0 to the largest time.

    Raises:
        InputError: conditions that contradict or repeat one another or leave the polynomial open, more than 24, a time
            that is not finite or negative, no duration.

    Reference: Biagiotti and Melchiorri, Trajectory Planning for Automatic Machines and Robots, sec. 2.1.
    """
    rows = list(conditions)
    if not 1 < len(rows) <= MOST:
        raise InputError("trajectory.conditions_count", count=len(rows), most=MOST)
    moments = [float(require_finite("time", real_array("time", row[0]))) for row in rows]
    orders = [whole("order", row[1]) for row in rows]
    values = [np.atleast_1d(require_finite("value", real_array("value", row[2]))) for row in rows]
    T = positive("duration", max(moments))
    if min(moments) < 0.0:
        raise InputError("input.range", name="time", value=min(moments), low=0.0, high=np.inf)
    try:
        right = np.stack(np.broadcast_arrays(*values))
    except ValueError:
        shapes = next(value.shape for value in values if value.shape != values[0].shape)
        raise InputError("input.shape", name="value", expected=values[0].shape, got=shapes, hint="") from None
    # Over x = t/T, and each row over its largest element: conditions of all orders are of one size.
    matrix = np.array([_row(t / T, order, len(rows)) for t, order in zip(moments, orders, strict=True)])
    size = np.abs(matrix).max(axis=1)
    if not size.all() or _determine(matrix / size[:, None]) < FEW_ROUNDINGS:
        raise InputError("trajectory.conditions_open", count=len(rows))
    scaled = right.reshape(len(rows), -1) * (np.power(T, np.array(orders, dtype=np.float64)) / size)[:, None]
    found = np.asarray(np.linalg.solve(matrix / size[:, None], scaled), dtype=np.float64)
    c = found.reshape(right.shape)
    return PiecewisePolynomial.from_pieces([T], (c / _powers(T, c))[None])


def septic(
    start: ArrayLike,
    goal: ArrayLike,
    duration: float,
    *,
    start_derivatives: tuple[ArrayLike, ArrayLike, ArrayLike] = (0.0, 0.0, 0.0),
    goal_derivatives: tuple[ArrayLike, ArrayLike, ArrayLike] = (0.0, 0.0, 0.0),
) -> PiecewisePolynomial:
    """The polynomial of degree seven with given position, velocity, acceleration and jerk at both ends.

    Args:
        start, goal: (*batch, n) positions [rad | m]; a number is one coordinate.
        duration: T [s].
        start_derivatives, goal_derivatives: velocity, acceleration, jerk, each (*batch, n) or a number.

    Raises:
        InputError: a wrong shape, a number that is not finite, a duration that is not positive.
    """
    T = positive("duration", duration)
    ends = ((0.0, (start, *start_derivatives)), (T, (goal, *goal_derivatives)))
    return polynomial([(t, order, value) for t, row in ends for order, value in enumerate(row)])


def _row(x: float, order: int, count: int) -> Floats:
    """(count,) derivatives of the powers of x."""
    return np.array([perm(k, order) * x ** (k - order) if k >= order else 0.0 for k in range(count)])


def _determine(matrix: Floats) -> float:
    """Smallest over largest singular value, rows and columns of one size."""
    size = np.abs(matrix).max(axis=0)
    if not size.all():
        return 0.0
    values = np.linalg.svd(matrix / size, compute_uv=False)
    return float(values[-1] / values[0])


def _powers(T: float, c: Floats) -> Floats:
    """T^k for each coefficient."""
    return np.power(T, np.arange(len(c), dtype=np.float64)).reshape((-1,) + (1,) * (c.ndim - 1))
