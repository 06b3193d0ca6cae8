"""Jerk-limited motions from any state to any state: the public function."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil import threads
from mafsil.arrays import Floats
from mafsil.floating_point import EPS
from mafsil.lazy_module import lazily
from mafsil.trajectory.jerk.motion import JerkLimitedBatch, JerkLimitedMotion, Pieces
from mafsil.trajectory.jerk.problem import (
    MODES,
    STATUSES,
    JerkStatus,
    Problem,
    Synchronise,
    as_rows,
    packed_limits,
    problem_of,
    require_finite_states,
)
from mafsil.trajectory.motion_limits import Limits

if TYPE_CHECKING:
    import mafsil.trajectory.jerk.online_loops as online_loops
else:
    online_loops = lazily("mafsil.trajectory.jerk.online_loops")

MOST_PIECES = 15
"""Pieces of a coordinate: two to come back inside the limits, and a mixture of two motions of seven."""
ROUNDED = 1e-9
"""How far a motion may end from its goal by rounding, relative to the largest position, velocity and acceleration on
its own way."""
USUAL = 1e-60, 1e60
"""Durations and jerks whose fifth powers are numbers."""
PART_ROWS = 256
"""Problems that one thread does at a time."""


def jerk_limited(
    start: ArrayLike,
    goal: ArrayLike | None,
    limits: Limits,
    *,
    start_velocity: ArrayLike = 0.0,
    start_acceleration: ArrayLike = 0.0,
    goal_velocity: ArrayLike = 0.0,
    goal_acceleration: ArrayLike = 0.0,
    synchronise: Synchronise = "time",
    minimum_duration: float = 0.0,
    cycle: float = 0.0,
) -> JerkLimitedMotion | JerkLimitedBatch:
    """The shortest motion from any state to any state within limits of velocity, acceleration and jerk.

    Every limit may differ in its two directions. A start outside the limits first comes back inside as soon as it can;
    from there the motion is the shortest there is. Coordinates that have time to spare move quietly: with a mixture of
    an extreme motion and one that changes its velocity once, so that they use no more jerk than they must.

    Args:
        start, goal: (*batch, n) positions [rad | m]; without a goal (None) only its velocity and acceleration count.
        limits: of the n coordinates: MotionLimits, JointLimits or a Robot; jerk finite, what is not bounded infinite.
            The bounds of position are not looked at.
        start_velocity, goal_velocity: (*batch, n) or one number [rad/s | m/s].
        start_acceleration, goal_acceleration: (*batch, n) or one number [rad/s^2 | m/s^2].
        synchronise: `time`: all arrive together, in the first duration that every coordinate can have; `phase`: along
            the straight line from start to goal where all states lie on it, else as `time`; `none`: each as soon as it
            can, to rest (without a goal: to a steady velocity).
        minimum_duration: least duration [s].
        cycle: the duration is a multiple of it [s]; any if zero, or if it is below the rounding of the duration.

    Returns:
        The motion: a trajectory that says whether there is one. Of a batch, all of them; the work is divided among
        threads, and takes 248 bytes for each coordinate.

    Raises:
        InputError: a wrong shape, a number that is not finite, a limit of jerk that is infinite, a wrong choice.

    Reference: mafsil.trajectory.jerk.extreme_loops (the theory); Berscheid and Kroeger, RSS 2021 (the problem).
    """
    free, end = goal is None, start if goal is None else goal
    given = (start, start_velocity, start_acceleration, end, goal_velocity, goal_acceleration)
    if not free and synchronise == "time" and minimum_duration == 0.0 == cycle:
        ready = as_rows(given)
        if ready is not None:
            return _plan_one(ready, limits)
    problem = problem_of(given, limits, free=free, synchronise=synchronise, minimum=minimum_duration, cycle=cycle)
    return plan_motion(problem) if problem.states.ndim == 2 else _batch(problem)


def _plan_one(ready: list[Floats], limits: Limits) -> JerkLimitedMotion:
    """The motion of one problem whose states are rows already."""
    packed = packed_limits(limits, len(ready[0]))
    start, v0, a0, goal, vf, af = ready
    code, ruling, duration, usual, first, count, times, jerks = online_loops.plan_one(
        start, v0, a0, goal, vf, af, packed, *USUAL
    )
    problem = Problem(first[0], packed)
    if usual == 0.0 or code == len(STATUSES):
        return plan_motion(problem)
    pieces = Pieces(first, count, times, jerks)
    return JerkLimitedMotion(problem, STATUSES[int(code)], duration, int(ruling), "time", pieces)


def plan_motion(problem: Problem) -> JerkLimitedMotion:
    """The motion of one problem.

    Raises:
        InputError: a number of its states is not finite.
    """
    n = len(problem.limits)
    first, count, outcome = problem.states[None], np.zeros((1, n)), np.empty((1, 4))
    times, jerks = np.empty((2, 1, n, MOST_PIECES))
    _rows(problem, first, outcome, count, times, jerks)
    pieces = Pieces(first, count, times, jerks)
    _judge(problem, outcome, pieces)
    code, ruling, mode, duration = outcome[0].tolist()
    if code == len(STATUSES):
        require_finite_states(problem.states)
        code = len(STATUSES) - 1
    return JerkLimitedMotion(problem, STATUSES[int(code)], duration, int(ruling), MODES[int(mode)], pieces)


def _batch(problem: Problem) -> JerkLimitedBatch:
    """All problems, divided among threads."""
    n = len(problem.limits)
    states = problem.states.reshape(-1, n, 6)
    rows = len(states)
    outcome, count = np.empty((rows, 4)), np.zeros((rows, n))
    times, jerks = np.empty((2, rows, n, MOST_PIECES))

    def part(k: int) -> None:
        rows_of = slice(k * PART_ROWS, (k + 1) * PART_ROWS)
        of = (states[rows_of], outcome[rows_of], count[rows_of], times[rows_of], jerks[rows_of])
        _rows(problem, *of)
        _judge(problem, of[1], Pieces(of[0], *of[2:]))

    threads.run(part, -(-rows // PART_ROWS), threads.available())
    return JerkLimitedBatch(problem, outcome, Pieces(states, count, times, jerks))


def _rows(problem: Problem, states: Floats, outcome: Floats, count: Floats, times: Floats, jerks: Floats) -> None:
    online_loops.plan_rows(
        states,
        problem.limits,
        problem.free,
        problem.mode,
        problem.minimum,
        problem.cycle,
        outcome,
        count,
        times,
        jerks,
    )


def _judge(problem: Problem, outcome: Floats, pieces: Pieces) -> None:
    """Hold motions against what they were asked for: they end at their goals, in a duration that is allowed.

    1. A cycle below the rounding of the duration leaves it as it is.
    2. What still does not arrive is BEYOND_NUMBERS.
    """
    T = outcome[:, 3]
    if problem.cycle == 0.0 and problem.minimum == 0.0:
        # The loops verify their pieces, as long as nothing under- or overflows, as tiny ways from rest do.
        if online_loops.are_usual(problem.limits, outcome, *USUAL) or (
            (T >= 0.0).all() and pieces.first[..., [1, 2, 4, 5]].any()
        ):
            return
    bad = np.flatnonzero((outcome[:, 0] == 0.0) & ~_arrives(problem, outcome, pieces))
    # 1.
    if len(bad) and problem.cycle > 0.0:
        again = problem._replace(states=pieces.first[bad], cycle=0.0)
        found, counts = np.empty((len(bad), 4)), np.zeros((len(bad), problem.states.shape[-2]))
        times, jerks = np.empty((2, *counts.shape, MOST_PIECES))
        _rows(again, again.states, found, counts, times, jerks)
        part = Pieces(again.states, counts, times, jerks)
        fine = (found[:, 0] == 0.0) & (problem.cycle <= EPS * found[:, 3]) & _arrives(again, found, part)
        good, bad = bad[fine], bad[~fine]
        outcome[good], pieces.count[good] = found[fine], counts[fine]
        pieces.times[good], pieces.jerks[good] = times[fine], jerks[fine]
    # 2.
    outcome[bad, 0], outcome[bad, 3] = STATUSES.index(JerkStatus.BEYOND_NUMBERS), np.inf


def _arrives(problem: Problem, outcome: Floats, pieces: Pieces) -> NDArray[np.bool_]:
    """(rows,) whether the duration is what it may be, and whether the pieces lead to the goal within ROUNDED."""
    T = outcome[:, 3]
    asked = pieces.first
    allowed = np.isfinite(T) & (problem.minimum * (1.0 - ROUNDED) <= T)
    end = np.where(allowed, T, 0.0)
    reached = np.stack([values[0] for values in pieces.sample(end[None])[:3]], axis=-1)
    largest = pieces.largest()
    with np.errstate(all="ignore"):
        missed = np.abs(reached - asked[..., 3:]) <= ROUNDED * largest + np.finfo(np.float64).smallest_subnormal
    if problem.free:
        missed[..., 0] = True
    return allowed & (missed & np.isfinite(largest)).all(axis=(1, 2))
