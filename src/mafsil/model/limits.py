"""Bounds of a joint's motion and effort."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf


@dataclass(frozen=True, slots=True)
class Limits:
    """Bounds of one joint; what is not known is infinite.

    Attributes:
        lower, upper: position [rad | m].
        velocity, acceleration, jerk: magnitudes [rad/s | m/s] and time derivatives.
        effort: magnitude [N m | N].
    """

    lower: float = -inf
    upper: float = inf
    velocity: float = inf
    acceleration: float = inf
    jerk: float = inf
    effort: float = inf
