"""Is the origin strictly inside a convex set of wrenches? One linear program; for round cones a few.

From a point c inside the hull of the columns, how far beyond the origin does the hull reach?

  max lambda  with  W x = -lambda c,  sum x = 1,  x >= 0

lambda > 0 proves closure by finitely many wrenches. The multipliers z (c . z = -1) bound lambda from above by the
support function h(z) of the whole set: h(z) < 0 proves that there is none, and y = -z is the certificate. Where the
bounds disagree, the support points along z are the next columns.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from mafsil.arrays import Floats, frozen
from mafsil.errors import MafsilError
from mafsil.grasp.ball import distance_to_hull
from mafsil.grasp.cone import RoundSet
from mafsil.solvers.linear_program import minimise

UNSURE = 1e-7
"""|lambda| below it is not decided here: HiGHS's own tolerance."""
ROUNDS = 100
QUICK = 12
"""Rounds of the quick way; what is still open then lies near the boundary."""
NEAR = 1e-5
"""Distances below it, relative to the wrenches, are left to the programs."""


@cache
def positive_weights(n: int) -> Floats:
    """(n,) reproducible weights in general position, about 1 each; read-only."""
    return frozen(np.random.default_rng(1986).uniform(0.5, 1.5, n))


@dataclass(frozen=True, eq=False)
class Enclosure:
    """What the programs proved.

    Attributes:
        lower, upper: bounds of lambda.
        columns: (m, n) wrenches used.
        combination: (n,) x > 0 with columns x = 0, if lower > 0; else the last x >= 0.
        certificate: (m,) y with y . w >= -upper for every wrench w of unit push.
        rounds: linear programs solved.
    """

    lower: float
    upper: float
    columns: Floats
    combination: Floats
    certificate: Floats
    rounds: int

    @property
    def decided(self) -> bool:
        """Whether the sign of lambda is certain."""
        return self.lower > UNSURE or self.upper < -UNSURE


def enclose(W: Floats, whole: RoundSet | None = None) -> Enclosure:
    """Bounds of lambda that decide its sign, or place it within UNSURE of zero.

    Args:
        W: (m, n) columns of rank m, of comparable size.
        whole: the set of which the columns are some; the columns are all if None.

    Raises:
        MafsilError: the bounds did not meet.
    """
    weights = positive_weights(W.shape[1])
    weights = weights / weights.sum()
    c = W @ weights
    found = _quick(W, c, weights, whole)
    if found is not None and found.decided:
        return found
    grown = W
    upper, lower = np.inf, -np.inf
    for rounds in range(1, ROUNDS + 1):
        x, lower, z = _shoot(grown, c)
        if whole is None:
            upper, fresh = lower, grown[:, :0]
        else:
            upper, fresh = whole.furthest(z)
        found = Enclosure(lower, upper, grown, x, -z, rounds)
        if found.decided or upper - lower <= UNSURE:
            return _strict(found, weights)
        grown = np.hstack([grown, fresh])
    raise MafsilError("solvers.budget_spent", iterations=ROUNDS, residual=upper - lower)


def positive_combination(W: Floats) -> Floats | None:
    """Weights x > 0 with W x = 0 and sum 1, by the compiled program alone; None if there is none, or if it is not sure.

    Args:
        W: (m, n) columns of any size.
    """
    from mafsil.solvers import positive_span_loops as program

    x, y = np.empty(W.shape[1]), np.empty(len(W))
    verdict = program.positive_span(np.ascontiguousarray(W), positive_weights(len(x)), UNSURE, x, y)
    return x if verdict == program.SPANS else None


def _quick(W: Floats, c: Floats, weights: Floats, whole: RoundSet | None) -> Enclosure | None:
    """Compiled phase one for a yes, the nearest point of the hull for a no; None near the boundary."""
    from mafsil.solvers import positive_span_loops as program

    grown = np.ascontiguousarray(W)
    for rounds in range(1, QUICK + 1):
        x, y = np.empty(grown.shape[1]), np.empty(len(W))
        if program.positive_span(grown, positive_weights(len(x)), UNSURE, x, y) == program.SPANS:
            share = float((x[: len(weights)] / weights).min())
            return Enclosure(share / (1.0 - share), np.inf, grown, x, y, rounds)
        distance, nearest = distance_to_hull(grown)
        if distance <= NEAR * float(np.abs(grown).max()):
            return None
        z = -nearest / (c @ nearest)
        upper, fresh = (float((z @ grown).max()), grown[:, :0]) if whole is None else whole.furthest(z)
        if upper < -UNSURE:
            return Enclosure(-np.inf, upper, grown, x, -z, rounds)
        grown = np.hstack([grown, fresh])
    return None


def _shoot(W: Floats, c: Floats) -> tuple[Floats, float, Floats]:
    """x, lambda and the multipliers z of one program."""
    m, n = W.shape
    A = np.vstack([np.column_stack([W, c]), np.append(np.ones(n), 0.0)])
    b = np.append(np.zeros(m), 1.0)
    best = minimise(np.append(np.zeros(n), -1.0), A, b, free=1)
    assert best is not None, "x = the weights of c and lambda = -1 is a solution"
    return best.x[:n], float(best.x[n]), best.equality[:m]


def _strict(found: Enclosure, weights: Floats) -> Enclosure:
    """W x = -lambda W w, so x + lambda w is positive and combines to zero; unused later columns go."""
    if found.lower <= 0:
        return found
    x = found.combination.copy()
    x[: len(weights)] += found.lower * weights
    used = (x > 0) | (np.arange(len(x)) < len(weights))
    x = x[used] / x[used].sum()
    return Enclosure(found.lower, found.upper, found.columns[:, used], x, found.certificate, found.rounds)
