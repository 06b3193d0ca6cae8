"""Linear programs, thin over HiGHS of scipy: every answer with its multipliers, every refusal with a certificate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from mafsil.arrays import Floats
from mafsil.errors import MafsilError
from mafsil.floating_point import LEAST_DIVISOR


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
    import scipy.optimize

    bounds = [(0.0, None)] * (len(c) - free) + [(None, None)] * free
    solve: Any = scipy.optimize.linprog  # its result carries no types
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
