"""Jerk-limited motions from any state to any state: the public function."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from mafsil import threads
from mafsil.arrays import Floats, called
from mafsil.lazy_module import lazily
from mafsil.trajectory.jerk.motion import JerkLimitedBatch, JerkLimitedMotion, Pieces
from mafsil.trajectory.jerk.problem import (
    MODES,
    Problem,
    Synchronise,
    problem_of,
    require_finite_states,
)
from mafsil.trajectory.jerk.status import STATUSES
from mafsil.trajectory.motion_limits import Limits

if TYPE_CHECKING:
    import mafsil.trajectory.jerk.plan_loops as plan_loops
else:
    plan_loops = lazily("mafsil.trajectory.jerk.plan_loops")

MOST_PIECES = 15
"""Pieces of a coordinate: two to come back inside the limits, and a mixture of two motions of seven."""
PART_ROWS = 256
"""Problems that one thread does at a time."""


@called
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
        cycle: the duration is a multiple of it [s]; any if zero.

    Returns:
        The motion: a trajectory that says whether there is one. Of a batch, all of them; the work is divided among
        threads, and takes 248 bytes for each coordinate.

    Raises:
        InputError: a wrong shape, a number that is not finite, a limit of jerk that is infinite, a wrong choice.

    Reference: mafsil.trajectory.jerk.extreme_loops (the theory); Berscheid and Kroeger, RSS 2021 (the problem).
    """
    free = goal is None
    given = (
        start,
        start_velocity,
        start_acceleration,
        start if goal is None else goal,
        goal_velocity,
        goal_acceleration,
    )
    problem = problem_of(given, limits, free=free, synchronise=synchronise, minimum=minimum_duration, cycle=cycle)
    return planned(problem) if problem.states.ndim == 2 else _batch(problem)


def planned(problem: Problem) -> JerkLimitedMotion:
    """The motion of one problem.

    Raises:
        InputError: a number of its states is not finite.
    """
    n = len(problem.limits)
    first, count, outcome = problem.states[None], np.empty((1, n)), np.empty((1, 4))
    times, jerks = np.empty((2, 1, n, MOST_PIECES))
    _rows(problem, first, outcome, count, times, jerks)
    code, ruling, mode, duration = outcome[0].tolist()
    if code == len(STATUSES):
        require_finite_states(problem.states)
        code = len(STATUSES) - 1
    pieces = Pieces(first, count, times, jerks)
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
        _rows(problem, states[rows_of], outcome[rows_of], count[rows_of], times[rows_of], jerks[rows_of])

    threads.run(part, -(-rows // PART_ROWS), threads.available())
    return JerkLimitedBatch(problem, outcome, Pieces(states, count, times, jerks))


def _rows(problem: Problem, states: Floats, outcome: Floats, count: Floats, times: Floats, jerks: Floats) -> None:
    plan_loops.plan_rows(
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
