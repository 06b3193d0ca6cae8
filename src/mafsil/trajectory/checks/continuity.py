"""How smooth a trajectory is, measured from itself: the jumps of its derivatives where its parts meet."""

from __future__ import annotations

from dataclasses import asdict, dataclass

from mafsil.answer import Answer
from mafsil.arrays import not_negative
from mafsil.messages import say
from mafsil.trajectory.checks.jumps import JUMP, Jump, jumps
from mafsil.trajectory.motion import Trajectory
from mafsil.trajectory.status import ContinuityStatus

NAMES = ("upper", "velocity", "acceleration", "jerk")
"""Names of derivatives 0 to 3 in the catalogue of sentences."""


@dataclass(frozen=True, slots=True, repr=False)
class Continuity(Answer, data="order jumps", entries="jumps"):
    """How often a trajectory is continuously differentiable; true if its velocity does not jump.

    Attributes:
        order: of the highest derivative up to which all are continuous; -1 if the position jumps, 3 is the highest.
        jumps: all of the first derivative that is not continuous, in the order of time.
    """

    order: int
    jumps: tuple[Jump, ...]

    def __bool__(self) -> bool:
        return self.order >= 1

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


def continuity(trajectory: Trajectory, *, ends: bool = True, tolerance: float = JUMP) -> Continuity:
    """Measure the jumps of position, velocity, acceleration and jerk at all breaks.

    Args:
        trajectory: without batch dimensions.
        ends: whether start and end count, before and after which a trajectory rests.
        tolerance: relative to the largest value of each derivative: smaller differences are no jumps.
    """
    tolerance = not_negative("tolerance", tolerance)
    for order in range(4):
        found = jumps(trajectory, order, ends=ends, tolerance=tolerance)
        if found:
            return Continuity(order - 1, found)
    return Continuity(3, ())
