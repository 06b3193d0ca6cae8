"""Durations of legs that nobody gave: from default speeds or limits, raised until every leg holds its blends."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, calculable, real_array
from mafsil.errors import InputError
from mafsil.trajectory.motion_limits import MotionLimits
from mafsil.trajectory.splines.blend_legs import mean_acceleration
from mafsil.trajectory.splines.blend_plan import BlendProblem, blends
from mafsil.trajectory.tolerances import ROUNDING

ROUNDS = 60
"""Legs are lengthened so often by what they lack; what then still overlaps is slowed as a whole."""
GROWTH = 0.25
"""By which share of itself the quickest leg grows at once."""
MUCH = (np.inf, 1.0, 0.25)
"""What share of a leg is much to lack: each is tried, and the shortest of the motions taken."""
SLOWER = 1.1
"""How much as a whole."""


def default_durations(problem: BlendProblem, velocity: ArrayLike | None, limits: MotionLimits | None) -> BlendProblem:
    """The problem with durations, those of the slowest coordinate and the slowest row of a batch.

    1. |D|/V, the least time of each leg.
    2. End legs need sqrt(2 |D|/A), a leg from rest to rest 2 sqrt(|D|/A); where V is a limit, |D|/V and half a blend.
    3. Each leg is lengthened by what its blends overlap. A leg without distance lasts as long as they do: a stop.

    Args:
        problem: its durations do not count.
        velocity: (n,) or one number, default speeds [rad/s | m/s].
        limits: of the slopes.

    Raises:
        InputError: neither default speeds nor finite limits of velocity, or one that is not positive.
    """
    n = problem.points.shape[-1]
    if velocity is None and limits is None:
        raise InputError("trajectory.no_velocity")
    speed = _speeds(velocity, n)
    free = _speeds(None, n)
    hard = (free, free) if limits is None else (-limits.velocity[0], limits.velocity[1])
    D: Floats = np.diff(problem.points, axis=-2)
    top: Floats = np.where(D < 0.0, hard[0], hard[1])
    pace = np.minimum(speed, top)
    if not ((pace > 0.0) & np.isfinite(pace))[D != 0.0].all():
        raise InputError("trajectory.no_velocity")
    # 1
    way = np.abs(D)
    least = np.where(way > 0.0, way / np.where(way > 0.0, pace, 1.0), 0.0)
    # 2
    least = np.maximum(least, _with_blends(problem, D, top))
    durations = least.reshape(-1, *least.shape[-2:]).max(axis=(0, -1), initial=0.0)
    return _lengthened(replace(problem, durations=durations))


def _speeds(velocity: ArrayLike | None, n: int) -> Floats:
    """(n,) positive speeds; infinite where none is given."""
    V = real_array("velocity", np.inf if velocity is None else velocity)
    if V.shape not in ((), (n,)):
        raise InputError("input.shape", name="velocity", expected=(n,), got=V.shape, hint="")
    if not (V > 0.0).all():
        raise InputError("input.positive", name="velocity", value=float(V[~(V > 0.0)].flat[0]) if V.ndim else float(V))
    return np.broadcast_to(calculable("velocity", V), (n,))


def _with_blends(problem: BlendProblem, D: Floats, top: Floats) -> Floats:
    """(*batch, m - 1, n) least time of end legs with their blends; 0 of the others."""
    way, legs = np.abs(D), D.shape[-2]
    start = np.where(D < 0.0, problem.down[..., :-1, :], problem.up[..., :-1, :])
    goal = np.where(D > 0.0, problem.down[..., 1:, :], problem.up[..., 1:, :])
    least = np.zeros(D.shape)
    if legs == 1:
        A = mean_acceleration(start, goal)
        cruise = way * A > top**2
        safe = np.where(cruise, top, 1.0)
        return np.where(cruise, way / safe + safe / A, 2.0 * np.sqrt(way / A))
    for k, A in ((0, start), (-1, goal)):
        far, strong, fast = way[..., k, :], A[..., k, :], top[..., k, :]
        cruise = 2.0 * far * strong > fast**2
        safe = np.where(cruise, fast, 1.0)
        least[..., k, :] = np.where(cruise, far / safe + safe / (2.0 * strong), np.sqrt(2.0 * far / strong))
    return least


def _lengthened(problem: BlendProblem) -> BlendProblem:
    """3. Longer legs until nothing overlaps: what they lack, or slower legs where they lack much."""
    as_it_is, _ = found = _without_overlaps(problem, MUCH[0])
    if as_it_is is problem:
        return problem
    return min(found, *(_without_overlaps(problem, much) for much in MUCH[1:]), key=lambda each: each[1])[0]


def _without_overlaps(problem: BlendProblem, much: float) -> tuple[BlendProblem, float]:
    """The problem with longer legs, and how long it takes in all; infinite where something overlaps to the end."""
    total = np.inf
    for attempt in range(10 * ROUNDS):
        found = blends(problem)
        lacking = -found.straight.reshape(-1, *found.straight.shape[-2:]).min(axis=(0, -1))
        if (lacking <= ROUNDING * problem.durations).all():
            total = float(problem.durations.sum())
            break
        longer = SLOWER * problem.durations
        if attempt < ROUNDS:
            longer = problem.durations + _growth(problem, found.slope, lacking, much)
        problem = replace(problem, durations=longer)
    return problem, total


def _growth(problem: BlendProblem, slope: Floats, lacking: Floats, much: float) -> Floats:
    """(m - 1,) what legs grow by: what they lack; where that is much, the quickest of a leg and those beside it grows.

    It is quick legs that make blends long. A leg without distance is measured by those beside it.

    Args:
        problem: the legs.
        slope: (*batch, m - 1, n) of them.
        lacking: (m - 1,) what each leg lacks [s].
        much: from which share of a leg on that is much.
    """
    durations, legs = problem.durations, len(problem.durations)
    pace = np.abs(slope) / np.minimum(problem.up, problem.down)[..., :-1, :]
    quick = pace.reshape(-1, *pace.shape[-2:]).max(axis=(0, -1))
    growth = np.zeros(legs)
    for k in np.flatnonzero(lacking > ROUNDING * durations):
        beside = np.arange(max(k - 1, 0), min(k + 2, legs))
        need, quickest = float(lacking[k]) * (1.0 + ROUNDING), int(beside[quick[beside].argmax()])
        if need <= much * float(durations[k] if quick[k] > 0.0 else durations[beside].max()):
            growth[k] = max(growth[k], need)
        else:
            growth[quickest] = max(growth[quickest], GROWTH * durations[quickest])
    return growth
