"""The protocol of control laws: from a measured state and a reference to joint efforts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from mafsil.arrays import Floats, JointVector
from mafsil.trajectory import Motion


@runtime_checkable
class Law(Protocol):
    """Maps time, state and reference to efforts: `law(t, q, qd, reference)`.

    A law itself holds no memory, so that one law serves many runs; `session` starts the memory that one run needs.
    """

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Joint efforts (*batch, n) [N m | N].

        Args:
            t: time [s].
            q, qd: (*batch, n) measured positions and rates [rad | m] and per second.
            reference: desired positions, rates and accelerations, (*batch, n) or (n,).
        """
        ...

    def session(self, period: float) -> Law:
        """The law with fresh memory, to be called once every `period` [s]; the law itself if it needs none."""
        ...


@dataclass(frozen=True, slots=True)
class Combined:
    """The sum of several laws, such as feedforward and feedback."""

    laws: tuple[Law, ...]

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """The sum of the efforts (*batch, n) [N m | N]."""
        first, *others = self.laws
        effort = first(t, q, qd, reference)
        for law in others:
            effort = effort + law(t, q, qd, reference)
        return effort

    def session(self, period: float) -> Law:
        """All laws with fresh memory."""
        return Combined(tuple(law.session(period) for law in self.laws))


def combined(*laws: Law) -> Combined:
    """The sum of several laws, such as feedforward and feedback."""
    return Combined(laws)


def saturated(effort: JointVector, limit: Floats) -> JointVector:
    """Efforts within their limits: elementwise clipped to -limit .. limit, infinite limits clip nothing.

    Args:
        effort: (*batch, n) commanded [N m | N].
        limit: (n,) magnitudes.
    """
    return np.minimum(np.maximum(effort, -limit), limit)
