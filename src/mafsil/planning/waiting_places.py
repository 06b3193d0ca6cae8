"""Who waits where: robots on their paths, and one arm among arms that move as is known, within its own limits.

Between places at which it may rest an arm moves in the shortest time that its limits allow, so nothing has to brake
harder than it can. What is searched is place and time: at which places it is free at which moments.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, JointVector, positive, require_function, single, whole
from mafsil.errors import InputError
from mafsil.messages import say
from mafsil.planning.arms_motion import TimedArm
from mafsil.planning.problem import answers, require_few_cells
from mafsil.trajectory import JointPath, MotionLimits, Trajectory, time_optimal
from mafsil.trajectory.profiles import rest
from mafsil.trajectory.timing import TimeOptimal

Collides: TypeAlias = Callable[[Floats, Floats], Any]
"""(k,), (k,) -> (k,) bools: whether two robots meet at these shares of their paths; or one, at shares and times."""
RESTS = 8
"""Places at which an arm may wait, besides start and end, at most."""
ALONG = 200
"""Places along a path at which is looked."""
TICK = 0.04
"""Moments at which is looked are so far apart [s], or less often where there would be more than MOST_TICKS."""
MOST_TICKS = 400


@dataclass(frozen=True, eq=False, slots=True)
class Route:
    """A path with places to rest, and the quickest motions between any two of them.

    Attributes:
        path: corners rounded.
        rests: (k,) path parameters of the places to rest, both ends among them.
        motions: for i < j the motion from rest place i to j.
        limits: of the coordinates.
    """

    path: JointPath
    rests: Floats
    motions: dict[tuple[int, int], TimeOptimal]
    limits: MotionLimits

    @property
    def least(self) -> float:
        """Time from start to end without a wait [s]."""
        return self.motions[0, len(self.rests) - 1].duration

    def places(self) -> JointVector:
        """(ALONG, n) configurations evenly along the path."""
        return self.path.at(np.linspace(0.0, self.path.end, ALONG)).u


def route_along(path: JointPath, limits: MotionLimits) -> Route | None:
    """Places to rest among the breaks of a path, and motions between them; None where limits forbid one of them.

    Args:
        path: of proved motions.
        limits: finite velocities and accelerations.
    """
    breaks = path.breaks()
    even = np.linspace(0.0, path.end, RESTS + 2)
    rests = breaks[np.unique(np.abs(breaks[None] - even[:, None]).argmin(axis=1))]
    pairs = [(i, j) for i in range(len(rests)) for j in range(i + 1, len(rests))]
    answers = time_optimal([path.between(float(rests[i]), float(rests[j])) for i, j in pairs], limits)
    if not all(answers):
        return None
    return Route(path, rests, dict(zip(pairs, answers, strict=True)), limits)


def standing(q: JointVector, limits: MotionLimits) -> TimedArm:
    """An arm that stays where it is."""
    return TimedArm((rest(q, TICK),), np.array([0.0, TICK]), (True,), _accelerations(limits))


def _accelerations(limits: MotionLimits) -> Floats:
    """(n,) largest magnitudes."""
    return np.abs(limits.acceleration).max(axis=0)


def timed_way(
    route: Route,
    is_free: Callable[[JointVector, Floats], NDArray[np.bool_]],
    horizon: float,
    tries: int,
    is_proved: Callable[[TimedArm], float | None],
) -> TimedArm | None:
    """The way along a route that arrives first among things that move, with waits at places to rest; None if not found.

    1. Which places are free at which moments.
    2. The earliest arrival, moment by moment: an arm at rest stays, or goes to a later place to rest.
    3. The way found is proved; where it cannot be, its place at that moment counts as taken, and 2 again.

    Args:
        route: of one arm.
        is_free: (k, n) configurations, (k,) moments [s] -> (k,).
        horizon: latest departure to look at; after it nothing else moves [s].
        tries: of 3.
        is_proved: the moment from which a motion is not proved; None if all of it is.
    """
    horizon += route.least
    ticks = min(int(np.ceil(horizon / TICK)) + 2, MOST_TICKS)
    moments = np.linspace(0.0, horizon + TICK, ticks)
    tick = float(moments[1])
    q = route.places()
    rows = np.repeat(q, ticks, axis=0)
    free = is_free(rows, np.tile(moments, len(q))).reshape(len(q), ticks)  # 1
    steps = {pair: _steps(route, pair, tick) for pair in route.motions}
    for _ in range(tries):
        way = _earliest(route, free, steps)  # 2
        if way is None:
            return None
        found = _time(route, way, tick)
        moment = is_proved(found)  # 3
        if moment is None:
            return found
        here = int(np.abs(q - found.at(moment)).max(axis=1).argmin())
        m = int(moment / tick)
        free[max(here - 2, 0) : here + 3, max(m - 1, 0) : m + 3] = False
    return None


def _steps(route: Route, pair: tuple[int, int], tick: float) -> NDArray[np.intp]:
    """(ticks + 1,) which of the places a motion is nearest to, tick by tick, until it rests again."""
    answer = route.motions[pair]
    s, rate = answer.velocities.T
    t = np.concatenate([[0.0], np.cumsum(2.0 * np.diff(s) / np.maximum(rate[1:] + rate[:-1], 1e-12))])
    moments = tick * np.arange(int(np.ceil(answer.duration / tick - 1e-9)) + 1)
    along = np.asarray(route.rests[pair[0]] + np.interp(moments, t, s), dtype=np.float64)
    return np.rint(along / route.path.end * (ALONG - 1)).astype(np.intp)


def _earliest(
    route: Route, free: NDArray[np.bool_], steps: dict[tuple[int, int], NDArray[np.intp]]
) -> list[tuple[int, int]] | None:
    """(place to rest, tick of departure) one after the other, the last with the arrival; None where there is no way."""
    count, ticks = len(route.rests), free.shape[1]
    at = np.rint(route.rests / route.path.end * (ALONG - 1)).astype(np.intp)
    before: dict[tuple[int, int], tuple[int, int] | None] = {(0, 0): None} if free[0, 0] else {}
    stays = np.logical_and.accumulate(free[-1, ::-1])[::-1]
    for m in range(ticks):
        if (count - 1, m) in before and stays[m]:
            return _trace(before, (count - 1, m))
        for i in range(count):
            if (i, m) not in before:
                continue
            if m + 1 < ticks and free[at[i], m + 1]:
                before.setdefault((i, m + 1), (i, m))
            for j in range(i + 1, count):
                way = steps[i, j]
                arrival = m + len(way) - 1
                if arrival < ticks and (j, arrival) not in before and free[way, m + np.arange(len(way))].all():
                    before[j, arrival] = (i, m)
    return None


def _trace(before: dict[tuple[int, int], tuple[int, int] | None], last: tuple[int, int]) -> list[tuple[int, int]]:
    """The way that led to a place and tick, without the ticks of waiting."""
    way: list[tuple[int, int]] = []
    now: tuple[int, int] | None = last
    while now is not None:
        if not way or way[-1][0] != now[0]:
            way.append(now)
        now = before[now]
    return way[::-1]


def _time(route: Route, way: list[tuple[int, int]], tick: float) -> TimedArm:
    """Motions and rests of a way; the arm arrives as early as its last motion ends."""
    parts, rests, clock = list[Trajectory](), list[bool](), 0.0
    for (i, m), (j, _) in pairwise(way):
        answer = route.motions[i, j]
        motion = answer.trajectory
        assert motion is not None
        if tick * m > clock + 1e-12:
            parts.append(rest(motion.at(0.0).u, tick * m - clock))
            rests.append(True)
            clock = tick * m
        parts.append(motion)
        rests.append(False)
        clock += answer.duration
    starts = np.concatenate([[0.0], np.cumsum([each.duration for each in parts])])
    return TimedArm(tuple(parts), starts, tuple(rests), _accelerations(route.limits))


class CoordinationStatus(Status):
    """Whether all arrive."""

    FOUND = ("planning.coordinated", True)
    BLOCKED_END = ("planning.blocked_end", False)
    NOT_FOUND = ("planning.no_way_on_grid", False)


@dataclass(frozen=True, eq=False, repr=False)
class Coordination(Answer, data="t shares reached"):
    """Motions along fixed paths that do not meet; true if all arrive.

    Attributes:
        status: how it ended.
        t: (k,) times [s].
        shares: (k, 2) shares of both paths at these times; of one robot among moving obstacles (k, 1).
        diagram: bools, where the two meet; rows by the first share, columns by the second, or by time.
        reached: shares from which no step leads on, where they wait for each other for ever.
    """

    status: CoordinationStatus
    t: Floats
    shares: Floats
    diagram: NDArray[np.bool_]
    reached: tuple[float, ...] = ()

    @property
    def duration(self) -> float:
        """Until all have arrived; infinite if they do not [s]."""
        return float(self.t[-1]) if self else np.inf

    def explain(self, language: str | None = None) -> str:
        """The status; where no way was found, how far they came."""
        first = self.status.sentence(language, duration=self.duration, cells=max(len(self.diagram) - 1, 1))
        if not self.reached:
            return first
        places = ", ".join(f"{share:.3g}" for share in self.reached)
        return first + say("planning.waiting_at", language=language, places=places)


def coordinate_robots(
    collides: Collides, durations: tuple[float, float], *, cells: int = 200, priority: bool = False
) -> Coordination:
    """The coordination diagram of two robots on fixed paths, and the fastest schedule.

    1. Where they meet, on a grid of both shares.
    2. Steps in time: both go, one goes, the other goes; the first way to the far corner is the quickest of the grid.
    3. If there is none on the grid they block each other there: the farthest that they come together is where.

    Args:
        collides: (k,), (k,) shares -> bools.
        durations: of both paths at full speed [s].
        cells: of the grid along the slower path; places between are not looked at.
        priority: whether the first robot never waits.

    Reference: O'Donnell and Lozano-Perez, Deadlock-free and collision-free coordination of two manipulators, 1989.
    """
    require_function("collides", collides, "function of two arrays of shares", 2)
    times = [positive(f"durations[{k}]", T) for k, T in enumerate(single("durations", durations, (2,)).tolist())]
    step = max(times) / whole("cells", cells, least=1)
    counts = [max(int(np.ceil(T / step - 1e-9)), 1) for T in times]
    # 1.
    shares: list[Floats] = [np.linspace(0.0, 1.0, count + 1, dtype=np.float64) for count in counts]
    grid = np.meshgrid(*shares, indexing="ij")
    diagram = answers("collides", collides(grid[0].ravel(), grid[1].ravel()), (grid[0].size,)).reshape(grid[0].shape)
    # 2. and 3.
    moves = ((1, 1), (1, 0)) if priority else ((1, 1), (1, 0), (0, 1))
    return _through(diagram, shares, moves, step)


def avoid_moving_obstacles(
    collides: Collides, duration: float, horizon: float, *, cells: int = 200, backwards: bool = False
) -> Coordination:
    """Path-time planning of one robot among obstacles with known motions.

    Args:
        collides: (k,) shares, (k,) times [s] -> bools.
        duration: of the path at full speed [s].
        horizon: latest arrival, not before `duration` [s].
        cells: along the path; times between are not looked at.
        backwards: whether it may also go back.

    Reference: Kant and Zucker, Toward efficient trajectory planning: the path-velocity decomposition, IJRR 1986.
    """
    require_function("collides", collides, "function of shares and times", 2)
    step = positive("duration", duration) / whole("cells", cells, least=1)
    if positive("horizon", horizon) < duration:
        raise InputError("input.range", name="horizon", value=horizon, low=duration, high=np.inf)
    steps = int(np.ceil(horizon / step - 1e-9))
    require_few_cells((cells + 1) * (steps + 1))
    shares = np.linspace(0.0, 1.0, cells + 1)
    times: Floats = np.asarray(step * np.arange(steps + 1), dtype=np.float64)
    grid = np.meshgrid(shares, times, indexing="ij")
    diagram = answers("collides", collides(grid[0].ravel(), grid[1].ravel()), (grid[0].size,)).reshape(grid[0].shape)
    moves = (1, 0, -1) if backwards else (1, 0)
    before = np.full(diagram.shape, 99, dtype=np.int8)
    if diagram[0, 0]:
        return Coordination(CoordinationStatus.BLOCKED_END, np.zeros(1), np.zeros((1, 1)), diagram)
    before[0, 0] = 0
    farthest = 0
    for k in range(steps):
        for i in np.flatnonzero(before[:, k] != 99):
            for move in moves:
                j = int(i) + move
                if 0 <= j <= cells and not diagram[j, k + 1] and before[j, k + 1] == 99:
                    before[j, k + 1] = move
                    farthest = max(farthest, j)
        if before[cells, k + 1] != 99:
            way = [cells]
            for m in range(k + 1, 0, -1):
                way.append(way[-1] - int(before[way[-1], m]))
            rows = shares[way[::-1]][:, None]
            return Coordination(CoordinationStatus.FOUND, times[: k + 2], rows, diagram)
    return Coordination(CoordinationStatus.NOT_FOUND, times[:1], np.zeros((1, 1)), diagram, (float(shares[farthest]),))


def _through(
    diagram: NDArray[np.bool_], shares: list[Floats], moves: tuple[tuple[int, int], ...], step: float
) -> Coordination:
    """The way through a diagram in the fewest steps."""
    last = (diagram.shape[0] - 1, diagram.shape[1] - 1)
    start = np.zeros((1, 2))
    if diagram[0, 0] or diagram[last]:
        return Coordination(CoordinationStatus.BLOCKED_END, np.zeros(1), start, diagram)
    before: dict[tuple[int, int], tuple[int, int] | None] = {(0, 0): None}
    wave = deque([(0, 0)])
    farthest = (0, 0)
    while wave:
        cell = wave.popleft()
        if cell == last:
            break
        farthest = max(farthest, cell, key=sum)
        for move in moves:
            # At its end a robot stays.
            other = (min(cell[0] + move[0], last[0]), min(cell[1] + move[1], last[1]))
            if other not in before and not diagram[other]:
                before[other] = cell
                wave.append(other)
    if last not in before:
        reached = (float(shares[0][farthest[0]]), float(shares[1][farthest[1]]))
        return Coordination(CoordinationStatus.NOT_FOUND, np.zeros(1), start, diagram, reached)
    way: list[tuple[int, int]] = []
    cell_or_none: tuple[int, int] | None = last
    while cell_or_none is not None:
        way.append(cell_or_none)
        cell_or_none = before[cell_or_none]
    rows = np.array([[shares[0][i], shares[1][j]] for i, j in way[::-1]])
    return Coordination(
        CoordinationStatus.FOUND, np.asarray(step * np.arange(len(rows)), dtype=np.float64), rows, diagram
    )
