"""What disturbs a run: pushes at the tip and noise of the sensors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats, Vector6, as_batch, frozen, number, positive, require_finite, whole
from mafsil.fields import check_fields, finite


@dataclass(frozen=True, eq=False)
class WrenchPulse:
    """A constant wrench during an interval of time.

    Attributes:
        start, duration: when it acts [s].
        push: (6,) or (*batch, 6) wrench (m, f) that the world exerts on the tip, in the tip frame [N m, N].

    Raises:
        InputError: a wrong shape, a number that is not finite, a duration that is not positive.
    """

    start: float
    duration: float
    push: Vector6

    def __post_init__(self) -> None:
        number("start", self.start)
        positive("duration", self.duration)
        object.__setattr__(self, "push", frozen(require_finite("push", as_batch("push", self.push, (6,)))))


@dataclass(frozen=True, eq=False)
class SensorNoise:
    """Normal noise of the measured positions and rates, the same for the same seed.

    Attributes:
        position, velocity: standard deviations, a number or (n,) [rad | m], [rad/s | m/s].
        seed: of the generator.
    """

    position: Floats | float = 0.0
    velocity: Floats | float = 0.0
    seed: int | tuple[int, ...] = 0
    __post_init__ = check_fields(position=finite(0, 1, low=0.0), velocity=finite(0, 1, low=0.0))

    def drawn(self, ticks: int, shape: tuple[int, ...]) -> tuple[Floats, Floats]:
        """Noise of every control tick, (ticks, *shape) for positions and for rates."""
        sizes = (whole("ticks", ticks), *(whole("shape", each) for each in shape))
        draws = np.random.default_rng(self.seed).standard_normal((2, *sizes))
        return self.position * draws[0], self.velocity * draws[1]


def push_at(pulses: Sequence[WrenchPulse], times: Floats) -> list[Vector6 | None]:
    """The sum of the pulses that act at each time; None where there is none."""
    if not pulses:
        return [None] * len(times)
    pushes: list[Vector6 | None] = []
    for t in times:
        acting = [pulse.push for pulse in pulses if pulse.start <= t < pulse.start + pulse.duration]
        pushes.append(sum(acting[1:], acting[0]) if acting else None)
    return pushes
