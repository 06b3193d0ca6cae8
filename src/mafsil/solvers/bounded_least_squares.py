"""Least squares between bounds, by active sets: exact for a few unknowns."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
import scipy.optimize

from mafsil.arrays import Floats

EXACT = 1e-18
"""Change of the sum of squares, over itself, that ends the search."""


def bounded_least_squares(A: Floats, b: Floats, lower: Floats, upper: Floats) -> Floats:
    """The x (k,) with lower <= x <= upper and the least |A x - b|.

    Args:
        A: (m, k).
        b: (m,).
        lower, upper: (k,); equal ones hold an unknown.

    Reference: P. Stark, R. Parker, Bounded-variable least squares, Computational Statistics 10 (1995).
    """
    # The search asks for room between the bounds.
    above = np.where(upper > lower, upper, lower + 1e-12 * max(float(np.abs(lower).max(initial=0.0)), 1.0))
    solve = cast("Any", scipy.optimize).lsq_linear  # carries no types
    found = np.asarray(solve(A, b, (lower, above), method="bvls", tol=EXACT).x, dtype=np.float64)
    return np.clip(found, lower, upper)
