"""From rest to rest within limits: trapezoidal velocity (parabolic blends), double S (constant jerk), several axes."""

from __future__ import annotations

from collections.abc import Sequence as Several
from dataclasses import dataclass
from itertools import pairwise
from math import factorial
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, calculable, positive, real_array, require_finite, require_kind
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.solvers import Outcome
from mafsil.trajectory.motion import Motion, PlanStatus, Printed, Stretchable, Trajectory, times
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial
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
    u0, uf, speed, growth = _rest_to_rest(
        start, goal, synchronise, "acceleration", velocity=velocity, acceleration=acceleration
    )
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


SIGNS = np.array([1.0, 0.0, -1.0, 0.0, -1.0, 0.0, 1.0])
"""Of the jerk in the seven parts."""


def double_s(
    start: ArrayLike,
    goal: ArrayLike,
    *,
    velocity: ArrayLike = np.inf,
    acceleration: ArrayLike = np.inf,
    jerk: ArrayLike,
    duration: float | None = None,
    synchronise: Synchronisation = "time",
) -> Outcome[PiecewisePolynomial]:
    """From rest to rest with limited jerk: seven parts, mirrored in the middle; fewer where a limit is not reached.

    T_j = A/J,       T_a = T_j + V/A                           if V J >= A^2
    T_j = sqrt(V/J), T_a = 2 T_j                               else
    T   = |D|/V + T_a                                          if |D| >= V T_a, so that V is reached; else
    T_j = A/J,       T_a = T_j/2 + sqrt(T_j^2/4 + |D|/A)       if |D| >= 2 A^3/J^2
    T_j = cbrt(|D|/(2 J)), T_a = 2 T_j                         else;  T = 2 T_a

    Args:
        start, goal: (n,) positions [rad | m]; a number is one coordinate.
        velocity, acceleration: (n,) or one number, largest magnitudes V, A; may be infinite.
        jerk: (n,) or one number, largest magnitude J [rad/s^3 | m/s^3].
        duration: T [s]; the shortest possible if None. A longer one slows the shortest motion as a whole.
        synchronise: `time`: every coordinate has its own shortest motion, slowed to the slowest; `phase`: all share one
            law, so that the motion is a straight line.

    Returns:
        The trajectory. If `duration` is too short the status is TOO_SHORT, its details name the coordinate and the
        shortest duration, and the value is the trajectory of that duration.

    Raises:
        InputError: a wrong shape, a number that is not finite, a limit that is not positive, an infinite jerk.

    Reference: Biagiotti and Melchiorri, Trajectory Planning for Automatic Machines and Robots, sec. 3.4.2.
    """
    u0, uf, V, A, J = _rest_to_rest(
        start, goal, synchronise, "jerk", velocity=velocity, acceleration=acceleration, jerk=jerk
    )
    if not len(u0):
        raise InputError("input.shape", name="start", expected="(n,)", got=u0.shape, hint="")
    way = np.abs(uf - u0)
    if synchronise == "phase" and (way > 0.0).any():
        with np.errstate(over="ignore"):
            shared = [float((x[way > 0.0] / way[way > 0.0]).min()) for x in (V, A, J)]
        parts = [_parts(float(D > 0.0), *shared) for D in way]
    else:
        parts = [_parts(*map(float, row)) for row in zip(way, V, A, J, strict=True)]
    lengths = [float(part.sum()) for part in parts]
    slowest = int(np.argmax(lengths))
    shortest = lengths[slowest]
    requested = shortest if duration is None else positive("duration", duration)
    details: dict[str, object] = {"joint": slowest, "duration": requested, "shortest": shortest}
    # The shortest duration, printed and given back, must not be refused for its last digit.
    fits = requested >= shortest * (1.0 - ROUNDING)
    total = requested if fits else shortest
    columns = [_column(*row, total) for row in zip(u0, uf, parts, strict=True)]
    status = PlanStatus.PLANNED if fits else PlanStatus.TOO_SHORT
    return Outcome(on_common_knots(columns), status, max(shortest - requested, 0.0), details=details)


def _parts(D: float, V: float, A: float, J: float) -> Floats:
    """(7,) durations of the shortest motion over D >= 0."""
    if D == 0.0:
        return np.zeros(7)
    reached = V * J >= A * A
    t_j = A / J if reached else np.sqrt(V / J)
    t_a = t_j + V / A if reached else 2.0 * t_j
    cruise = 0.0
    if np.isfinite(t_a) and D >= V * t_a:
        cruise = D / V - t_a
    elif D * (J / A) * (J / A) >= 2.0 * A:
        t_j = A / J
        t_a = t_j / 2.0 + np.sqrt(t_j * t_j / 4.0 + D / A)
    else:
        t_j = np.cbrt(D / (2.0 * J))
        t_a = 2.0 * t_j
    constant = max(t_a - 2.0 * t_j, 0.0)
    return np.array([t_j, constant, t_j, cruise, t_j, constant, t_j])


def _column(u0: float, uf: float, parts: Floats, total: float) -> PiecewisePolynomial:
    """One coordinate, its shortest motion slowed to `total`; the jerk is what makes it arrive."""
    if not parts.any():
        return PiecewisePolynomial.from_pieces([total], np.full((1, 1, 1), u0))
    lengths = parts * (total / parts.sum())
    t_j, constant, cruise = lengths[0], lengths[1], lengths[3]
    t_a = 2.0 * t_j + constant
    jerk = (uf - u0) / (t_j * (t_j + constant) * (t_a + cruise))
    kept = lengths > 0.0
    pieces: list[list[float]] = []
    state = np.array([u0, 0.0, 0.0])
    for length, sign in zip(lengths[kept], SIGNS[kept], strict=True):
        u, v, a = state
        j = sign * jerk
        pieces.append([u, v, a / 2, j / 6])
        state = np.array(
            [u + length * (v + length * (a / 2 + length * j / 6)), v + length * (a + length * j / 2), a + length * j]
        )
    return PiecewisePolynomial.from_pieces(lengths[kept], np.array(pieces)[..., None])


def _rest_to_rest(
    start: ArrayLike, goal: ArrayLike, synchronise: str, finite: str, **limits: ArrayLike
) -> list[Floats]:
    """Positions and limits, all (n,); the limit named `finite` may not be infinite."""
    u0 = require_finite("start", np.atleast_1d(real_array("start", start)))
    uf = require_finite("goal", real_array("goal", goal))
    bounds = {name: real_array(name, limit) for name, limit in limits.items()}
    if u0.ndim != 1:
        raise InputError("input.shape", name="start", expected="(n,)", got=u0.shape, hint="")
    for name, array in {"goal": uf, **bounds}.items():
        if array.shape not in ((), u0.shape):
            raise InputError("input.shape", name=name, expected=u0.shape, got=array.shape, hint="")
    require_finite(finite, bounds[finite])
    for name, array in bounds.items():
        wrong = ~(array > 0.0)
        if wrong.any():
            raise InputError("input.positive", name=name, value=array[wrong].flat[0])
        calculable(name, array)
    if synchronise not in get_args(Synchronisation):
        raise InputError("input.choice", name="synchronise", value=synchronise, known="time, phase")
    return [np.broadcast_to(array, u0.shape) for array in (u0, uf, *bounds.values())]


@dataclass(frozen=True, eq=False, repr=False)
class SideBySide(Printed):
    """The coordinates of several trajectories, one after the other; what ends earlier rests at its end.

    Attributes:
        parts: trajectories without batch dimensions.
    """

    parts: tuple[Trajectory, ...]

    @property
    def duration(self) -> float:
        """Length in time, of the longest [s]."""
        return max(part.duration for part in self.parts)

    @property
    def n(self) -> int:
        """Number of coordinates of all together."""
        return sum(part.n for part in self.parts)

    def breaks(self) -> Floats:
        """Times between which all are smooth [s]."""
        return np.unique(np.concatenate([part.breaks() for part in self.parts]))

    def at(self, t: ArrayLike) -> Motion:
        """Position, velocity and acceleration at the times `t` (*times) [s]; at rest outside 0 .. duration."""
        moment = times(t)
        found = [part.at(moment) for part in self.parts]
        u, v, a = (np.concatenate([each[order] for each in found], axis=-1) for order in range(3))
        return Motion(u, v, a)

    def jerk(self, t: ArrayLike) -> Floats:
        """(*times, n) third derivative at the times `t` [rad/s^3 | m/s^3]."""
        moment = times(t)
        return np.concatenate([part.jerk(moment) for part in self.parts], axis=-1)

    def scale_time(self, factor: float) -> SideBySide:
        """The same path, `factor` times as slow; all parts must be of a kind that can be."""
        return SideBySide(tuple(part.scale_time(factor) for part in self.parts if isinstance(part, Stretchable)))


def synchronise_axes(*parts: Stretchable) -> SideBySide:
    """Axes that start and arrive together: each is slowed as a whole to the slowest of them.

    Args:
        parts: at least one trajectory, such as the shortest of each axis under its limits.

    Raises:
        InputError: no part, or one that cannot be slowed.
    """
    if not parts:
        raise InputError("trajectory.no_parts")
    for k, part in enumerate(parts):
        require_kind(f"parts[{k}]", part, "Trajectory", "duration", "at", "scale_time")
    longest = max(part.duration for part in parts)
    return SideBySide(tuple(part.scale_time(longest / part.duration) if part.duration else part for part in parts))


def on_common_knots(columns: Several[PiecewisePolynomial]) -> PiecewisePolynomial:
    """Piecewise polynomials of equal duration and any degrees as one, on the knots of all.

    Args:
        columns: without batch dimensions; their coordinates follow one another.
    """
    degree = max(column.degree for column in columns)
    knots = np.unique(np.concatenate([column.knots for column in columns]))
    lengths = np.diff(knots)
    # Knots that differ by rounding alone are one.
    kept = np.concatenate([[True], lengths > 4e-15 * max(float(knots[-1]), LEAST_DIVISOR)])
    knots = knots[kept]
    if len(knots) < 2:
        return PiecewisePolynomial.from_pieces([0.0], np.concatenate([c.coefficients[:1, :1] for c in columns], -1))
    rows = [_on_knots(column, knots, degree) for column in columns]
    return PiecewisePolynomial.from_pieces(np.diff(knots), np.concatenate(rows, axis=-1))


def _on_knots(column: PiecewisePolynomial, knots: Floats, degree: int) -> Floats:
    """(pieces, degree + 1, n) ascending coefficients at the starts of finer pieces, each of the piece it lies in."""
    return np.stack(
        [
            column.derivative(knots[:-1], order, within=(knots[:-1] + knots[1:]) / 2) / factorial(order)
            for order in range(degree + 1)
        ],
        axis=1,
    )
