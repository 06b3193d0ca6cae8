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

from mafsil.solvers.loops import compiled
from mafsil.trajectory.path_rows_loops import FREE, STEEP

MOST_STEPS = 60
SLIP = 1e-12
"""Relative gap that is rounding."""


@compiled
def as_lines(alpha, beta, low, high, y_cap, slope, above, below):
    """Rows as bounds of y over x,  slope x + below <= y <= slope x + above, in place.

    Args:
        alpha, beta, low, high: (rows,).
        y_cap: the largest y, for rows that hardly speak about it.
        slope, above, below: (rows,) lines.

    Returns:
        The largest x that rows without y allow.
    """
    most = FREE
    for k in range(len(alpha)):
        a, b = alpha[k], beta[k]
        if abs(b) <= STEEP * abs(a) or b == 0.0:
            slope[k], above[k], below[k] = 0.0, FREE, -FREE
            if a != 0.0:
                bound = high[k] if a > 0.0 else -low[k]
                spare = min(abs(b) * y_cap, 0.5 * bound)
                most = min(most, (bound - spare) / abs(a))
        else:
            slope[k] = -a / b
            if b > 0.0:
                above[k], below[k] = high[k] / b, low[k] / b
            else:
                above[k], below[k] = low[k] / b, high[k] / b
    return most


@compiled
def gap_at(slope, above, below, y_low, y_high, x):
    """Least upper and greatest lower bound of y at x, and the slopes of both."""
    upper, lower, down, up = y_high, y_low, 0.0, 0.0
    for k in range(len(slope)):
        base = slope[k] * x
        if base + above[k] < upper:
            upper, down = base + above[k], slope[k]
        if base + below[k] > lower:
            lower, up = base + below[k], slope[k]
    return upper, lower, down, up


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
    """The least x in 0 .. most for which some y keeps all lines, given that there is one."""
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
def passes(slope, above, below, most, start, end, low, high, x):
    """Both passes over one path, in place.

    Args:
        slope, above, below: (intervals, rows) lines of each interval.
        most: (intervals + 1,) the largest squares of the path velocity at the places.
        start, end: squares of the path velocity at both ends; negative where any will do.
        low, high: (intervals + 1,) receives the sets from which the end can be reached.
        x: (intervals + 1,) receives the squares of the time-optimal path velocity.

    Returns:
        -1, or the number of the place from which the end cannot be reached; of the start if that is too fast or slow.
    """
    N = len(most) - 1
    low[N], high[N] = max(end, 0.0), end if end >= 0.0 else most[N]
    if high[N] > most[N] * (1.0 + SLIP):
        return N
    # 1.
    for i in range(N - 1, -1, -1):
        high[i] = most_at_start(slope[i], above[i], below[i], low[i + 1], high[i + 1], most[i])
        if high[i] < 0.0:
            return i
        low[i] = least_at_start(slope[i], above[i], below[i], low[i + 1], high[i + 1], high[i])
    # 2.
    x[0] = start if start >= 0.0 else high[0]
    if not low[0] * (1.0 - SLIP) <= x[0] <= high[0] * (1.0 + SLIP):
        return 0
    for i in range(N):
        upper, lower, _, _ = gap_at(slope[i], above[i], below[i], low[i + 1], high[i + 1], x[i])
        x[i + 1] = max(upper, min(lower, high[i + 1]), 0.0) if upper < lower else upper
    return -1
