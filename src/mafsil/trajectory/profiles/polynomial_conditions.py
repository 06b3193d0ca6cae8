"""The polynomial of least degree that meets given conditions: values and derivatives at any times."""

from __future__ import annotations

from collections.abc import Iterable
from math import perm
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, positive, real_array, require_finite, whole
from mafsil.errors import InputError
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial
from mafsil.trajectory.tolerances import FEW_ROUNDINGS

Condition: TypeAlias = tuple[float, int, ArrayLike]
"""Time [s], order of the derivative (0 for the position), value (*batch, n)."""

MOST = 24
"""Conditions beyond these cannot be met by one polynomial in double precision; splines can."""


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
