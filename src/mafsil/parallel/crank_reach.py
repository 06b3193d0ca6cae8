"""By how much rods on cranks are too short or too long: the distance to feasibility where a pose has no angles."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats


def rod_misfit(along: Floats, across: Floats | float, crank: Floats | float, rod: Floats | float) -> Floats:
    """Lengths [m] that rods miss: positive where they are too short, negative where too long, zero where they fit.

    Args:
        along: distance of the far end of the rod from the motor, in the plane in which the crank turns [m].
        across: its distance from that plane [m].
        crank, rod: lengths [m].
    """
    near, far = np.hypot(across, along - crank), np.hypot(across, along + crank)
    return np.maximum(near - rod, 0.0) - np.maximum(rod - far, 0.0)
