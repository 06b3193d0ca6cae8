"""Polynomials of least degree that meet conditions at their ends or at any times, rest, trajectories in sequence."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import perm
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import (
    Advice,
    Floats,
    frozen,
    not_negative,
    positive,
    real_array,
    require_finite,
    require_kind,
    spread,
    whole,
)
from mafsil.errors import InputError
from mafsil.trajectory.motion import Motion, Printed, Trajectory, moving_at, times
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


def cubic_coefficients(u0: Floats, uf: Floats, v0: Floats, vf: Floats, T: float | Floats) -> Floats:
    """(4, *shape) ascending coefficients of the cubic with these end values.

    Args:
        u0, uf: positions at 0 and T.
        v0, vf: velocities.
        T: duration, of all or of each [s].
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


@dataclass(frozen=True, eq=False, repr=False)
class Sequence(Printed):
    """Parts one after the other.

    Attributes:
        parts: (k) trajectories of equal n, each starting where the one before ends.
        starts: (k + 1,) their starting times, and the end [s].
    """

    parts: tuple[Trajectory, ...]
    starts: Floats

    @property
    def duration(self) -> float:
        """Length in time [s]."""
        return float(self.starts[-1])

    @property
    def n(self) -> int:
        """Number of coordinates."""
        return self.parts[0].n

    def breaks(self) -> Floats:
        """Times between which the motion is smooth [s]."""
        return np.unique(
            np.concatenate([start + part.breaks() for start, part in zip(self.starts[:-1], self.parts, strict=True)])
        )

    def at(self, t: ArrayLike) -> Motion:
        """Position, velocity and acceleration at the times `t` (*times) [s]; at rest outside 0 .. duration."""
        moment = times(t)
        which = self._locate(moment)
        if moment.ndim == 0:
            return self._at_one(moment, int(which))
        present: list[int] = np.unique(which).tolist()
        if len(present) == 1:
            out = self.parts[present[0]].at(self._local(moment, present[0]))
        else:
            shape = moment.shape + self.parts[0].at(0.0).u.shape
            out = Motion(*(np.zeros(shape) for _ in range(3)))
            for k in present:
                here = which == k
                values = self.parts[k].at(self._local(moment[here], k))
                for whole, value in zip(out, values, strict=True):
                    whole[here] = value
        moving = moving_at(moment, self.duration, out.u.ndim - moment.ndim)
        return Motion(out.u, out.v * moving, out.a * moving)

    def _at_one(self, moment: Floats, k: int) -> Motion:
        """At one time, which lies in part k: laws of the tip ask so in each tick."""
        u, v, a = self.parts[k].at(self._local(moment, k))
        moving = moving_at(moment, self.duration, u.ndim)
        return Motion(u, v * moving, a * moving)

    def jerk(self, t: ArrayLike) -> Floats:
        """(*times, *batch, n) third derivative at the times `t` [rad/s^3 | m/s^3]; zero outside 0 .. duration."""
        moment = times(t)
        which = self._locate(moment)
        out = np.zeros(moment.shape + self.parts[0].at(0.0).u.shape)
        present: list[int] = np.unique(which).tolist()
        for k in present:
            here = which == k
            out[here] = self.parts[k].jerk(self._local(moment[here], k))
        return out * moving_at(moment, self.duration, out.ndim - moment.ndim)

    def _locate(self, t: Floats) -> NDArray[np.intp]:
        return np.clip(np.searchsorted(self.starts, t, side="right") - 1, 0, len(self.parts) - 1)

    def _local(self, t: Floats, k: int) -> Floats:
        """Time since the start of part k, never beyond its ends by rounding."""
        return np.clip(t - self.starts[k], 0.0, self.parts[k].duration)


def sequence(*parts: Trajectory, rests: float | tuple[float, ...] = 0.0, tolerance: float = 1e-6) -> Sequence:
    """Join trajectories, resting between them.

    Args:
        parts: at least one; each must start where the one before ends.
        rests: pause after each part but the last, one number or (k - 1,) numbers [s].
        tolerance: largest gap between an end and the next start [rad | m].

    Raises:
        InputError: no part, parts of different widths, a gap, or a negative rest.
    """
    tolerance = not_negative("tolerance", tolerance)
    if not parts:
        raise InputError("trajectory.no_parts")
    for k, part in enumerate(parts):
        require_kind(f"parts[{k}]", part, "Trajectory", "duration", "at")
    pauses = spread("rests", rests, (len(parts) - 1,))
    if not (pauses >= 0.0).all():
        raise InputError("input.range", name="rests", value=pauses.min(), low=0.0, high=np.inf)
    joined: list[Trajectory] = []
    for k, part in enumerate(parts):
        if k:
            _require_meeting(joined[-1], part, k, tolerance)
            if pauses[k - 1] > 0.0:
                joined.append(rest(part.at(0.0).u, pauses[k - 1]))
        joined.append(part)
    ends = np.cumsum([part.duration for part in joined])
    return Sequence(tuple(joined), frozen(np.concatenate([[0.0], ends])))


def _require_meeting(before: Trajectory, after: Trajectory, index: int, tolerance: float) -> None:
    end, start = before.at(before.duration).u, after.at(0.0).u
    if end.shape != start.shape:
        raise InputError("input.shape", name=f"parts[{index}]", expected=end.shape, got=start.shape, hint="")
    gap = np.abs(end - start)
    if gap.max(initial=0.0) > tolerance:
        raise InputError(
            "trajectory.gap", index=index, joint=int(gap.argmax()) % before.n, gap=gap.max(), limit=tolerance
        )
