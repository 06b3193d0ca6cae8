"""Cubics through via points: velocities there given, by a rule, or such that the acceleration is continuous.

Points with durations between them, as users give them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, positive, real_array, require_finite
from mafsil.errors import InputError
from mafsil.lazy_module import lazily
from mafsil.trajectory.profiles.polynomial import cubic_coefficients
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial
from mafsil.trajectory.tolerances import GIVEN

if TYPE_CHECKING:
    import mafsil.solvers.cholesky_loops as cholesky_loops
else:
    cholesky_loops = lazily("mafsil.solvers.cholesky_loops")

ViaRule = Literal["continuous", "heuristic", "mean", "weighted_mean", "stop"]
SplineEnds = Literal["clamped", "natural", "periodic"]


def cubic_through(
    points: ArrayLike,
    durations: ArrayLike,
    *,
    velocities: ViaRule | ArrayLike = "continuous",
    start_velocity: ArrayLike = 0.0,
    goal_velocity: ArrayLike = 0.0,
    ends: SplineEnds = "clamped",
) -> PiecewisePolynomial:
    """Cubics through via points.

    continuous: h_k v_{k-1} + 2 (h_{k-1} + h_k) v_k + h_{k-1} v_{k+1} = 3 (h_k d_{k-1} + h_{k-1} d_k), d_k the slopes

    Args:
        points: (*batch, k + 1, n) positions, start and goal included [rad | m]; (k + 1,) is one coordinate.
        durations: (k,) times from point to point, or one number for all [s].
        velocities: at the via points: `continuous` acceleration (a spline), `heuristic` (the mean of the slopes on both
            sides, zero where they differ in sign), `mean` (of the slopes), `weighted_mean` (by the other side's
            duration: that of the parabola through three points), `stop`, or given values, (k - 1, n) or
            (*batch, k - 1, n) [rad/s | m/s], such as `via_rates(...).qd`.
        start_velocity, goal_velocity: (n,) or (*batch, n) at clamped ends [rad/s | m/s].
        ends: of a continuous spline: `clamped` has those velocities, `natural` no acceleration, `periodic` the same
            velocity and acceleration at both ends, which must be one point.

    Raises:
        InputError: a wrong shape, an unknown rule, a duration that is not positive, ends that do not meet.

    Reference: Craig, Introduction to Robotics, sec. 7.3; de Boor, A Practical Guide to Splines, ch. IV.
    """
    u, h = points_and_durations(points, durations)
    if ends not in ("clamped", "natural", "periodic"):
        raise InputError("input.choice", name="ends", value=ends, known="clamped, natural, periodic")
    moving = [
        _end(name, value, u[0].shape)
        for name, value in (("start_velocity", start_velocity), ("goal_velocity", goal_velocity))
    ]
    v = _velocities(u, h, velocities, moving, ends)
    pieces = [cubic_coefficients(u[i], u[i + 1], v[i], v[i + 1], float(h[i])) for i in range(len(h))]
    return PiecewisePolynomial.from_pieces(h, pieces)


def _end(name: str, value: ArrayLike, shape: tuple[int, ...]) -> Floats:
    """A velocity at an end, for all rows of a batch."""
    velocity = require_finite(name, real_array(name, value))
    if velocity.shape not in ((), shape[-1:], shape):
        raise InputError("input.shape", name=name, expected=shape, got=velocity.shape, hint="")
    return np.broadcast_to(velocity, shape)


def _velocities(u: Floats, h: Floats, rule: ViaRule | ArrayLike, moving: list[Floats], ends: SplineEnds) -> Floats:
    """(k + 1, *batch, n) velocities at all points."""
    if isinstance(rule, str) and rule == "continuous":
        return spline_velocities(u, h, ends, moving[0], moving[1])
    if ends != "clamped":
        raise InputError("trajectory.spline_ends", ends=ends)
    return np.concatenate([moving[0][None], _inner(u, h, rule), moving[1][None]])


def _inner(u: Floats, h: Floats, rule: ViaRule | ArrayLike) -> Floats:
    """(k - 1, *batch, n) velocities at the inner points by a rule, or as given."""
    if not isinstance(rule, str):
        given = require_finite("velocities", real_array("velocities", rule))
        inner = (*u.shape[1:-1], len(u) - 2, u.shape[-1])
        if given.shape not in (inner, inner[-2:]):
            raise InputError("input.shape", name="velocities", expected=inner, got=given.shape, hint="")
        return np.moveaxis(np.broadcast_to(given, inner), -2, 0)
    before, after = (x.reshape((-1,) + (1,) * (u.ndim - 1)) for x in (h[:-1], h[1:]))
    slopes = np.diff(u, axis=0) / h.reshape((-1,) + (1,) * (u.ndim - 1))
    left, right = slopes[:-1], slopes[1:]
    match rule:
        case "heuristic":
            return np.where(left * right <= 0.0, 0.0, (left + right) / 2)
        case "mean":
            return (left + right) / 2
        case "weighted_mean":
            return (after * left + before * right) / (before + after)
        case "stop":
            return np.zeros_like(left)
        case _:
            known = "continuous, heuristic, mean, weighted_mean, stop"
            raise InputError("input.choice", name="velocities", value=rule, known=known)


def spline_velocities(
    u: Floats, h: Floats, ends: SplineEnds, v0: Floats | None = None, vn: Floats | None = None
) -> Floats:
    """(k + 1, *batch, n) velocities with which the acceleration is continuous.

    Args:
        u: (k + 1, *batch, n) points.
        h: (k,) durations [s].
        ends: of the spline.
        v0, vn: (*batch, n) velocities of clamped ends.

    Raises:
        InputError: ends of a periodic spline that do not meet.
    """
    rows = u.reshape(len(u), -1)
    slopes = np.diff(rows, axis=0) / h[:, None]
    if ends == "periodic":
        gap = np.abs(rows[-1] - rows[0])
        if gap.max() > GIVEN * max(1.0, float(np.abs(rows).max())):
            raise InputError("trajectory.periodic", gap=float(gap.max()))
        return _periodic(slopes, h).reshape(u.shape)
    lower, diagonal, upper = np.zeros(len(u)), np.ones(len(u)), np.zeros(len(u))
    right = np.empty_like(rows)
    lower[1:-1], diagonal[1:-1], upper[1:-1] = h[1:], 2 * (h[:-1] + h[1:]), h[:-1]
    right[1:-1] = 3 * (h[1:, None] * slopes[:-1] + h[:-1, None] * slopes[1:])
    if ends == "clamped":
        assert v0 is not None
        assert vn is not None
        right[0], right[-1] = v0.ravel(), vn.ravel()
    else:
        diagonal[[0, -1]], upper[0], lower[-1] = 2.0, 1.0, 1.0
        right[0], right[-1] = 3 * slopes[0], 3 * slopes[-1]
    cholesky_loops.solve_tridiagonal(lower, diagonal, upper, right)
    return right.reshape(u.shape)


def _periodic(slopes: Floats, h: Floats) -> Floats:
    """(k + 1, m) velocities of the closed spline: a cyclic system, by Sherman and Morrison."""
    k = len(h)
    before = np.roll(h, 1)
    right = 3 * (h[:, None] * np.roll(slopes, 1, axis=0) + before[:, None] * slopes)
    if k <= 2:
        matrix = np.zeros((k, k))
        for i in range(k):
            matrix[i, i] += 2 * (before[i] + h[i])
            matrix[i, (i - 1) % k] += h[i]
            matrix[i, (i + 1) % k] += before[i]
        closed = np.asarray(np.linalg.solve(matrix, right), dtype=np.float64)
        return np.concatenate([closed, closed[:1]])
    lower, diagonal, upper = h.copy(), 2 * (before + h), before.copy()
    corner_first, corner_last = lower[0], upper[-1]
    gamma = -diagonal[0]
    diagonal[0] -= gamma
    diagonal[-1] -= corner_first * corner_last / gamma
    lower[0] = upper[-1] = 0.0
    bend = np.zeros((k, 1))
    bend[0], bend[-1] = gamma, corner_last
    both = np.concatenate([right, bend], axis=1)
    cholesky_loops.solve_tridiagonal(lower, diagonal, upper, both)
    y, z = both[:, :-1], both[:, -1:]
    share = (y[0] + corner_first / gamma * y[-1]) / (1.0 + z[0] + corner_first / gamma * z[-1])
    v = y - z * share
    return np.concatenate([v, v[:1]])


def points_and_durations(points: ArrayLike, durations: ArrayLike) -> tuple[Floats, Floats]:
    """(k + 1, *batch, n) points, the points first, and (k,) durations.

    Args:
        points: (*batch, k + 1, n), or (k + 1,) of one coordinate [rad | m].
        durations: (k,), or one number for all [s].

    Raises:
        InputError: a wrong shape, a number that is not finite, a duration that is not positive.
    """
    u = require_finite("points", real_array("points", points))
    u = u[:, None] if u.ndim == 1 else u
    h = require_finite("durations", real_array("durations", durations))
    if u.ndim < 2 or u.shape[-2] < 2 or u.shape[-1] < 1:
        raise InputError("input.shape", name="points", expected="(*batch, k + 1, n), k >= 1", got=u.shape, hint="")
    legs = (u.shape[-2] - 1,)
    if h.shape not in ((), legs):
        raise InputError("input.shape", name="durations", expected=legs, got=h.shape, hint="")
    for leg in np.atleast_1d(h):
        positive("durations", float(leg))
    return np.moveaxis(u, -2, 0), np.broadcast_to(h, legs).astype(np.float64)
