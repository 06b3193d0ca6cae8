"""Error feedback, and the memory that its integral needs."""

from __future__ import annotations

from mafsil.arrays import Floats, JointVector
from mafsil.control.gains import Gains
from mafsil.trajectory import Motion


def pd(gains: Gains, q: JointVector, qd: JointVector, reference: Motion) -> Floats:
    """The term Kp (u - q) + Kd (v - qd), (*batch, n)."""
    return gains.kp * (reference.u - q) + gains.kd * (reference.v - qd)


class Integral:
    """Ki times the error summed over the control periods: the rectangle rule.

    Args:
        gains: whose ki is used.
        period: time between calls [s].
    """

    def __init__(self, gains: Gains, period: float) -> None:
        self._weight = gains.ki * period
        self._sum: Floats = 0.0 * gains.ki

    def __call__(self, q: JointVector, reference: Motion) -> Floats:
        """Add the present error and return the term (*batch, n)."""
        self._sum = self._sum + self._weight * (reference.u - q)
        return self._sum
