"""How smooth a trajectory is, measured from itself: the jumps of its derivatives where its parts meet."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from mafsil.answer import Answer
from mafsil.arrays import Floats
from mafsil.messages import say
from mafsil.trajectory.limit_check import derivative
from mafsil.trajectory.motion import Trajectory
from mafsil.trajectory.status import ContinuityStatus
from mafsil.trajectory.tolerances import ROUNDING

NAMES = ("upper", "velocity", "acceleration", "jerk")
"""Names of derivatives 0 to 3 in the catalogue of sentences."""
NEAR = 1e-6
"""How far beside a break a derivative is looked at, relative to the shorter piece beside it."""
JUMP = 1e-6
"""A jump, relative to the largest value of its derivative; below it is rounding."""


@dataclass(frozen=True, slots=True)
class Jump:
    """A derivative that is not continuous.

    Attributes:
        order: 0 for the position, to 3 for the jerk.
        time: [s].
        coordinate: index.
        size: value after less value before.
    """

    order: int
    time: float
    coordinate: int
    size: float


@dataclass(frozen=True, slots=True, repr=False)
class Continuity(Answer):
    """How often a trajectory is continuously differentiable; true if its velocity does not jump.

    Attributes:
        order: of the highest derivative up to which all are continuous; -1 if the position jumps, 3 is the highest.
        jumps: all of the first derivative that is not continuous, in the order of time.
    """

    order: int
    jumps: tuple[Jump, ...]

    def __bool__(self) -> bool:
        return self.order >= 1

    def __len__(self) -> int:
        return len(self.jumps)

    def __iter__(self) -> Iterator[Jump]:
        return iter(self.jumps)

    def __repr__(self) -> str:
        return self.explain()

    @property
    def status(self) -> ContinuityStatus:
        """Whether an arm can follow: its velocity cannot jump."""
        return ContinuityStatus.CONTROLLABLE if self else ContinuityStatus.NOT_CONTROLLABLE

    def explain(self, language: str | None = None) -> str:
        """Which derivative jumps first, where most and by how much."""
        if not self.jumps:
            return say("trajectory.no_jump", language=language)
        worst = max(self.jumps, key=lambda jump: abs(jump.size))
        quantity = say(f"trajectory.{NAMES[worst.order]}", language=language)
        sentence = say("trajectory.jump", language=language, quantity=quantity, count=len(self.jumps), **asdict(worst))
        return f"{sentence}; {self.status.sentence(language)}"

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {"status": self.status.name, "order": self.order, "jumps": [asdict(jump) for jump in self.jumps]}


def continuity(trajectory: Trajectory, *, ends: bool = True, tolerance: float = JUMP) -> Continuity:
    """Measure the jumps of position, velocity, acceleration and jerk at all breaks.

    The values beside a break at two distances give the jump without its slope: 2 J(h) - J(2 h).

    Args:
        trajectory: without batch dimensions.
        ends: whether start and end count, before and after which a trajectory rests.
        tolerance: relative to the largest value of each derivative: smaller differences are no jumps.
    """
    breaks = trajectory.breaks()
    if len(breaks) < 2 or trajectory.duration == 0.0:
        return Continuity(3, ())
    gaps = np.diff(breaks)
    beside = NEAR * np.minimum(np.append(gaps, gaps[-1]), np.insert(gaps, 0, gaps[0]))
    inside = slice(None) if ends else slice(1, -1)
    at, h = breaks[inside], beside[inside]
    for order in range(4):
        before, after = (_across(trajectory, at, k * h, order) for k in (1.0, 2.0))
        sizes = 2.0 * before - after
        largest = np.abs(derivative(trajectory, np.linspace(0.0, trajectory.duration, 257), order)).max(axis=0)
        largest = np.maximum(largest, np.abs(sizes).max(axis=0, initial=0.0))
        noise = ROUNDING * np.abs(derivative(trajectory, at, 0)).max(initial=1e-300) / trajectory.duration**order
        found = np.argwhere(np.abs(sizes) > np.maximum(tolerance * largest, noise))
        if len(found):
            jumps = tuple(Jump(order, float(at[k]), int(i), float(sizes[k, i])) for k, i in found)
            return Continuity(order - 1, jumps)
    return Continuity(3, ())


def _across(trajectory: Trajectory, at: Floats, h: Floats, order: int) -> Floats:
    """(k, n) value at `at` + h less that at `at` - h."""
    return derivative(trajectory, at + h, order) - derivative(trajectory, at - h, order)
