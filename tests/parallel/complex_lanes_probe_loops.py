"""A loop in lanes that only the tests call."""

from __future__ import annotations

from mafsil.kernels.loops.lanes import seen
from mafsil.kernels.loops.loop import compiled
from mafsil.parallel.platforms.complex_lane_loops import solve_in_lanes


@compiled
def solve_eight(numbers):
    """Systems (6, 8, 2, 8): rows, columns with both right sides, real and imaginary parts, lanes."""
    solve_in_lanes(seen(numbers))
