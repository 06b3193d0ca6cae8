"""Straight lines with blends: slopes, blend and straight times of every leg, and points that are passed exactly.

A is the acceleration at which a blend changes speed, a magnitude; of blends that are no parabolas it is the mean over
the blend. What has no solution is NaN.

Reference: Craig, Introduction to Robotics, eqs. (7.24), (7.26), (7.28).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, positive, real_array, require_finite
from mafsil.errors import InputError
from mafsil.trajectory.tolerances import ROUNDING


@dataclass(frozen=True, eq=False)
class BlendProblem:
    """What is wanted: points, durations of the legs, accelerations.

    Attributes:
        points: (*batch, m, n) [rad | m].
        durations: (*batch or none, m - 1) of the legs [s].
        down, up: (*batch, m, n) magnitudes of mean acceleration that a blend may use towards smaller and larger speeds.
        together: one blend time at each point for all coordinates.
    """

    points: Floats
    durations: Floats
    down: Floats
    up: Floats
    together: bool = False


@dataclass(frozen=True, eq=False)
class Blends:
    """What follows; NaN where an end leg is too short for its blend.

    Attributes:
        acceleration: (*batch, m, n) mean over each blend, signed [rad/s^2 | m/s^2].
        blend: (*batch, m, n) duration of the blend at each point [s].
        slope: (*batch, m - 1, n) velocity of the straight parts [rad/s | m/s].
        straight: (*batch, m - 1, n) duration of the straight parts [s]; negative where blends overlap.
    """

    acceleration: Floats
    blend: Floats
    slope: Floats
    straight: Floats

    def feasible(self, durations: Floats) -> NDArray[np.bool_]:
        """(*batch, m - 1, n) whether each leg holds its blends.

        Args:
            durations: (*batch or none, m - 1) of the legs [s].
        """
        with np.errstate(invalid="ignore"):
            return self.straight >= -ROUNDING * durations[..., None]


def blends(problem: BlendProblem) -> Blends:
    """Slopes, blend times, straight times.

    1. Slopes of the end legs, which their own blends bend; slopes of the others.
    2. Blends between the slopes.
    3. Straight times: what blends leave; those at the ends lie wholly inside their legs.
    """
    h, m = problem.durations, problem.points.shape[-2]
    D = np.diff(problem.points, axis=-2)
    with np.errstate(invalid="ignore"):
        if m == 2:
            ends = _single(problem, D[..., 0, :], h[..., 0, None])
        else:
            ends = _several(problem, D, h)
        # 3
        inside = np.where(np.arange(m) % (m - 1) == 0, 1.0, 0.5)[:, None] * ends.blend
        straight = h[..., None] - inside[..., :-1, :] - inside[..., 1:, :]
    return Blends(ends.acceleration, ends.blend, ends.slope, straight)


def _single(problem: BlendProblem, D: Floats, h: Floats) -> Blends:
    """From rest to rest."""
    duration = np.broadcast_to(h, D.shape)
    A_start = _towards(problem, 0, D)
    A_goal = _towards(problem, 1, -D)
    leg = single_leg(D, duration, A_start, A_goal)
    acceleration, blend, slopes = np.stack(leg.acceleration, -2), np.stack(leg.blend, -2), leg.slope[..., None, :]
    if problem.together:
        blend = np.broadcast_to(blend.max(axis=(-1, -2), keepdims=True), blend.shape)
        slopes = slope(D, duration - blend[..., 0, :])[..., None, :]
        acceleration = np.concatenate([slope(slopes, blend[..., :1, :]), -slope(slopes, blend[..., 1:, :])], axis=-2)
    return Blends(acceleration, blend, slopes, np.zeros(0))


def _several(problem: BlendProblem, D: Floats, h: Floats) -> Blends:
    """Two legs or more."""
    # 1
    to_first, to_last = D[..., 0, :], D[..., -1, :]
    h_first, h_last = (np.broadcast_to(h[..., k, None], to_first.shape) for k in (0, -1))
    begin = first_leg(to_first, h_first, _towards(problem, 0, to_first))
    end = last_leg(to_last, h_last, _towards(problem, -1, -to_last))
    t_first, t_last, v_first, v_last = begin.blend, end.blend, begin.slope, end.slope
    if problem.together:
        t_first, t_last = (np.broadcast_to(t.max(axis=-1, keepdims=True), t.shape) for t in (t_first, t_last))
        v_first, v_last = slope(to_first, h_first - t_first / 2), slope(to_last, h_last - t_last / 2)
    middle = slope(D[..., 1:-1, :], np.broadcast_to(h[..., 1:-1, None], D[..., 1:-1, :].shape))
    slopes = np.concatenate([v_first[..., None, :], middle, v_last[..., None, :]], axis=-2)
    # 2
    change = np.diff(slopes, axis=-2)
    A = np.where(change < 0.0, problem.down[..., 1:-1, :], problem.up[..., 1:-1, :])
    a, t = interior_blend(slopes[..., :-1, :], slopes[..., 1:, :], A)
    a_first, a_last = begin.acceleration, end.acceleration
    if problem.together:
        t = np.broadcast_to(t.max(axis=-1, keepdims=True), t.shape)
        a, a_first, a_last = slope(change, t), slope(v_first, t_first), -slope(v_last, t_last)
    return Blends(
        np.concatenate([a_first[..., None, :], a, a_last[..., None, :]], axis=-2),
        np.concatenate([t_first[..., None, :], t, t_last[..., None, :]], axis=-2),
        slopes,
        np.zeros(0),
    )


def _towards(problem: BlendProblem, point: int, change: Floats) -> Floats:
    """The magnitude of acceleration at a point for a change of speed of that sign."""
    return np.where(change < 0.0, problem.down[..., point, :], problem.up[..., point, :])


class EndLeg(NamedTuple):
    """A leg that starts from rest, or ends in it, with one blend wholly inside.

    Attributes:
        acceleration: signed, of that blend [rad/s^2 | m/s^2].
        blend: its duration [s].
        slope: velocity of the straight part [rad/s | m/s].
    """

    acceleration: Floats
    blend: Floats
    slope: Floats


class SingleLeg(NamedTuple):
    """A leg from rest to rest, both blends inside.

    Attributes:
        acceleration: signed, of the first and the last blend [rad/s^2 | m/s^2].
        blend: their durations [s].
        slope: velocity of the straight part [rad/s | m/s].
    """

    acceleration: tuple[Floats, Floats]
    blend: tuple[Floats, Floats]
    slope: Floats


def first_leg(distance: Floats, duration: Floats, A: Floats) -> EndLeg:
    """The leg that leaves the start: a_1 = sgn(D) A,  t_1 = d - sqrt(d^2 - 2 D/a_1),  v = D/(d - t_1/2).

    Args:
        distance: u_2 - u_1 [rad | m]; with 0 the leg rests and has no blend.
        duration: d [s].
        A: magnitude of the acceleration [rad/s^2 | m/s^2].
    """
    blend = _smaller_root(duration, 2.0 * np.abs(distance) / A)
    return EndLeg(np.sign(distance) * A, blend, slope(distance, duration - blend / 2))


def interior_blend(before: Floats, after: Floats, A: Floats) -> tuple[Floats, Floats]:
    """Signed acceleration and duration of the blend between two slopes: a_k = sgn(dv) A,  t_k = dv/a_k.

    Args:
        before, after: slopes v_jk and v_kl [rad/s | m/s]; equal ones need no blend.
        A: magnitude of the acceleration [rad/s^2 | m/s^2].
    """
    change = after - before
    return np.sign(change) * A, np.abs(change) / A


def last_leg(distance: Floats, duration: Floats, A: Floats) -> EndLeg:
    """The leg that arrives at the goal: a_n = -sgn(D) A,  t_n = d - sqrt(d^2 + 2 D/a_n),  v = D/(d - t_n/2).

    Args:
        distance: u_n - u_{n-1} [rad | m]; with 0 the leg rests and has no blend.
        duration: d [s].
        A: magnitude of the acceleration [rad/s^2 | m/s^2].
    """
    mirrored = first_leg(distance, duration, A)
    return mirrored._replace(acceleration=-mirrored.acceleration)


def single_leg(distance: Floats, duration: Floats, A_start: Floats, A_goal: Floats) -> SingleLeg:
    """The only leg, from rest to rest: |v| solves v^2/A - d v + |D| = 0 with 2/A = 1/A_start + 1/A_goal.

    Args:
        distance: D [rad | m].
        duration: d [s].
        A_start, A_goal: magnitudes of the accelerations [rad/s^2 | m/s^2]; of equal ones
            t_b = d/2 - sqrt(d^2/4 - |D|/A).
    """
    A, sign = mean_acceleration(A_start, A_goal), np.sign(distance)
    blend = _smaller_root(duration / 2, np.abs(distance) / A)
    speed = A * blend
    return SingleLeg((sign * A_start, -sign * A_goal), (speed / A_start, speed / A_goal), sign * speed)


def mean_acceleration(A_start: Floats, A_goal: Floats) -> Floats:
    """The one acceleration that takes as long as two different ones: their harmonic mean."""
    return 2.0 * A_start * A_goal / (A_start + A_goal)


def slope(distance: Floats, duration: Floats) -> Floats:
    """Velocity of a straight part; a leg without distance rests, however short it is."""
    moving = distance != 0.0
    return np.where(moving, distance / np.where(moving, duration, 1.0), 0.0)


def _smaller_root(duration: Floats, gap: Floats) -> Floats:
    """d - sqrt(d^2 - gap) as gap/(d + sqrt(d^2 - gap)), where nothing cancels; NaN where the leg is too short."""
    radicand = duration**2 - gap
    close = np.abs(radicand) <= ROUNDING * duration**2
    root = np.sqrt(np.where(close, 0.0, np.where(radicand < 0.0, np.nan, radicand)))
    return np.where(gap > 0.0, gap / np.where(gap > 0.0, duration + root, 1.0), 0.0)


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
