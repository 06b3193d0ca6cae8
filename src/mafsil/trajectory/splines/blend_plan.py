"""All blends of a path of straight lines: points, durations, accelerations give slopes, blend and straight times."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.trajectory.splines.blend_legs import first_leg, interior_blend, last_leg, single_leg, slope
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
