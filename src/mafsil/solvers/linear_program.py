"""Optimisation under bounds, thin over SciPy: linear programs by HiGHS, least squares by active sets.

Every answer of a linear program comes with its multipliers, every refusal with its reason.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from mafsil.arrays import Floats
from mafsil.errors import MafsilError
from mafsil.floating_point import LEAST_DIVISOR

ROUNDED = 1e-12
"""Of unit rows: what is that near to equality binds, and rows that are that near to each other depend on each other."""
EVENLY = 1e-7
"""Weight of multipliers in themselves, which makes them even where several fit; its square is the error."""
EXACT = 1e-18
"""Change of the sum of squares, over itself, that ends the search."""


def _optimiser(name: str) -> Any:
    """Of SciPy, whose results carry no types and which is long to load."""
    import scipy.optimize

    return getattr(scipy.optimize, name)


@dataclass(frozen=True, eq=False)
class LinearAnswer:
    """Optimum of a linear program.

    Attributes:
        x: (n,) the minimiser.
        value: c . x.
        equality: (m,) multipliers of A x = b: change of the value per change of b.
        inequality: (k,) multipliers (<= 0) of G x <= h.
    """

    x: Floats
    value: float
    equality: Floats
    inequality: Floats


@dataclass(frozen=True, eq=False)
class NonnegativeAnswer:
    """Either x >= 0 with A x = b, or a vector that proves that there is none.

    Attributes:
        x: (n,) cheapest solution, or None.
        certificate: (m,) y with A' y >= 0 and y . b < 0, or None.
        cost: c . x, infinite without a solution.
        multipliers: (m,) of A x = b at the optimum: c - A' y >= 0; zero without a solution.
        residual: least sum of |A x - b| over x >= 0.
    """

    x: Floats | None
    certificate: Floats | None
    cost: float
    multipliers: Floats
    residual: float


def minimise(
    c: Floats,
    A: Floats | None = None,
    b: Floats | None = None,
    G: Floats | None = None,
    h: Floats | None = None,
    free: int = 0,
) -> LinearAnswer | None:
    """Min c . x with A x = b, G x <= h, x >= 0 except for the last `free` unknowns.

    Args:
        c: (n,) costs.
        A, b: (m, n), (m,) equalities, or None.
        G, h: (k, n), (k,) inequalities, or None.
        free: how many of the last unknowns may be negative.

    Returns:
        The optimum, or None if the constraints contradict each other.

    Raises:
        MafsilError: unbounded, or HiGHS gave up.
    """
    bounds = [(0.0, None)] * (len(c) - free) + [(None, None)] * free
    solve = _optimiser("linprog")
    found: Any = solve(c, A_ub=G, b_ub=h, A_eq=A, b_eq=b, bounds=bounds, method="highs")
    if found.status == 2:
        return None
    if found.status != 0:
        raise MafsilError("solvers.linear_program", reason=str(found.message))
    return LinearAnswer(
        np.asarray(found.x), float(found.fun), np.asarray(found.eqlin.marginals), np.asarray(found.ineqlin.marginals)
    )


def nonnegative_solution(A: Floats, b: Floats, c: Floats | None = None, tolerance: float = 1e-9) -> NonnegativeAnswer:
    """Find x >= 0 with A x = b, the cheapest for the costs c, or Farkas' certificate against it.

    Args:
        A: (m, n).
        b: (m,).
        c: (n,) costs; the sum of x if None.
        tolerance: of the residual, relative to |b|, up to which A x = b counts as met.

    Reference:
        J. Farkas, Theorie der einfachen Ungleichungen, J. reine angew. Math. 124, 1902.
    """
    m: int = A.shape[0]
    n: int = A.shape[1]
    slack = np.hstack([A, np.eye(m), -np.eye(m)])
    nearest = minimise(np.concatenate([np.zeros(n), np.ones(2 * m)]), slack, b)
    assert nearest is not None, "slack variables reach every right side"
    scale = max(float(np.abs(b).max(initial=0.0)), LEAST_DIVISOR)
    if nearest.value > tolerance * scale:
        return NonnegativeAnswer(None, -nearest.equality, np.inf, np.zeros(m), nearest.value)
    costs: Floats = np.ones(n) if c is None else c
    best = minimise(costs, A, b)
    if best is None:
        x = nearest.x[:n]
        return NonnegativeAnswer(x, None, float(costs @ x), np.zeros(m), nearest.value)
    return NonnegativeAnswer(best.x, None, best.value, best.equality, nearest.value)


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
    solve = _optimiser("lsq_linear")
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
    solve = _optimiser("nnls")
    return np.asarray(solve(A, b)[0], dtype=np.float64)
