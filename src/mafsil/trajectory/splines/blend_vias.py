"""Points that blends pass exactly, between two pseudo via points, and points where they stop."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, positive, real_array, require_finite
from mafsil.errors import InputError
from mafsil.trajectory.splines.blend_plan import BlendProblem, blends
from mafsil.trajectory.tolerances import ROUNDING

ROUNDS = 200
"""Shortest times to pseudo via points are found by repeating: their blends change with them."""

Velocities = Mapping[int, ArrayLike | None]


def with_stops(
    problem: BlendProblem, stops: Mapping[int, float], through: Velocities | None
) -> tuple[BlendProblem, Velocities | None]:
    """Points repeated, so that the motion rests there; the indices of `through` follow.

    The leg between a point and its copy lasts for half of both blends, so that the motion rests for an instant, and the
    rest on top.

    Args:
        problem: with durations.
        stops: index of an inner point -> rest there [s].
        through: index of a point that is passed exactly -> velocity; a stop passes its point by itself.

    Raises:
        InputError: no inner point, or a rest that is negative.
    """
    for index in sorted(stops, reverse=True):
        _require_inner("stops", index, problem)
        rest = float(require_finite("stops", real_array("stops", stops[index])))
        if rest < 0.0:
            raise InputError("input.range", name="stops", value=rest, low=0.0, high=np.inf)
        points, down, up = (
            np.insert(each, index, each[..., index, :], axis=-2) for each in (problem.points, problem.down, problem.up)
        )
        durations = np.insert(problem.durations, index, 1.0)
        problem = BlendProblem(points, durations, down, up, problem.together)
        blend = blends(problem).blend[..., index : index + 2, :].sum(axis=-2) / 2
        durations[index] = float(np.nan_to_num(blend).max()) + rest
    if through is None:
        return problem, None
    return problem, {k + sum(index < k for index in stops): v for k, v in through.items() if k not in stops}


def with_through_points(problem: BlendProblem, through: Velocities, delta: float | None) -> BlendProblem:
    """Each point of `through` replaced by (T - delta, u - v delta) and (T + delta, u + v delta).

    Args:
        problem: with durations.
        through: index of an inner point -> (n,) velocity there [rad/s | m/s], or None for the mean of the slopes.
        delta: [s]; if None the shortest that holds the blends.

    Raises:
        InputError: no inner point, a wrong shape, a delta that is not positive or longer than the legs allow.
    """
    speeds = {index: _velocity(problem, index, through[index]) for index in sorted(through)}
    if delta is not None:
        return _replace(problem, speeds, {index: positive("delta", delta) for index in speeds})
    chosen = dict.fromkeys(speeds, 0.0)
    for _ in range(ROUNDS):
        candidate = _replace(problem, speeds, {k: max(each, 1e-9) for k, each in chosen.items()})
        blend = np.nan_to_num(blends(candidate).blend)
        needed = {
            index: float(blend[..., index + shift : index + shift + 2, :].max()) / 2
            for shift, index in enumerate(sorted(speeds))
        }
        if all(needed[k] <= chosen[k] * (1.0 + ROUNDING) for k in chosen):
            break
        chosen = {k: max(needed[k], chosen[k]) for k in chosen}
    return _replace(problem, speeds, {k: max(each, 1e-9) for k, each in chosen.items()})


def _velocity(problem: BlendProblem, index: int, velocity: ArrayLike | None) -> Floats:
    """(*batch, n) velocity in a point; the mean of the slopes beside it if None."""
    _require_inner("through", index, problem)
    u, h = problem.points, problem.durations
    if velocity is None:
        before, after = ((u[..., k + 1, :] - u[..., k, :]) / h[k] for k in (index - 1, index))
        return (before + after) / 2
    v = require_finite("through", real_array("through", velocity))
    if v.shape not in ((), (u.shape[-1],)):
        raise InputError("input.shape", name=f"through[{index}]", expected=(u.shape[-1],), got=v.shape, hint="")
    return np.broadcast_to(v, u[..., index, :].shape)


def _replace(problem: BlendProblem, speeds: Mapping[int, Floats], deltas: Mapping[int, float]) -> BlendProblem:
    """Two pseudo via points for each of the points."""
    points, down, up, h = problem.points, problem.down, problem.up, problem.durations
    for index in sorted(speeds, reverse=True):
        delta, v, u = deltas[index], speeds[index], points[..., index, :]
        if delta >= min(h[index - 1], h[index]):
            raise InputError("trajectory.delta", index=index, delta=delta, shortest=float(min(h[index - 1], h[index])))
        points = np.insert(points, index, u, axis=-2)
        points[..., index, :], points[..., index + 1, :] = u - v * delta, u + v * delta
        down, up = (np.insert(side, index, side[..., index, :], axis=-2) for side in (down, up))
        h = np.insert(h, index, 2.0 * delta)
        h[index - 1] -= delta
        h[index + 1] -= delta
    return BlendProblem(points, h, down, up, problem.together)


def _require_inner(name: str, index: int, problem: BlendProblem) -> None:
    """Refuse an index of no inner point.

    Raises:
        InputError: it is none.
    """
    last = problem.points.shape[-2] - 2
    if not 1 <= index <= last:
        raise InputError("input.range", name=name, value=index, low=1, high=last)
