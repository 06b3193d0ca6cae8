"""Trapezoidal velocity (linear with parabolic blends), all joints starting and stopping together."""

from __future__ import annotations

from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, calculable, positive, real_array, require_finite
from mafsil.errors import InputError
from mafsil.solvers import Outcome
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial
from mafsil.trajectory.status import PlanStatus
from mafsil.trajectory.tolerances import ROUNDING

Synchronisation = Literal["time", "phase"]


def trapezoid(
    start: ArrayLike,
    goal: ArrayLike,
    *,
    acceleration: ArrayLike,
    velocity: ArrayLike = np.inf,
    duration: float | None = None,
    synchronise: Synchronisation = "time",
) -> Outcome[PiecewisePolynomial]:
    """From rest to rest with parabolic blends; a triangle where the top speed is not reached.

    T   = |D|/V + V/A  if |D| > V^2/A, else 2 sqrt(|D|/A);  the slowest joint rules
    t_b = T/2 - sqrt(T^2/4 - |D|/A)

    Args:
        start, goal: (n,) positions [rad | m].
        acceleration: (n,) or one number, largest magnitude A [rad/s^2 | m/s^2].
        velocity: (n,) or one number, largest magnitude V [rad/s | m/s]; may be infinite.
        duration: T [s]; the shortest possible if None.
        synchronise: `time`: every joint blends with its full acceleration; `phase`: all joints share one time law,
            so that the motion is a straight line in joint space.

    Returns:
        The trajectory. If `duration` is too short the status is TOO_SHORT, its details name the joint and the shortest
        duration, and the value is the trajectory of that duration.

    Raises:
        InputError: a wrong shape, a number that is not finite, a limit that is not positive.

    Reference: Craig, Introduction to Robotics, sec. 7.3; Biagiotti and Melchiorri, Trajectory Planning, sec. 3.2.
    """
    u0, uf, speed, growth = _arguments(start, goal, velocity, acceleration)
    if synchronise not in ("time", "phase"):
        raise InputError("input.choice", name="synchronise", value=synchronise, known="time, phase")
    distance = np.abs(uf - u0)
    each = shortest_duration(distance, speed, growth)
    slowest = int(np.argmax(each)) if each.size else 0
    if synchronise == "phase":
        speed, growth = _shared_law(distance, speed, growth)
        each = shortest_duration(distance, speed, growth)
    shortest = float(each.max(initial=0.0))
    if duration is None:
        return Outcome(_blend(u0, uf, growth, shortest), PlanStatus.PLANNED, details={"duration": shortest})
    requested = positive("duration", duration)
    # The shortest duration, printed and given back, must not be refused for its last digit.
    if requested < shortest * (1.0 - ROUNDING):
        details = {"joint": slowest, "duration": requested, "shortest": shortest}
        return Outcome(_blend(u0, uf, growth, shortest), PlanStatus.TOO_SHORT, shortest - requested, details=details)
    return Outcome(_blend(u0, uf, growth, requested), PlanStatus.PLANNED, details={"duration": requested})


def shortest_duration(distance: Floats, velocity: Floats, acceleration: Floats) -> Floats:
    """Shortest time from rest to rest, elementwise [s].

    Args:
        distance: >= 0 [rad | m].
        velocity, acceleration: largest magnitudes; the velocity may be infinite.
    """
    triangle = 2.0 * np.sqrt(distance / acceleration)
    cruising = distance * acceleration > velocity**2
    top = np.where(cruising, velocity, 1.0)
    return np.where(cruising, distance / top + top / acceleration, triangle)


def _arguments(start: ArrayLike, goal: ArrayLike, velocity: ArrayLike, acceleration: ArrayLike) -> list[Floats]:
    u0 = require_finite("start", np.atleast_1d(real_array("start", start)))
    uf = require_finite("goal", real_array("goal", goal))
    V, A = real_array("velocity", velocity), real_array("acceleration", acceleration)
    if u0.ndim != 1:
        raise InputError("input.shape", name="start", expected="(n,)", got=u0.shape, hint="")
    for name, array in (("goal", uf), ("velocity", V), ("acceleration", A)):
        if array.shape not in ((), u0.shape):
            raise InputError("input.shape", name=name, expected=u0.shape, got=array.shape, hint="")
    for name, array in (("velocity", V), ("acceleration", require_finite("acceleration", A))):
        if not (array > 0.0).all():
            raise InputError("input.positive", name=name, value=array[~(array > 0.0)].flat[0] if array.ndim else array)
        calculable(name, array)
    return [np.broadcast_to(array, u0.shape) for array in (u0, uf, V, A)]


def _shared_law(distance: Floats, velocity: Floats, acceleration: Floats) -> tuple[Floats, Floats]:
    """The limits of each joint when all follow u0 + s (uf - u0) with one s(t)."""
    moving = distance > 0.0
    if not moving.any():
        return velocity, acceleration
    rate = (velocity[moving] / distance[moving]).min()
    growth = (acceleration[moving] / distance[moving]).min()
    return np.where(moving, rate * distance, velocity), np.where(moving, growth * distance, acceleration)


def _blend(u0: Floats, uf: Floats, acceleration: Floats, T: float) -> PiecewisePolynomial:
    """All joints on the knots of all blends."""
    signed = np.copysign(acceleration, uf - u0)
    blend = T / 2 - np.sqrt(np.maximum(T / 2 * (T / 2) - np.abs(uf - u0) / acceleration, 0.0))
    knots = np.unique(np.concatenate([[0.0, T], blend, T - blend]))
    if len(knots) == 1:
        return PiecewisePolynomial.from_pieces([0.0], u0[None, None])
    pieces = [_piece(u0, uf, signed, blend, T, a, b) for a, b in pairwise(knots)]
    return PiecewisePolynomial.from_pieces(np.diff(knots), pieces)


def _piece(u0: Floats, uf: Floats, A: Floats, blend: Floats, T: float, begin: float, end: float) -> Floats:
    """(3, n) ascending coefficients between two knots; each joint is in its first blend, straight part or last."""
    middle = (begin + end) / 2
    left = T - begin
    first = np.stack([u0 + A * begin**2 / 2, A * begin, A / 2])
    straight = np.stack([u0 + A * blend * (begin - blend / 2), A * blend, np.zeros_like(A)])
    last = np.stack([uf - A * left**2 / 2, A * left, -A / 2])
    return np.where(middle < blend, first, np.where(middle <= T - blend, straight, last))
