"""Jerk-limited motions through via points: the public function and its answers."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil import threads
from mafsil.answer import Answer
from mafsil.arrays import Floats, frozen, real_array, require_finite
from mafsil.errors import InputError
from mafsil.lazy_module import lazily
from mafsil.messages import say
from mafsil.messages.tables import in_notebook
from mafsil.trajectory.jerk.motion import Bindings, JerkLimitedMotion, Pieces
from mafsil.trajectory.jerk.problem import JerkStatus, Problem, packed_limits, problem_of, require_finite_states
from mafsil.trajectory.jerk.state_to_state import MOST_PIECES, plan_motion
from mafsil.trajectory.motion import Motion, overview
from mafsil.trajectory.motion_limits import Limits

if TYPE_CHECKING:
    import mafsil.trajectory.jerk.via_loops as via_loops
else:
    via_loops = lazily("mafsil.trajectory.jerk.via_loops")

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
