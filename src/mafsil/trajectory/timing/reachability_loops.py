"""Time-optimal path velocities by reachability: programs in two variables for eight paths at once, compiled.

Between two places of the grid, with x and y the squares of the path velocity at its ends, all limits are lines
below <= y - slope x <= above, besides 0 <= x <= cap. Both passes over a path need of each interval only:

1. Backward: the largest and the least x from which the set at the interval's end can be reached.
2. Forward: the largest y that the lines and that set allow.

A program in two variables is solved by Newton's method on the gap between the least upper and the greatest lower line
over x: the gap is concave and piecewise linear, so a few steps find its root exactly. A lane that has its answer keeps
it while others go on.

Reference: Pham and Pham, A New Approach to Time-Optimal Path Parameterization Based on Reachability Analysis, 2018.
"""

# pyright: reportMissingParameterType=false, reportUnknownVariableType=false, reportUnknownParameterType=false
# pyright: reportUnknownMemberType=false, reportUnknownArgumentType=false
from __future__ import annotations

from mafsil.kernels.loops.lanes import any_lane, lanes, magnitude, where
from mafsil.kernels.loops.loop import compiled
from mafsil.trajectory.timing.path_rows_loops import FREE, larger, lesser
from mafsil.trajectory.tolerances import ROUNDING

MOST_STEPS = 60


@compiled
def bounds_at(slope, above, below, rows, y_low, y_high, x):
    """Least upper and greatest lower bound of y at x.

    Args:
        slope, above, below: `rows` lanes each, the lines.
        rows: how many.
        y_low, y_high: y that holds without lines.
        x: where.
    """
    upper, lower = y_high, y_low
    for k in range(rows):
        over, under = slope[k] * x + above[k], slope[k] * x + below[k]
        upper, lower = lesser(over, upper), larger(under, lower)
    return upper, lower


@compiled
def gap_at(slope, above, below, rows, y_low, y_high, x):
    """Arguments as in `bounds_at`; its bounds, and the slopes of the two lines that decide."""
    upper, lower, down, up = y_high, y_low, lanes(0.0), lanes(0.0)
    for k in range(rows):
        steep = slope[k]
        over, under = steep * x + above[k], steep * x + below[k]
        nearer, farther = over < upper, under > lower
        upper, down = where(nearer, over, upper), where(nearer, steep, down)
        lower, up = where(farther, under, lower), where(farther, steep, up)
    return upper, lower, down, up


@compiled
def most_at_start(slope, above, below, rows, y_low, y_high, most):
    """The largest x in 0 .. most for which some y keeps all lines; -1 if there is none.

    1. Where nothing limits x, from where the first line alone meets the set.
    2. Newton's steps from above, never too far: the gap is concave. Below zero, zero itself is looked at.

    Args:
        slope, above, below, rows: lines.
        y_low, y_high: the set at the interval's end.
        most: where the search begins.
    """
    x = most
    # 1.
    free = most >= FREE
    if any_lane(free):
        for k in range(rows):
            steep, rise, fall = slope[k], above[k], below[k]
            rising = free & (steep > 0.0) & (fall > -FREE)
            falling = free & (steep < 0.0) & (rise < FREE)
            divisor = where(rising | falling, steep, 1.0)
            meets = where(rising, y_high - fall, y_low - rise) / divisor
            x = where(rising | falling, lesser(meets, x), x)
    # 2.
    open_lanes = x == x
    for _ in range(MOST_STEPS):
        upper, lower, down, up = gap_at(slope, above, below, rows, y_low, y_high, x)
        missing = lower - upper
        open_lanes = open_lanes & (missing > 0.0)
        if not any_lane(open_lanes):
            return x
        step = missing / where(up > down, up - down, 1.0)
        rounding = (x == lanes(0.0)) & (missing <= (magnitude(lower) + magnitude(upper)) * ROUNDING)
        blocked = open_lanes & ((up <= down) | (x == lanes(0.0)))
        x = where(blocked, where(rounding, 0.0, -1.0), x)
        open_lanes = open_lanes & ~blocked & (step > x * ROUNDING)
        x = where(open_lanes, larger(x - step, lanes(0.0)), x)
    return x


@compiled
def least_at_start(slope, above, below, rows, y_low, y_high, most):
    """The least x in 0 .. most for which some y keeps all lines, given that there is one.

    Args:
        slope, above, below, rows, y_low, y_high: lines and y as in `gap_at`.
        most: the largest x.
    """
    x = lanes(0.0)
    open_lanes = most > 0.0
    for _ in range(MOST_STEPS):
        upper, lower, down, up = gap_at(slope, above, below, rows, y_low, y_high, x)
        missing = lower - upper
        open_lanes = open_lanes & (missing > 0.0) & (up < down)
        if not any_lane(open_lanes):
            return x
        step = missing / where(open_lanes, down - up, 1.0)
        open_lanes = open_lanes & (step > x * ROUNDING)
        x = where(open_lanes, lesser(x + step, most), x)
        open_lanes = open_lanes & (x < most)
    return x
