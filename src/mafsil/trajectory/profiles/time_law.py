"""What a time law is: how a motion from rest to rest spends its time, the same for every distance and duration."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from mafsil.arrays import Floats
from mafsil.trajectory.motion import Stretchable


class TimeLaw(Protocol):
    """All coordinates on one share s(t) of their way, or each with its own blends."""

    @property
    def peaks(self) -> tuple[float, float, float]:
        """Largest |ds/dx|, |d2s/dx2| and |d3s/dx3| over x = t/T: peak velocity T/D, acceleration T^2/D, jerk T^3/D."""
        ...

    def unit(self) -> Stretchable:
        """s(t) from 0 to 1 within one second."""
        ...

    def between(self, start: Floats, goal: Floats, duration: float) -> Stretchable:
        """The motion from `start` to `goal` (*batch, n) that takes `duration` [s]."""
        ...

    def fastest(
        self,
        start: Floats,
        goal: Floats,
        *,
        velocity: Floats | float,
        acceleration: Floats | float,
        margin: float = 0.0,
        least: float = 0.0,
    ) -> Stretchable:
        """The shortest motion whose peaks keep the limits.

        Args:
            start, goal: (n,) positions [rad | m | 1].
            velocity, acceleration: (n,) or a number, largest magnitudes.
            margin: share of time on top, where peaks that equal a limit by formula exceed it by rounding.
            least: shortest duration of a motion whose formula divides by it [s].
        """
        ...


def shortest_duration(
    peaks: tuple[float, float, float], distance: Floats, velocity: Floats | float, acceleration: Floats | float
) -> float:
    """Shortest time of all coordinates together [s]: peak velocity p_1 |D| / T, peak acceleration p_2 |D| / T^2.

    Args:
        peaks: of the law.
        distance: (n,) D to go [rad | m | 1].
        velocity, acceleration: (n,) or a number, largest magnitudes.
    """
    way = np.abs(distance)
    each = np.maximum(peaks[0] * way / velocity, np.sqrt(peaks[1] * way / acceleration))
    return float(each.max(initial=0.0))
