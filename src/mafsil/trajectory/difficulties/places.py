"""Intervals of a path and its legs."""

from __future__ import annotations

import numpy as np

from mafsil.trajectory.difficulties.difficulty import PathInterval
from mafsil.trajectory.paths import TipPath


def place_of(path: TipPath, begin: float, end: float) -> PathInterval:
    """An interval with the leg that its middle is on.

    Args:
        path: of the tip.
        begin, end: of s.
    """
    legs = len(path.breaks) - 1
    leg = int(np.clip(np.searchsorted(path.breaks, (begin + end) / 2, side="right"), 1, legs))
    return PathInterval(begin, end, leg, legs)
