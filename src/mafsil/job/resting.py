"""A configuration to begin with, or to be drawn in."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import JointVector
from mafsil.model import JointLimits

MARGIN = 0.15
"""Distance to each bound, as share of the range."""


def resting_place(limits: JointLimits) -> JointVector:
    """(n,) zero, moved into the middle 70 % of each range where it has bounds [rad | m]."""
    span = limits.upper - limits.lower
    margin = np.where(np.isfinite(span), MARGIN * span, 0.0)
    return np.clip(np.zeros(len(span)), limits.lower + margin, limits.upper - margin)
