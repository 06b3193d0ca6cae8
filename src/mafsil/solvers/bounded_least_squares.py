"""The least-squares solution of linear equations within bounds."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
import scipy.optimize

from mafsil.arrays import Floats


def bounded_least_squares(A: Floats, b: Floats, low: Floats, high: Floats, tolerance: float) -> Floats:
    """The x (m,) within bounds with the smallest |A x - b|, by active sets: exact to rounding.

    Args:
        A, b: (n, m), (n,).
        low, high: (m,) bounds, low below high.
        tolerance: share of |A x - b| by which a step has to improve it.
    """
    solve = cast("Any", scipy.optimize).lsq_linear  # carries no types
    return np.asarray(solve(A, b, (low, high), method="bvls", tol=tolerance).x, dtype=np.float64)
