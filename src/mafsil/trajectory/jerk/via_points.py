"""Jerk-limited motions from any state to any state, and through via points: the public functions and their answers."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil import threads
from mafsil.answer import Answer
from mafsil.arrays import Floats, frozen, real_array, require_finite
from mafsil.errors import InputError
from mafsil.floating_point import EPS
from mafsil.lazy_module import lazily
from mafsil.messages import say
from mafsil.messages.tables import in_notebook
from mafsil.trajectory.jerk.motion import Bindings, JerkLimitedBatch, JerkLimitedMotion, Pieces
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
from mafsil.trajectory.motion import Motion, overview
from mafsil.trajectory.motion_limits import Limits

if TYPE_CHECKING:
    import mafsil.trajectory.jerk.online_loops as online_loops
    import mafsil.trajectory.jerk.via_loops as via_loops
else:
    via_loops = lazily("mafsil.trajectory.jerk.via_loops")
    online_loops = lazily("mafsil.trajectory.jerk.online_loops")


MOST_PIECES = 15
"""Pieces of a coordinate: two to come back inside the limits, and a mixture of two motions of seven."""
ROUNDED = 1e-9
"""How far a motion may end from its goal by rounding, relative to the largest position, velocity and acceleration on
its own way."""
USUAL = 1e-60, 1e60
"""Durations and jerks whose fifth powers are numbers."""
ROWS_AT_ONCE = 256
"""Problems that one thread does at a time."""
PART_ROWS = 16
"""Ways that one thread does at a time."""
STRETCH, OVERLAP = 48, 8
"""Segments of a stretch, and around a joint of two how many on either side are searched again."""


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class ViaMotion(Answer, data="duration stops passing velocities accelerations"):
    """A jerk-limited motion through via points: a trajectory and an answer.

    Attributes:
        points: (m, n) start, via points and goal [rad | m].
        passing: (m,) times at which they are passed [s].
        velocities, accelerations: (m, n) there.
        stops: what the motion would take with rest at every via point whose velocity is free [s].
        motion: the motion itself, from the first point to the last.
    """

    points: Floats
    passing: Floats
    velocities: Floats
    accelerations: Floats
    stops: float
    motion: JerkLimitedMotion

    def __bool__(self) -> bool:
        return bool(self.motion)

    def __repr__(self) -> str:
        return overview(self) if self else self.explain()

    def _repr_html_(self) -> str:
        return in_notebook(repr(self))

    @property
    def status(self) -> JerkStatus:
        """How planning ended."""
        return self.motion.status

    @property
    def duration(self) -> float:
        """Length in time; infinite if there is no motion [s]."""
        return self.motion.duration

    @property
    def n(self) -> int:
        """Number of coordinates."""
        return self.points.shape[1]

    def at(self, t: ArrayLike) -> Motion:
        """Position, velocity and acceleration at the times `t` (*times) [s]; at rest outside 0 .. duration."""
        return self.motion.at(t)

    def jerk(self, t: ArrayLike) -> Floats:
        """(*times, n) third derivative at the times `t` [rad/s^3 | m/s^3]; zero outside 0 .. duration."""
        return self.motion.jerk(t)

    def breaks(self) -> Floats:
        """(k + 1,) times between which every coordinate's jerk is constant, 0 and the duration included [s]."""
        return self.motion.breaks()

    def binding(self) -> Bindings:
        """Which limit binds where: a row for each coordinate and interval."""
        return self.motion.binding()

    def explain(self, language: str | None = None) -> str:
        """One sentence: how long it takes, and how long with stops; or which segment has no motion, and why."""
        if self:
            details = {"duration": self.duration, "stops": self.stops, "count": len(self.points) - 2}
            return say("jerk.through", language=language, **details)
        failed = int(np.argmax(~np.isfinite(self.passing)))
        return say("jerk.segment", language=language, index=failed - 1, reason=self.motion.explain(language))


def jerk_limited_through(
    points: ArrayLike,
    limits: Limits,
    *,
    velocities: ArrayLike | None = None,
    start_velocity: ArrayLike = 0.0,
    start_acceleration: ArrayLike = 0.0,
    goal_velocity: ArrayLike = 0.0,
    goal_acceleration: ArrayLike = 0.0,
) -> ViaMotion | tuple[ViaMotion, ...]:
    """A short motion through via points within limits of velocity, acceleration and jerk.

    Between two points all coordinates arrive together, as with `jerk_limited`. The velocities and accelerations at the
    via points are searched for, so that the total is short: a local optimum, never longer than with rest at each of
    them, if rest is possible.

    Args:
        points: (*batch, m, n) start, via points and goal, m at least 2 [rad | m].
        limits: of the n coordinates, as for `jerk_limited`.
        velocities: (m - 2, n) at the via points, NaN where they are free; all free if None [rad/s | m/s].
        start_velocity, goal_velocity: (n,) or one number [rad/s | m/s].
        start_acceleration, goal_acceleration: (n,) or one number [rad/s^2 | m/s^2].

    Returns:
        The motion: a trajectory that says whether there is one; of a batch, as many.

    Raises:
        InputError: a wrong shape, a number that is not finite, a limit of jerk that is infinite.
    """
    array = require_finite("points", real_array("points", points))
    if array.ndim < 2 or array.shape[-2] < 2 or array.shape[-1] < 1:
        raise InputError("input.shape", name="points", expected="(*batch, m, n)", got=array.shape, hint="")
    m, n = array.shape[-2:]
    packed = packed_limits(limits, n)
    ends = (array[..., 0, :], start_velocity, start_acceleration, array[..., -1, :], goal_velocity, goal_acceleration)
    states = problem_of(ends, limits).states.reshape(-1, n, 6)
    require_finite_states(states)
    given = np.full((m, n), np.nan)
    if velocities is not None:
        given[1:-1] = _velocities(velocities, (m - 2, n))
    rows = np.ascontiguousarray(array.reshape(-1, m, n))
    found = _search(rows, states, packed, given)
    return found[0] if array.ndim == 2 else found


def _velocities(given: ArrayLike, shape: tuple[int, int]) -> Floats:
    values = real_array("velocities", given)
    if values.shape != shape:
        raise InputError("input.shape", name="velocities", expected=shape, got=values.shape, hint="")
    if np.isinf(values).any():
        require_finite("velocities", np.where(np.isnan(values), 0.0, values))
    return values


def _search(points: Floats, states: Floats, limits: Floats, given: Floats) -> tuple[ViaMotion, ...]:
    """The motions of all rows, divided among threads; long ways in stretches, then around the joints of these."""
    rows, m, n = points.shape
    stretches = max(1, round((m - 1) / STRETCH))
    bounds = [(m - 1) * k // stretches for k in range(stretches + 1)]
    around = [(joint - OVERLAP, joint + OVERLAP) for joint in bounds[1:-1]]
    at = np.zeros((rows, 3 if stretches == 1 else 2, m, n, 2))
    at[:, :, 0], at[:, :, -1] = states[:, None, :, 1:3], states[:, None, :, 4:6]
    pieces, count = np.zeros((rows, m - 1, 2, n, MOST_PIECES)), np.zeros((rows, m - 1, n))
    totals = np.empty((rows, 2))
    asked = np.ascontiguousarray(np.broadcast_to(given, (rows, m, n)))
    parts = [slice(k, k + PART_ROWS) for k in range(0, rows, PART_ROWS)]

    def whole(work: Any) -> None:
        def part(k: int) -> None:
            of = parts[k]
            work(points[of], limits, asked[of], at[of], pieces[of], count[of], totals[of])

        threads.run(part, len(parts), threads.available())

    def search(ends: list[tuple[int, int]]) -> None:
        def part(k: int) -> None:
            of, (first, last) = parts[k // len(ends)], ends[k % len(ends)]
            via_loops.search_rows(points[of], limits, asked[of], at[of], first, last)

        threads.run(part, len(parts) * len(ends), threads.available())

    whole(via_loops.begin_rows)
    search(list(pairwise(bounds)))
    search(around)
    whole(via_loops.end_rows)
    return tuple(_motion(points[k], limits, states[k], at[k, 0], pieces[k], count[k], totals[k]) for k in range(rows))


def _motion(
    points: Floats, limits: Floats, states: Floats, at: Floats, pieces: Floats, count: Floats, totals: Floats
) -> ViaMotion:
    """The answer of one row."""
    m, n = points.shape
    if not np.isfinite(totals[0]):
        return _refuse(points, limits, at)
    width = int(count.sum(axis=0).max(initial=0))
    times, jerks = np.zeros((2, 1, n, max(width, 1)))
    for i in range(n):
        used = np.arange(MOST_PIECES) < count[:, i, None]
        whole = pieces[:, :, i].swapaxes(0, 1)[:, used]
        times[0, i, : whole.shape[1]], jerks[0, i, : whole.shape[1]] = whole
    lengths = [pieces[k, 0, 0, : int(count[k, 0])].sum() for k in range(m - 1)]
    whole = Pieces(states[None], count.sum(axis=0)[None], times, jerks)
    motion = JerkLimitedMotion(Problem(states, limits), JerkStatus.PLANNED, float(totals[0]), 0, "time", whole)
    passing = frozen(np.concatenate([[0.0], np.cumsum(lengths)]))
    return ViaMotion(points, passing, at[..., 0], at[..., 1], float(totals[1]), motion)


def _refuse(points: Floats, limits: Floats, at: Floats) -> ViaMotion:
    """The answer where a segment has no motion: that segment's."""
    m = len(points)
    passing = np.full(m, np.inf)
    passing[0] = 0.0
    motion = None
    for k in range(m - 1):
        ends = [points[k], at[k, :, 0], at[k, :, 1], points[k + 1], at[k + 1, :, 0], at[k + 1, :, 1]]
        motion = plan_motion(Problem(np.stack(ends, axis=-1), limits))
        if not motion:
            break
        passing[k + 1] = passing[k] + motion.duration
    assert motion is not None
    return ViaMotion(points, passing, at[..., 0], at[..., 1], np.inf, motion)


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
        rows_of = slice(k * ROWS_AT_ONCE, (k + 1) * ROWS_AT_ONCE)
        of = (states[rows_of], outcome[rows_of], count[rows_of], times[rows_of], jerks[rows_of])
        _rows(problem, *of)
        _judge(problem, of[1], Pieces(of[0], *of[2:]))

    threads.run(part, -(-rows // ROWS_AT_ONCE), threads.available())
    return JerkLimitedBatch(problem, outcome, Pieces(states, count, times, jerks))


def _rows(problem: Problem, states: Floats, outcome: Floats, count: Floats, times: Floats, jerks: Floats) -> None:
    given = problem.limits, problem.free, problem.mode, problem.minimum, problem.cycle
    online_loops.plan_rows(states, *given, outcome, count, times, jerks)


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
