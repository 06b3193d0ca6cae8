"""Cubic and quintic polynomials between boundary conditions, and rest."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Advice, Floats, positive, real_array, require_finite
from mafsil.errors import InputError
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial


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
    """Standing still at `position` (*batch, n) for `duration` [s]."""
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
