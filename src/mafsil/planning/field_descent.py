"""Paths down a potential field, and random walks out of its local minima."""

from __future__ import annotations

from dataclasses import dataclass, field
from time import perf_counter
from typing import Any, Protocol

import numpy as np

from mafsil.arrays import Floats
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.messages import say
from mafsil.model.limits import snap_to_bounds
from mafsil.planning.outcome import Plan, PlanningStatus

STILL = 1e-10
"""Force, as share of the attraction at the start, below which a point stands still."""
RESTS = 1e-3
"""The same, below which a place from which no step leads farther down counts as a minimum."""
ARRIVED = 1e-9
MOST_STEPS = 20_000
SHORT_WALK, LONG_WALK = 10, 60
"""Steps of a random walk between which it is drawn, times the failures before."""
BACK = 3
"""Every so many failures a walk begins farther back on the way."""
LEAST_CLEAR = 1e-3
"""Share of a step by which a proof that it is clear has to go on at least."""
REMEMBERED = 16
"""Points whose field is remembered."""
LOWER = 1e-6
"""Share of its potential by which a minimum has to lie lower than another one to be worth going on from."""


class Field(Protocol):
    """What is gone down."""

    @property
    def goal(self) -> Floats:
        """(n,) where it leads."""
        ...

    @property
    def kp(self) -> float:
        """How strong the attraction is."""
        ...

    @property
    def lower(self) -> Floats:
        """(n,) least coordinates."""
        ...

    @property
    def upper(self) -> Floats:
        """(n,) largest coordinates."""
        ...

    def at(self, x: Floats) -> tuple[float, Floats, float]:
        """U, the force (n,), and by how much x (n,) can change before anything could be met."""
        ...


@dataclass(frozen=True, eq=False, repr=False)
class FieldPath(Plan):
    """A path down a potential field.

    Attributes:
        minima: (m, n) the local minima that it came to, in order; all but the last were left where it went on.
    """

    minima: Floats = field(default_factory=lambda: np.zeros((0, 0)))

    def explain(self, language: str | None = None) -> str:
        """The status, the account, and how many minima it came to."""
        more = say("planning.minima", language=language, count=len(self.minima))
        return super().explain(language) + (f"\n{more}" if len(self.minima) else "")

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return super().to_dict() | {"minima": self.minima.tolist()}


def down_the_field(around: Field, start: Floats, step: float, escapes: int, seed: int) -> FieldPath:
    """From a point to the goal, or to a local minimum from which no walk leads on.

    1. Ends that cannot be; a start beyond a bound by rounding is led onto it.
    2. Down to a place where the point rests.
    3. A random walk from there, or from farther back, and down again: kept where that ends lower.

    Args:
        around: the field.
        start: (n,) [m | rad].
        step: longest step.
        escapes: random walks.
        seed: of these.
    """
    given, start = start, snap_to_bounds(start, around.lower, around.upper)
    way = [given] if (given != start).any() else []
    begun, rng, descent = perf_counter(), np.random.default_rng(seed), _Descent(around, start, step)

    def ended(status: PlanningStatus, rows: list[Floats], minima: list[Floats]) -> FieldPath:
        seconds = perf_counter() - begun
        places = np.array(minima).reshape(-1, len(start))
        return FieldPath(
            status, np.stack([*way, *rows]), "potential_field", descent.looks, 0, len(rows), seconds, minima=places
        )

    # 1
    blocked = descent.blocked_end()
    if blocked is not None:
        return ended(blocked, [start], [])
    # 2
    rows, minima, failures = descent.down(start), list[Floats](), 0
    for _ in range(escapes):
        if descent.is_goal(rows[-1]) or descent.spent:
            break
        # 3
        failures += 1
        minima += [rows[-1]] if failures == 1 else []
        base = rows
        if failures % BACK == 0:
            base = rows[: 1 + int(rng.integers(len(rows)))]
        walk = descent.random_walk(base[-1], rng, failures)
        new = [*base, *walk, *descent.down(walk[-1])[1:]] if walk else base
        if descent.is_goal(new[-1]) or descent.potential(new[-1]) < (1.0 - LOWER) * descent.potential(rows[-1]):
            rows, failures = new, 0
    if descent.is_goal(rows[-1]):
        return ended(PlanningStatus.FOUND, rows, minima)
    rests = descent.rests(rows[-1])
    minima += [rows[-1]] if failures == 0 and rests else []
    return ended(PlanningStatus.LOCAL_MINIMUM if rests else PlanningStatus.NOT_FOUND, rows, minima)


class _Descent:
    """Steps of one path.

    Args:
        around: the field.
        start: (n,) where it begins.
        step: longest step.
    """

    def __init__(self, around: Field, start: Floats, step: float) -> None:
        self.field, self.start, self.longest, self.looks = around, start, step, 0
        self._known: dict[bytes, tuple[float, Floats, float]] = {}
        self.size = max(around.kp * float(np.linalg.norm(around.goal - start)), LEAST_DIVISOR)

    @property
    def spent(self) -> bool:
        """Whether the budget of steps is used up."""
        return self.looks >= MOST_STEPS

    def blocked_end(self) -> PlanningStatus | None:
        """An end that lies outside the limits, or at which an obstacle has no distance left."""
        ends = (
            (self.start, PlanningStatus.START_OUTSIDE, PlanningStatus.START_BLOCKED),
            (self.field.goal, PlanningStatus.GOAL_OUTSIDE, PlanningStatus.GOAL_BLOCKED),
        )
        for end, outside, blocked in ends:
            if (end < self.field.lower).any() or (end > self.field.upper).any():
                return outside
            if not self.clear(end) > 0.0:
                return blocked
        return None

    def at(self, x: Floats) -> tuple[float, Floats, float]:
        """What the field is at a point; the last ones are asked for again and again."""
        key = x.tobytes()
        if key not in self._known:
            if len(self._known) >= REMEMBERED:
                self._known.clear()
            self._known[key] = self.field.at(x)
        return self._known[key]

    def clear(self, x: Floats) -> float:
        """By how much a point can change before anything could be met."""
        return self.at(x)[2]

    def potential(self, x: Floats) -> float:
        """U."""
        return self.at(x)[0]

    def is_goal(self, x: Floats) -> bool:
        """Whether a point is the goal."""
        return bool(np.linalg.norm(self.field.goal - x) <= ARRIVED * max(1.0, self.size / self.field.kp))

    def rests(self, x: Floats) -> bool:
        """Whether (nearly) no force is left at a point, but what presses it against the limits."""
        return float(np.linalg.norm(self._free_force(x, self.at(x)[1]))) <= RESTS * self.size

    def down(self, x: Floats) -> list[Floats]:
        """Points down the field from one, which is the first, to where it rests."""
        rows = [x]
        while not self.spent and not self.is_goal(x):
            found = self._lower_place(x)
            if found is None:
                break
            x = found
            rows.append(x)
        return rows

    def random_walk(self, x: Floats, rng: np.random.Generator, times: int) -> list[Floats]:
        """A random walk that meets nothing; the longer, the more there were before."""
        rows, limits = [x], (self.field.lower, self.field.upper)
        for _ in range(times * int(rng.integers(SHORT_WALK, LONG_WALK))):
            new = np.clip(rows[-1] + rng.normal(size=len(x)) * self.longest, *limits)
            if self._way_is_clear(rows[-1], new):
                rows.append(new)
        return rows[1:]

    def _free_force(self, x: Floats, F: Floats) -> Floats:
        """The force without what presses against the limits."""
        stopped = ((x <= self.field.lower) & (F < 0.0)) | ((x >= self.field.upper) & (F > 0.0))
        return np.where(stopped, 0.0, F)

    def _lower_place(self, x: Floats) -> Floats | None:
        """A point farther down along the force; None where none is lower."""
        self.looks += 1
        here, F, _ = self.at(x)
        F = self._free_force(x, F)
        size = float(np.linalg.norm(F))
        if not np.isfinite(size) or size <= STILL * self.size:
            return None
        length = min(self.longest, size / self.field.kp)
        while length > 1e-15 * max(1.0, float(np.abs(x).max())):
            new = np.clip(x + F * (length / size), self.field.lower, self.field.upper)
            if self.potential(new) < here and self._way_is_clear(x, new):
                return new
            length /= 2.0
        return None

    def _way_is_clear(self, a: Floats, b: Floats) -> bool:
        """Whether nothing is met on the straight way between two points: balls that are clear cover it."""
        length = float(np.linalg.norm(b - a))
        done = 0.0
        while done < length:
            forward = self.clear(a + (b - a) * (done / length))
            if not forward > LEAST_CLEAR * length:
                return False
            done += forward
        return self.clear(b) > 0.0
