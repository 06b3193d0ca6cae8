"""Elementary functions on all lanes at once, in IR arithmetic alone; ULP says how far each may be from the truth.

All are branch-free, but for huge angles, and pass NaN on. A row's result does not depend on the lanes
beside it. On targets without fused multiply-add the same bounds hold. All but sin and tan keep the sign of a zero.

Reference: Muller et al., Handbook of Floating-Point Arithmetic, 2018.
"""

from __future__ import annotations

from collections.abc import Callable

from mafsil.kernels.exponential import exp, log, pow, tanh
from mafsil.kernels.trigonometric import acos, asin, atan, atan2, sincos, tan

ULP = {
    "sin": 1.0, "cos": 1.0, "tan": 1.0, "asin": 1.0, "acos": 1.0, "atan": 1.5, "atan2": 2.0,
    "exp": 1.0, "log": 1.0, "pow": 1.0, "tanh": 2.0,
}  # fmt: skip
"""Largest distance from the exact value, in units of its last place; proven by samples against mpmath in the tests."""

FUNCTIONS: dict[str, Callable[..., str]] = {
    function.__name__: function for function in (acos, asin, atan, atan2, exp, log, pow, tan, tanh)
}
"""Functions by the operation's name: (lanes, names of the arguments) -> name of the result."""

__all__ = ["FUNCTIONS", "ULP", "sincos"]
