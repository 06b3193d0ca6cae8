"""Time-optimal path velocities by reachability: a pass backward, a greedy pass forward, compiled.

Between two places of the grid, with x and y the squares of the path velocity at its ends, all limits are rows
low <= alpha x + beta y <= high, besides 0 <= x <= cap.

1. Backward: the x from which the end can still be reached are an interval, found by two linear programs in (x, y).
2. Forward: always the largest y that the rows and the set allow.

A program in two variables is solved by Newton's method on the gap between the least upper and the greatest lower line
over x: the gap is concave and piecewise linear, so a few steps find its root exactly.

Reference: Pham and Pham, A New Approach to Time-Optimal Path Parameterization Based on Reachability Analysis, 2018.
Imported only where a path is timed: numba is loaded with it.
"""

# pyright: reportMissingParameterType=false, reportUnknownVariableType=false, reportUnknownParameterType=false
# pyright: reportUnknownMemberType=false, reportUnknownArgumentType=false
from __future__ import annotations

from mafsil.solvers.lane_loops import buffer, get, lanes, seen, where
from mafsil.solvers.loops import compiled, reordered
from mafsil.trajectory.path_rows_loops import FREE

MOST_STEPS = 60
SLIP = 1e-12
"""Relative gap that is rounding."""


@reordered
def gap_at(slope, above, below, y_low, y_high, x):
    """Least upper and greatest lower bound of y at x, and the slopes of both: in lanes, then among the lanes.

    Args:
        slope, above, below: (m,) the lines below <= y - slope x <= above; m is a multiple of 8.
        y_low, y_high: y that holds without lines.
        x: where.
    """
    upper, lower, down, up = lanes(y_high), lanes(y_low), lanes(0.0), lanes(0.0)
    for k in range(len(slope) // 8):
        steep = seen(slope)[k]
        base = steep * x
        over, under = base + seen(above)[k], base + seen(below)[k]
        lesser, greater = over < upper, under > lower
        upper, down = where(lesser, over, upper), where(lesser, steep, down)
        lower, up = where(greater, under, lower), where(greater, steep, up)
    rows = buffer(4)
    rows[0], rows[1], rows[2], rows[3] = upper, down, lower, up
    high, fall, low, rise = y_high, 0.0, y_low, 0.0
    for k in range(8):
        if get(rows, 0, k) < high:
            high, fall = get(rows, 0, k), get(rows, 1, k)
        if get(rows, 2, k) > low:
            low, rise = get(rows, 2, k), get(rows, 3, k)
    return high, low, fall, rise


@compiled
def most_at_start(slope, above, below, y_low, y_high, most):
    """The largest x in 0 .. most for which some y keeps all lines; -1 if there is none.

    Args:
        slope, above, below: (rows,) lines.
        y_low, y_high: the set at the interval's end.
        most: where the search begins.
    """
    x = most
    if most >= FREE:
        for k in range(len(slope)):
            if slope[k] > 0.0 and below[k] > -FREE:
                x = min(x, (y_high - below[k]) / slope[k])
            elif slope[k] < 0.0 and above[k] < FREE:
                x = min(x, (y_low - above[k]) / slope[k])
    for _ in range(MOST_STEPS):
        upper, lower, down, up = gap_at(slope, above, below, y_low, y_high, x)
        if upper >= lower:
            return x
        if up <= down:
            return 0.0 if x == 0.0 and lower - upper <= SLIP * (abs(lower) + abs(upper)) else -1.0
        step = (lower - upper) / (up - down)
        if step <= SLIP * x:
            return x
        x -= step
        if x < 0.0:
            upper, lower, _, _ = gap_at(slope, above, below, y_low, y_high, 0.0)
            return 0.0 if upper >= lower else -1.0
    return x


@compiled
def least_at_start(slope, above, below, y_low, y_high, most):
    """The least x in 0 .. most for which some y keeps all lines, given that there is one.

    Args:
        slope, above, below, y_low, y_high: lines and y as in `gap_at`.
        most: the largest x.
    """
    x = 0.0
    for _ in range(MOST_STEPS):
        upper, lower, down, up = gap_at(slope, above, below, y_low, y_high, x)
        if upper >= lower or up >= down:
            return x
        step = (lower - upper) / (down - up)
        if step <= SLIP * x:
            return x
        x += step
        if x >= most:
            return most
    return x


@compiled
def passes(slope, above, below, most, start, end, resting, low, high, x):
    """Both passes over one path, in place.

    Args:
        slope, above, below: (intervals, rows) lines of each interval.
        most: (intervals + 1,) the largest squares of the path velocity at the places.
        start, end: squares of the path velocity at both ends; negative where any will do.
        resting: whether every row allows rest: from where rest can be reached, zero is the least velocity.
        low, high: (intervals + 1,) receives the sets from which the end can be reached.
        x: (intervals + 1,) receives the squares of the time-optimal path velocity.

    Returns:
        -1, or the number of the place from which the end cannot be reached; of the start if that is too fast or slow.
    """
    N = len(most) - 1
    low[:] = 0.0
    low[N], high[N] = max(end, 0.0), end if end >= 0.0 else most[N]
    if high[N] > most[N] * (1.0 + SLIP):
        return N
    # 1.
    for i in range(N - 1, -1, -1):
        high[i] = most_at_start(slope[i], above[i], below[i], low[i + 1], high[i + 1], most[i])
        if high[i] < 0.0:
            return i
        if low[i + 1] > 0.0 or not resting:
            low[i] = least_at_start(slope[i], above[i], below[i], low[i + 1], high[i + 1], high[i])
    # 2.
    x[0] = start if start >= 0.0 else high[0]
    if not low[0] * (1.0 - SLIP) <= x[0] <= high[0] * (1.0 + SLIP):
        return 0
    for i in range(N):
        upper, lower, _, _ = gap_at(slope[i], above[i], below[i], low[i + 1], high[i + 1], x[i])
        x[i + 1] = max(upper, min(lower, high[i + 1]), 0.0) if upper < lower else upper
    return -1
