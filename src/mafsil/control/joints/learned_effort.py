"""Efforts over time that were learned from passes before, as a law."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats, JointVector
from mafsil.control.laws.law import Law
from mafsil.trajectory import Motion


@dataclass(frozen=True, eq=False, slots=True)
class LearnedEffort:
    """A table of efforts, one row for each call of the law; nothing after its end.

    Attributes:
        period: between rows [s].
        effort: (k, n) [N m | N].
    """

    period: float
    effort: Floats

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """The efforts of the row at this time (n,), whatever the state is."""
        k = round(t / self.period)
        if not 0 <= k < len(self.effort):
            return np.zeros(self.effort.shape[1:])
        row: Floats = self.effort[k]
        return row

    def session(self, period: float) -> Law:
        """The law itself: it has no memory."""
        return self
