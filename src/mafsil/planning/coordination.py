"""Several robots on their paths, one robot among obstacles that move: who waits where, or how far they come."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, positive, require_function, single, whole
from mafsil.errors import InputError
from mafsil.messages import say
from mafsil.planning.problem import answers, require_few_cells

Collides: TypeAlias = Callable[[Floats, Floats], Any]
"""(k,), (k,) -> (k,) bools: whether two robots meet at these shares of their paths; or one, at shares and times."""


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
