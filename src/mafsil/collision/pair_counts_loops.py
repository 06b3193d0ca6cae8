"""How often pairs of bodies of an arm meet, and how near they come, compiled."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.collision.arm_loops import Arm, gap_between, just_above, place_bodies, scratch_for
from mafsil.kernels.loops.loop import compiled


@compiled
def count_meetings(arm: Arm, poses: Floats, counts: NDArray[np.int64]) -> None:
    """Add to `counts` (m,), for each pair of the arm, the states in which it meets.

    Args:
        poses: (k, L, 4, 4) of the links.
        counts: of each pair.
    """
    s, least = scratch_for(arm), just_above(0.0)
    for r in range(len(poses)):
        place_bodies(arm, poses[r], s)
        for k in range(len(arm.pairs)):
            if gap_between(arm, arm.pairs[k, 0], arm.pairs[k, 1], poses[r], least, 0.0, s) <= 0.0:
                counts[k] += 1


@compiled
def measure_gaps(arm: Arm, poses: Floats, most: float, gaps: Floats) -> None:
    """Distances of the pairs of an arm in some states; zero where they meet.

    Args:
        poses: (k, L, 4, 4) of the links.
        most: larger distances count as this one [m].
        gaps: (k, m) of each pair.
    """
    s = scratch_for(arm)
    for r in range(len(poses)):
        place_bodies(arm, poses[r], s)
        for k in range(len(arm.pairs)):
            gaps[r, k] = max(gap_between(arm, arm.pairs[k, 0], arm.pairs[k, 1], poses[r], most, 0.0, s), 0.0)
