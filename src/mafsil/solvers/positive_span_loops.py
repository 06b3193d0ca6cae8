"""Do the columns of a matrix span the space with positive weights? Phase one of the revised simplex method, compiled.

x = w + z with fixed positive w turns "x > 0 with A x = 0" into phase one for z >= 0, A z = -A w: an optimum of zero
gives x; any other has prices y with A' y >= 0, y != 0, which prove that there is none.

1. `normalise`: rows, then columns, get equal size; the level -A w is the right side.
2. `span`: artificial variables of cost 1 are the first basis; signs make all levels positive.
3. `phase_one`: prices of the basis; the column of greatest gain enters; the least ratio decides which variable leaves;
   the inverse of the basis is updated; and so on until no column gains.
4. An optimum of zero is a yes, if it is no rounding: the weights go back to the units of W (`read_weights`).
5. Round cones have no list of columns: the discs' furthest points along the prices are the next ones, and 3 again,
   until none lies beyond them (`further_columns`).
6. Else the answer is a no, certain only where the whole set is clearly away from the origin (`stands_apart`).

Reference:
    G. B. Dantzig, W. Orchard-Hays, The product form for the inverse in the simplex method, Math. Tables 8, 1954.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.kernels.loops.loop import compiled, reordered
from mafsil.solvers.disc_loops import Dimension, dot, reach
from mafsil.solvers.nearest_point_loops import lies_apart
from mafsil.solvers.tolerances import ENTERING, FULL_RANK, NEGLIGIBLE, PIVOT

ROUNDS = 24
"""Times that round cones are asked for more columns."""
SPANS, OPEN, DOUBTFUL = 1, 0, -1
"""Verdicts of `positive_span`."""


class Tableau(NamedTuple):
    """What the revised simplex method keeps.

    Attributes:
        A: (m, most) columns of length 1 in scaled rows.
        rows, sizes: (m,), (most,) the factors that made them from W, of rows and columns.
        level, basis: (m,) values and indices of the basic variables, most + i for the artificial one of row i.
        inverse: (m, m) of the basis.
        price, column: (m,) multipliers; the entering column.
        gain, keys: (most,) reduced gains, and the same bits as whole numbers.
        owner: (most,) the disc from which each further column is.
    """

    A: Floats
    rows: Floats
    sizes: Floats
    level: Floats
    basis: NDArray[np.int64]
    inverse: Floats
    price: Floats
    column: Floats
    gain: Floats
    keys: NDArray[np.int64]
    owner: NDArray[np.int64]


@compiled
def make_tableau(m: int, most: int) -> Tableau:
    """Buffers for matrices of m rows and up to `most` columns."""
    gain = np.empty(most)
    return Tableau(
        np.empty((m, most)), np.empty(m), np.empty(most), np.empty(m), np.empty(m, np.int64), np.empty((m, m)),
        np.empty(m), np.empty(m), gain, gain.view(np.int64), np.empty(most, np.int64),
    )  # fmt: skip


@reordered
def normalise(dimension: Dimension, W: Floats, weights: Floats, T: Tableau) -> None:
    """Rows, then columns, of equal size, for positive factors change no verdict; level = -A w.

    1. The size of a row is its largest element.
    2. Rows are divided by it, one that is negligible beside the others by the largest of all; squares of the columns.
    3. Columns are divided by their length; the level.

    Args:
        dimension: m zeros (see `disc_loops.Dimension`).
        W: (m, n).
        weights: (n,) w.
        T: tableau.
    """
    A, sizes, n, largest = T.A, T.sizes, W.shape[1], 0.0
    for j in range(n):
        sizes[j] = 0.0
    for i in range(len(dimension)):  # 1
        big = 0.0
        for j in range(n):
            big = max(big, abs(W[i, j]))
        T.rows[i] = big
        largest = max(largest, big)
    for i in range(len(dimension)):  # 2
        big = T.rows[i] if T.rows[i] > NEGLIGIBLE * largest else largest
        factor = 1.0 / big if big > 0.0 else 1.0
        T.rows[i] = factor
        for j in range(n):
            a = W[i, j] * factor
            A[i, j] = a
            sizes[j] += a * a
    for j in range(n):  # 3
        sizes[j] = 1.0 / np.sqrt(sizes[j]) if sizes[j] > 0.0 else 1.0
    for i in range(len(dimension)):
        total = 0.0
        for j in range(n):
            a = A[i, j] * sizes[j]
            A[i, j] = a
            total += a * weights[j]
        T.level[i] = -total


@compiled
def best_column(
    dimension: Dimension, n: int, mask: int, A: Floats, price: Floats, gain: Floats, keys: NDArray[np.int64]
) -> int:
    """The column of greatest gain price . A_j; its index rides in the lowest bits of the gain, so one pass finds it."""
    for j in range(n):
        gain[j] = price[0] * A[0, j]
        if len(dimension) > 1:
            gain[j] += price[1] * A[1, j]
    for k in range(2, len(dimension)):
        for j in range(n):
            gain[j] += price[k] * A[k, j]
    best = int(np.int64(-1) << np.int64(62))
    for j in range(n):
        best = max(best, (keys[j] & ~mask) | j)
    return best & mask


@compiled
def phase_one(dimension: Dimension, n: int, T: Tableau) -> bool:
    """Min sum of artificial s with A z + s = level >= 0, from the basis that is there: the revised simplex method.

    1. Prices by the inverse of the basis: an artificial variable in it costs 1, a column nothing.
    2. The column of greatest gain enters; if none gains, this is the optimum.
    3. That column in terms of the basis; the variable that reaches zero first leaves.
    4. The basis changes: one step of elimination on its inverse and on the levels.

    Args:
        dimension: m zeros (see `disc_loops.Dimension`).
        n: columns.
        T: tableau.

    Returns:
        Whether an optimum was reached before the steps ran out.
    """
    level, basis, inverse, price, column = T.level, T.basis, T.inverse, T.price, T.column
    A, gain, keys, most, mask = T.A, T.gain, T.keys, T.A.shape[1], 1
    while mask < n:
        mask *= 2
    mask -= 1
    for _ in range(20 * (len(dimension) + n)):
        for k in range(len(dimension)):  # 1
            price[k] = 0.0
        for i in range(len(dimension)):
            if basis[i] >= most:
                for k in range(len(dimension)):
                    price[k] += inverse[i, k]
        enter = best_column(dimension, n, mask, A, price, gain, keys)  # 2
        if not gain[enter] > ENTERING:
            return True
        leave, least = -1, np.inf  # 3
        for i in range(len(dimension)):
            total = 0.0
            for k in range(len(dimension)):
                total += inverse[i, k] * A[k, enter]
            column[i] = total
            if total > PIVOT:
                ratio = max(level[i], 0.0) / total
                if ratio < least:
                    leave, least = i, ratio
        if leave < 0:
            return False
        factor = 1.0 / column[leave]  # 4
        for k in range(len(dimension)):
            inverse[leave, k] *= factor
        for i in range(len(dimension)):
            if i != leave:
                level[i] -= column[i] * least
                for k in range(len(dimension)):
                    inverse[i, k] -= column[i] * inverse[leave, k]
        level[leave] = least
        basis[leave] = enter
    return False


@compiled
def further_columns(dimension: Dimension, D: Floats, more: Floats, first: int, n: int, T: Tableau) -> int:
    """Add the furthest point of each disc that lies beyond the prices; the number of columns then.

    1. Prices in the units of the discs.
    2. The furthest point of each disc along them, scaled as the columns are.
    3. A point with a gain becomes a column.
    """
    m, q = len(dimension), np.empty(len(dimension))
    for c in range(m):  # 1
        q[c] = T.price[c] * T.rows[c]
    for i in range(len(D)):
        w = np.zeros(m)  # 2
        reach(D[i], q, w)
        square = 0.0
        for c in range(m):
            square += (w[c] * T.rows[c]) ** 2
        size = 1.0 / np.sqrt(square) if square > 0.0 else 1.0
        if dot(q, w) * size > ENTERING and n < T.A.shape[1]:  # 3
            for c in range(m):
                more[c, n - first] = w[c]
                T.A[c, n] = w[c] * T.rows[c] * size
            T.sizes[n], T.owner[n] = size, i
            n += 1
    return n


@compiled
def span(
    dimension: Dimension,
    W: Floats,
    D: Floats,
    more: Floats,
    weights: Floats,
    doubt: float,
    x: Floats,
    y: Floats,
    T: Tableau,
) -> tuple[int, int]:
    """Verdict on some columns and the discs on which they lie, with its proof in x or y.

    Args:
        dimension: m zeros (see `disc_loops.Dimension`).
        W: (m, n).
        D: (k, parts, m) discs, none if the columns are all there is.
        more: (m, most - n) out: columns that the discs give beside.
        weights: (n,) positive.
        doubt: optima within a factor 100 of it are DOUBTFUL.
        x: (most,) out: > 0 on the n columns, >= 0 on later ones, W x = 0, sum 1, if SPANS.
        y: (m,) out: of length 1 with W' y >= 0 if OPEN and there are no discs; else `stands_apart` gives it.
        T: for (m, most).

    Returns:
        SPANS, OPEN or DOUBTFUL, and the number of columns then.
    """
    m, first, n = len(dimension), W.shape[1], W.shape[1]
    normalise(dimension, W, weights, T)  # 1
    for i in range(m):  # 2
        if not np.isfinite(T.level[i]):
            return DOUBTFUL, n
        sign = -1.0 if T.level[i] < 0.0 else 1.0
        for k in range(m):
            T.inverse[i, k] = 0.0
        T.inverse[i, i] = sign
        T.level[i] *= sign
        T.basis[i] = T.A.shape[1] + i
    for turn in range(ROUNDS):
        if not phase_one(dimension, n, T):  # 3
            return DOUBTFUL, n
        value = 0.0
        for i in range(m):
            if T.basis[i] >= T.A.shape[1]:
                value += max(T.level[i], 0.0)
        if value <= 0.01 * doubt:
            return read_weights(first, n, weights, doubt, x, T), n  # 4
        if turn == 0 and len(D) > 0 and lies_apart(D * T.rows, T.column):
            # Most sets that are open show it at once, long before the prices are exact.
            return OPEN, n
        grown = further_columns(dimension, D, more, first, n, T)  # 5
        if grown == n:
            return read_prices(value, doubt, y, T), n  # 6
        n = grown
    return DOUBTFUL, n


@compiled
def read_prices(value: float, doubt: float, y: Floats, T: Tableau) -> int:
    """The verdict that a positive optimum means, and y in the units of W."""
    square = 0.0
    for i in range(len(y)):
        y[i] = -T.price[i] * T.rows[i]
        square += y[i] * y[i]
    factor = 1.0 / max(np.sqrt(square), LEAST_DIVISOR)
    for i in range(len(y)):
        y[i] *= factor
    return OPEN if value >= 100.0 * doubt else DOUBTFUL


@reordered
def read_weights(first: int, n: int, weights: Floats, doubt: float, x: Floats, T: Tableau) -> int:
    """The verdict that an optimum of zero means, and x in the units of W.

    1. Every first column has its own weight, in the units of W.
    2. The basis adds its levels; an artificial variable in it means that the columns may lie in a hyperplane.
    3. Sum 1; where that takes too large a number, the verdict is doubtful.
    """
    full, total, scaled = True, 0.0, 0.0
    for j in range(first):  # 1
        total += weights[j]
        x[j] = weights[j] * T.sizes[j]
        scaled += x[j]
    for j in range(first, n):
        x[j] = 0.0
    for i in range(len(T.basis)):  # 2
        j = T.basis[i]
        if j >= n:
            full = False
        else:
            more = max(T.level[i], 0.0)
            total += more
            x[j] += more * T.sizes[j]
            scaled += more * T.sizes[j]
    factor = 1.0 / scaled  # 3
    for j in range(n):
        x[j] *= factor
    return SPANS if full and total <= 1.0 / doubt else DOUBTFUL


@reordered
def has_full_rank(dimension: Dimension, n: int, T: Tableau) -> bool:
    """Whether the normalised columns surely span the space: det(A A') is far from zero.

    1. The Gram matrix A A' of unit columns.
    2. Its determinant as the product of pivots, each over the mean of the diagonal.
    """
    m = len(dimension)
    G = np.empty((m, m))
    for a in range(m):  # 1
        for b in range(a + 1):
            total = 0.0
            for j in range(n):
                total += T.A[a, j] * T.A[b, j]
            G[a, b] = total
    share, mean = 1.0, n / m  # 2
    for k in range(m):
        share *= G[k, k] / mean
        if not share > FULL_RANK:
            return False
        for a in range(k + 1, m):
            factor = G[a, k] / G[k, k]
            for b in range(k + 1, a + 1):
                G[a, b] -= factor * G[b, k]
    return True


@compiled
def stands_apart(dimension: Dimension, D: Floats, n: int, y: Floats, T: Tableau) -> bool:
    """Is the set clearly away from the origin, which may lie on its boundary for all that the program says?

    Args:
        dimension: m zeros (see `disc_loops.Dimension`).
        D: (k, parts, m) discs in scaled rows.
        n: columns; they must surely span the space with signs.
        y: (m,) out: of length 1 with y . w > 0 on the whole set, if so.
        T: as the program left it.
    """
    if not has_full_rank(dimension, n, T):
        return False
    if not lies_apart(D, y):
        return False
    square = 0.0
    for i in range(len(y)):
        y[i] *= T.rows[i]
        square += y[i] * y[i]
    for i in range(len(y)):
        y[i] /= np.sqrt(square)
    return True


@compiled
def positive_span(dimension: Dimension, W: Floats, weights: Floats, doubt: float, x: Floats, y: Floats) -> int:
    """Verdict on one matrix of finitely many columns; OPEN only as `stands_apart` says.

    Args:
        dimension: m zeros (see `disc_loops.Dimension`).
        W: (m, n).
        weights, doubt, x, y: as in `span`.
    """
    m, n = W.shape
    T = make_tableau(m, n)
    verdict, _ = span(dimension, W, np.empty((0, 1, m)), np.empty((m, 0)), weights, doubt, x, y, T)
    if verdict != OPEN:
        return verdict
    D = np.empty((n, 1, m))
    for j in range(n):
        for i in range(m):
            D[j, 0, i] = T.A[i, j]
    return OPEN if stands_apart(dimension, D, n, y, T) else DOUBTFUL


@compiled
def positive_span_of_discs(
    dimension: Dimension, D: Floats, W: Floats, more: Floats, weights: Floats, doubt: float, x: Floats, y: Floats
) -> tuple[int, int]:
    """Verdict on the hull of discs; OPEN only as `stands_apart` says.

    Args:
        dimension: m zeros (see `disc_loops.Dimension`).
        D: (k, parts, m) discs.
        W: (m, n) columns on them that span their space.
        more: (m, most - n) out.
        weights, doubt, x, y: as in `span`.

    Returns:
        The verdict and the number of columns that W and more and x have then.
    """
    T = make_tableau(len(dimension), W.shape[1] + more.shape[1])
    verdict, n = span(dimension, W, D, more, weights, doubt, x, y, T)
    if verdict != OPEN:
        return verdict, n
    return (OPEN if stands_apart(dimension, D * T.rows, n, y, T) else DOUBTFUL), n


@compiled
def positive_spans(
    dimension: Dimension, W: Floats, weights: Floats, doubt: float, x: Floats, y: Floats, verdict: Floats
) -> None:
    """The verdict on each matrix of a batch, flat ones included.

    Args:
        dimension: m zeros (see `disc_loops.Dimension`).
        W: (b, m, n).
        weights: (n,).
        doubt: as in `span`.
        x, y: (b, n), (b, m) out.
        verdict: (b,) out, as floats.
    """
    b, m, n = W.shape
    T, none, more = make_tableau(m, n), np.empty((0, 1, m)), np.empty((m, 0))
    for k in range(b):
        verdict[k] = span(dimension, W[k], none, more, weights, doubt, x[k], y[k], T)[0]
        for j in range(n if verdict[k] != SPANS else 0):
            x[k, j] = np.nan
        for i in range(m if verdict[k] != OPEN else 0):
            y[k, i] = np.nan
