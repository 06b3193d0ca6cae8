"""Least squares between bounds, by active sets: exact for a few unknowns.

The shortest vector within linear inequalities, and what each of them pushes: least distance programming.
"""

from __future__ import annotations

from typing import Any, cast

import numpy as np
import scipy.optimize

from mafsil.arrays import Floats

ROUNDED = 1e-12
"""Of unit rows: what is that near to equality binds, and rows that are that near to each other depend on each other."""
EVENLY = 1e-7
"""Weight of multipliers in themselves, which makes them even where several fit; its square is the error."""
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


def least_distance(H: Floats, need: Floats) -> tuple[Floats, Floats]:
    """The shortest x (r,) with H x >= need, and multipliers p (k,) >= 0 with x = H' p, zero where a row does not bind.

    1. Which rows bind: a problem of non-negative least squares.
    2. x: the shortest with equality on them.
    3. p: where several fit, the most even one.

    Args:
        H: (k, r).
        need: (k,) that some x fulfils.

    Reference: Lawson and Hanson, Solving Least Squares Problems, ch. 23.
    """
    k, size = len(need), float(need.max())
    if size <= 0.0:
        return np.zeros(len(H.T)), np.zeros(k)
    lengths = np.linalg.norm(H, axis=1)
    lengths[lengths == 0.0] = 1.0
    H, goal = H / lengths[:, None], need / (lengths * size)
    binds = _non_negative(np.vstack([H.T, goal]), np.append(np.zeros(H.shape[1]), 1.0)) > 0.0  # 1
    x = np.asarray(np.linalg.lstsq(H[binds], goal[binds])[0], dtype=np.float64)  # 2
    binds |= np.abs(H @ x - goal) <= ROUNDED * float(np.linalg.norm(x))  # 3
    p, count, A = np.zeros(k), int(binds.sum()), H[binds].T
    if np.linalg.matrix_rank(A, tol=ROUNDED) == count:
        p[binds] = np.maximum(np.linalg.lstsq(A, x)[0], 0.0)
    else:
        p[binds] = _non_negative(np.vstack([A, EVENLY * np.eye(count)]), np.append(x, np.zeros(count)))
    return size * x, size * p / lengths


def _non_negative(A: Floats, b: Floats) -> Floats:
    """The least-squares solution of A x = b with x >= 0."""
    solve: Any = scipy.optimize.nnls  # carries no types
    return np.asarray(solve(A, b)[0], dtype=np.float64)
