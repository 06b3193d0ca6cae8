"""Do the columns of a matrix span the space with positive weights? Phase one of the simplex method, compiled.

x = w + z with fixed positive w turns "x > 0 with A x = 0" into phase one for z >= 0, A z = -A w: an optimum of zero
gives x; any other has prices y with A' y >= 0, y != 0, which prove that there is none.
"""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats
from mafsil.solvers.loops import compiled

ENTERING = 1e-9
PIVOT = 1e-9
SPANS, OPEN, DOUBTFUL = 1, 0, -1
"""Verdicts of `positive_span`."""


@compiled
def normalise(W: Floats, A: Floats, rows: Floats, sizes: Floats) -> None:
    """Rows, then columns, of equal size: positive factors change no verdict.

    Args:
        W: (m, n).
        A: (m, n) out.
        rows, sizes: (m,), (n,) the factors, out.
    """
    m, n = W.shape
    for i in range(m):
        rows[i] = 0.0
        for j in range(n):
            rows[i] = max(rows[i], abs(W[i, j]))
        if rows[i] == 0.0:
            rows[i] = 1.0
        for j in range(n):
            A[i, j] = W[i, j] / rows[i]
    for j in range(n):
        square = 0.0
        for i in range(m):
            square += A[i, j] * A[i, j]
        sizes[j] = np.sqrt(square) if square > 0.0 else 1.0
        for i in range(m):
            A[i, j] /= sizes[j]


@compiled
def phase_one(A: Floats, level: Floats, basis: Floats, inverse: Floats, price: Floats, gain: Floats) -> bool:
    """Min sum of artificial s with A z + s = level >= 0, from s = level; all arrays but A are changed in place.

    Args:
        A: (m, n).
        level: (m,) values of the basic variables.
        basis: (m,) their indices as floats, n + i for the artificial one of row i.
        inverse: (m, m) of the basis.
        price: (m,) multipliers.
        gain: (n,) room.

    Returns:
        Whether an optimum was reached before the steps ran out.
    """
    m, n = A.shape
    column = np.empty(m)
    for _ in range(20 * (m + n)):
        for k in range(m):
            price[k] = 0.0
        for i in range(m):
            if basis[i] >= n:
                for k in range(m):
                    price[k] += inverse[i, k]
        for j in range(n):
            gain[j] = price[0] * A[0, j]
        for k in range(1, m):
            for j in range(n):
                gain[j] += price[k] * A[k, j]
        enter = 0
        for j in range(1, n):
            if gain[j] > gain[enter]:
                enter = j
        if not gain[enter] > ENTERING:
            return True
        leave, least = -1, np.inf
        for i in range(m):
            total = 0.0
            for k in range(m):
                total += inverse[i, k] * A[k, enter]
            column[i] = total
            if total > PIVOT:
                ratio = max(level[i], 0.0) / total
                if ratio < least:
                    leave, least = i, ratio
        if leave < 0:
            return False
        for k in range(m):
            inverse[leave, k] /= column[leave]
        for i in range(m):
            if i != leave:
                level[i] -= column[i] * least
                for k in range(m):
                    inverse[i, k] -= column[i] * inverse[leave, k]
        level[leave] = least
        basis[leave] = enter
    return False


@compiled
def positive_span(W: Floats, weights: Floats, doubt: float, x: Floats, y: Floats) -> int:
    """Verdict on one matrix, with its proof in x or y.

    Args:
        W: (m, n).
        weights: (n,) positive.
        doubt: optima within a factor 100 of it are DOUBTFUL.
        x: (n,) out: > 0 with W x = 0 and sum 1 if SPANS.
        y: (m,) out: of length 1 with W' y >= 0 if OPEN.

    Returns:
        SPANS, OPEN or DOUBTFUL.
    """
    m, n = W.shape
    A, rows, sizes = np.empty((m, n)), np.empty(m), np.empty(n)
    normalise(W, A, rows, sizes)
    level, sign, basis = np.zeros(m), np.empty(m), np.empty(m)
    for i in range(m):
        for j in range(n):
            level[i] -= A[i, j] * weights[j]
        sign[i] = -1.0 if level[i] < 0.0 else 1.0
        level[i] *= sign[i]
        basis[i] = n + i
        for j in range(n):
            A[i, j] *= sign[i]
    price, inverse = np.empty(m), np.eye(m)
    ended = phase_one(A, level, basis, inverse, price, np.empty(n))
    return _read(ended, level, basis, price, sign, rows, sizes, weights, doubt, x, y)


@compiled
def _read(
    ended: bool, level: Floats, basis: Floats, price: Floats, sign: Floats, rows: Floats, sizes: Floats,
    weights: Floats, doubt: float, x: Floats, y: Floats,
) -> int:  # fmt: skip
    """The verdict that an optimum means, and x or y in the units of W."""
    m, n = len(level), len(weights)
    value, full = 0.0, True
    for j in range(n):
        x[j] = weights[j]
    for i in range(m):
        if not np.isfinite(level[i]):
            return DOUBTFUL
        if basis[i] >= n:
            value += max(level[i], 0.0)
            full = False
        else:
            x[int(basis[i])] += max(level[i], 0.0)
    total, scaled = 0.0, 0.0
    for j in range(n):
        total += x[j]
        x[j] /= sizes[j]
        scaled += x[j]
    for j in range(n):
        x[j] /= scaled
    square = 0.0
    for i in range(m):
        y[i] = -price[i] * sign[i] / rows[i]
        square += y[i] * y[i]
    for i in range(m):
        y[i] /= max(np.sqrt(square), 1e-300)
    if not ended or 0.01 * doubt < value < 100.0 * doubt:
        return DOUBTFUL
    if value >= doubt:
        return OPEN
    return SPANS if full and total <= 1.0 / doubt else DOUBTFUL


@compiled
def positive_spans(W: Floats, weights: Floats, doubt: float, x: Floats, y: Floats, verdict: Floats) -> None:
    """`positive_span` of each matrix of a batch.

    Args:
        W: (b, m, n).
        weights: (n,).
        doubt: as there.
        x, y: (b, n), (b, m) out.
        verdict: (b,) out, as floats.
    """
    for k in range(len(W)):
        verdict[k] = positive_span(W[k], weights, doubt, x[k], y[k])
