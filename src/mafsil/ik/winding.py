"""Whole turns of revolute joints: coordinates wound near others and into their limits."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector
from mafsil.ik.tolerances import ON_LIMIT, WHOLE_TURN

TURN = 2 * np.pi


def wound_near(
    q: JointVector, q0: JointVector, lower: Floats, upper: Floats, revolute: NDArray[np.bool_]
) -> JointVector:
    """Revolute joints moved by whole turns as near to `q0` as possible, into the limits where that can be done.

    Args:
        q, q0: (*batch, n) coordinates.
        lower, upper: (n,) limits.
        revolute: (n) which coordinates are angles.
    """
    moved = q - np.where(revolute, TURN * np.round((q - q0) / TURN), 0.0)
    up = np.where(revolute & (moved < lower), np.ceil((lower - moved) / TURN - WHOLE_TURN), 0.0)
    down = np.where(revolute & (moved > upper), np.ceil((moved - upper) / TURN - WHOLE_TURN), 0.0)
    shifted = moved + TURN * (up - down)
    return np.where((shifted >= lower - ON_LIMIT) & (shifted <= upper + ON_LIMIT), shifted, moved)
