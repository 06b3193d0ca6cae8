"""What a planned leg of a job keeps, and how it is timed again when that changes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from mafsil.job.description import Bounds
from mafsil.model import JointLimits


@dataclass(frozen=True, eq=False, slots=True)
class Timing:
    """What a planned leg keeps, and how to time it again.

    Attributes:
        limits: of the joints, for this move.
        bounds: of the job.
        speed: share of the tip's bounds; None where they do not count.
        again: the duration of the leg with other limits and bounds [s]; raises Refused where there is no motion.
    """

    limits: JointLimits
    bounds: Bounds
    speed: float | None
    again: Callable[[JointLimits, Bounds], float]
