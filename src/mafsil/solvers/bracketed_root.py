"""The zero of a function between two places where its signs differ, to rounding."""

from __future__ import annotations

from collections.abc import Callable

from mafsil.solvers.tolerances import FEW_ROUNDINGS

MOST_CALLS, HALVED = 100, 8
"""Calls of the function, and each which of them halves the bracket, so that it cannot creep."""


def bracketed_root(g: Callable[[float], float], low: float, high: float) -> float:
    """Where a function changes its sign, seen from below: regula falsi (Illinois) kept in its bracket.

    Args:
        g: of one number in the order of one; its signs at both ends differ.
        low, high: the bracket.

    Returns:
        The upper end of the last bracket, on which g has the sign that it has at `high`, or an exact zero.
    """
    g_low, g_high = g(low), g(high)
    side = 0
    for count in range(MOST_CALLS):
        if high - low <= FEW_ROUNDINGS:
            break
        middle = (low * g_high - high * g_low) / (g_high - g_low) if g_low * g_high < 0.0 else high
        if not low < middle < high or count % HALVED == HALVED - 1:
            middle = (low + high) / 2.0
        value = g(middle)
        if value * g_high > 0.0:
            high, g_high = middle, value
            g_low = g_low / 2.0 if side < 0 else g_low
            side = -1
        else:
            low, g_low = middle, value
            g_high = g_high / 2.0 if side > 0 else g_high
            side = 1
            if value == 0.0:
                return middle
    return high
