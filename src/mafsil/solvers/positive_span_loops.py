"""Do the columns of a matrix span the space with positive weights? Phase one of the simplex method, compiled.

x = w + z with fixed positive w turns "x > 0 with A x = 0" into phase one for z >= 0, A z = -A w: an optimum of zero
gives x; any other has prices y with A' y >= 0, y != 0, which prove that there is none.

Round cones have no list of columns: the discs' furthest points along the prices are the next ones, until none lies
beyond them. Every function takes a tuple of m zeros: its length is known when the loops are compiled, so they unroll.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.solvers.disc_loops import dot, reach
from mafsil.solvers.loops import compiled, reordered
from mafsil.solvers.nearest_point_loops import lies_apart

ENTERING = 1e-9
PIVOT = 1e-9
ROUNDS = 24
"""Times that round cones are asked for more columns."""
SPANS, OPEN, DOUBTFUL = 1, 0, -1
"""Verdicts of `positive_span`."""
NOISE = 1e-14
"""Rows below this share of the largest are rounding and stay small."""
FULL_RANK = 1e-14
"""Least det(A A') / (trace / m)^m that is surely full rank."""


class Room(NamedTuple):
    """Arrays of one simplex tableau.

    Attributes:
        A: (m, most) columns of length 1 in scaled rows.
        rows, sizes: (m,), (most,) the factors that made them from W.
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
def make_room(m: int, most: int) -> Room:
    """Room for matrices of m rows and up to `most` columns."""
    gain = np.empty(most)
    return Room(
        np.empty((m, most)), np.empty(m), np.empty(most), np.empty(m), np.empty(m, np.int64), np.empty((m, m)),
        np.empty(m), np.empty(m), gain, gain.view(np.int64), np.empty(most, np.int64),
    )  # fmt: skip


@reordered
def normalise(unroll: tuple[int, ...], W: Floats, weights: Floats, R: Room) -> None:
    """Rows, then columns, of equal size, for positive factors change no verdict; level = -A w.

    Args:
        unroll: m zeros.
        W: (m, n).
        weights: (n,) w.
        R: room.
    """
    A, sizes, n, largest = R.A, R.sizes, W.shape[1], 0.0
    for j in range(n):
        sizes[j] = 0.0
    for i in range(len(unroll)):
        big = 0.0
        for j in range(n):
            big = max(big, abs(W[i, j]))
        R.rows[i] = big
        largest = max(largest, big)
    for i in range(len(unroll)):
        big = R.rows[i] if R.rows[i] > NOISE * largest else largest
        factor = 1.0 / big if big > 0.0 else 1.0
        R.rows[i] = factor
        for j in range(n):
            a = W[i, j] * factor
            A[i, j] = a
            sizes[j] += a * a
    for j in range(n):
        sizes[j] = 1.0 / np.sqrt(sizes[j]) if sizes[j] > 0.0 else 1.0
    for i in range(len(unroll)):
        total = 0.0
        for j in range(n):
            a = A[i, j] * sizes[j]
            A[i, j] = a
            total += a * weights[j]
        R.level[i] = -total


@compiled
def best_column(
    unroll: tuple[int, ...], n: int, mask: int, A: Floats, price: Floats, gain: Floats, keys: NDArray[np.int64]
) -> int:
    """The column of greatest gain price . A_j; its index rides in the lowest bits of the gain, so one pass finds it."""
    for j in range(n):
        gain[j] = price[0] * A[0, j]
        if len(unroll) > 1:
            gain[j] += price[1] * A[1, j]
    for k in range(2, len(unroll)):
        for j in range(n):
            gain[j] += price[k] * A[k, j]
    best = int(np.int64(-1) << np.int64(62))
    for j in range(n):
        best = max(best, (keys[j] & ~mask) | j)
    return best & mask


@compiled
def phase_one(unroll: tuple[int, ...], n: int, R: Room) -> bool:
    """Min sum of artificial s with A z + s = level >= 0, from the basis that is there.

    Args:
        unroll: m zeros.
        n: columns.
        R: room.

    Returns:
        Whether an optimum was reached before the steps ran out.
    """
    level, basis, inverse, price, column = R.level, R.basis, R.inverse, R.price, R.column
    A, gain, keys, most, mask = R.A, R.gain, R.keys, R.A.shape[1], 1
    while mask < n:
        mask *= 2
    mask -= 1
    for _ in range(20 * (len(unroll) + n)):
        for k in range(len(unroll)):
            price[k] = 0.0
        for i in range(len(unroll)):
            if basis[i] >= most:
                for k in range(len(unroll)):
                    price[k] += inverse[i, k]
        enter = best_column(unroll, n, mask, A, price, gain, keys)
        if not gain[enter] > ENTERING:
            return True
        leave, least = -1, np.inf
        for i in range(len(unroll)):
            total = 0.0
            for k in range(len(unroll)):
                total += inverse[i, k] * A[k, enter]
            column[i] = total
            if total > PIVOT:
                ratio = max(level[i], 0.0) / total
                if ratio < least:
                    leave, least = i, ratio
        if leave < 0:
            return False
        factor = 1.0 / column[leave]
        for k in range(len(unroll)):
            inverse[leave, k] *= factor
        for i in range(len(unroll)):
            if i != leave:
                level[i] -= column[i] * least
                for k in range(len(unroll)):
                    inverse[i, k] -= column[i] * inverse[leave, k]
        level[leave] = least
        basis[leave] = enter
    return False


@compiled
def further_columns(unroll: tuple[int, ...], D: Floats, more: Floats, first: int, n: int, R: Room) -> int:
    """Add the furthest point of each disc that lies beyond the prices; the number of columns then."""
    m, q = len(unroll), np.empty(len(unroll))
    for c in range(m):
        q[c] = R.price[c] * R.rows[c]
    for i in range(len(D)):
        w = np.zeros(m)
        reach(D[i], q, w)
        square = 0.0
        for c in range(m):
            square += (w[c] * R.rows[c]) ** 2
        size = 1.0 / np.sqrt(square) if square > 0.0 else 1.0
        if dot(q, w) * size > ENTERING and n < R.A.shape[1]:
            for c in range(m):
                more[c, n - first] = w[c]
                R.A[c, n] = w[c] * R.rows[c] * size
            R.sizes[n], R.owner[n] = size, i
            n += 1
    return n


@compiled
def span(
    unroll: tuple[int, ...],
    W: Floats,
    D: Floats,
    more: Floats,
    weights: Floats,
    doubt: float,
    x: Floats,
    y: Floats,
    R: Room,
) -> tuple[int, int]:
    """Verdict on some columns and the discs on which they lie, with its proof in x or y.

    Args:
        unroll: m zeros.
        W: (m, n).
        D: (k, parts, m) discs, none if the columns are all there is.
        more: (m, most - n) out: columns that the discs give beside.
        weights: (n,) positive.
        doubt: optima within a factor 100 of it are DOUBTFUL.
        x: (most,) out: > 0 on the n columns, >= 0 on later ones, W x = 0, sum 1, if SPANS.
        y: (m,) out: of length 1 with W' y >= 0 if OPEN and there are no discs; else `stands_apart` gives it.
        R: room for (m, most).

    Returns:
        SPANS, OPEN or DOUBTFUL, and the number of columns then.
    """
    m, first, n = len(unroll), W.shape[1], W.shape[1]
    normalise(unroll, W, weights, R)
    for i in range(m):
        if not np.isfinite(R.level[i]):
            return DOUBTFUL, n
        sign = -1.0 if R.level[i] < 0.0 else 1.0
        for k in range(m):
            R.inverse[i, k] = 0.0
        R.inverse[i, i] = sign
        R.level[i] *= sign
        R.basis[i] = R.A.shape[1] + i
    for turn in range(ROUNDS):
        if not phase_one(unroll, n, R):
            return DOUBTFUL, n
        value = 0.0
        for i in range(m):
            if R.basis[i] >= R.A.shape[1]:
                value += max(R.level[i], 0.0)
        if value <= 0.01 * doubt:
            return read_weights(first, n, weights, doubt, x, R), n
        if turn == 0 and len(D) > 0 and lies_apart(D * R.rows, R.column):
            # Most sets that are open show it at once, long before the prices are exact.
            return OPEN, n
        grown = further_columns(unroll, D, more, first, n, R)
        if grown == n:
            return read_prices(value, doubt, y, R), n
        n = grown
    return DOUBTFUL, n


@compiled
def read_prices(value: float, doubt: float, y: Floats, R: Room) -> int:
    """The verdict that a positive optimum means, and y in the units of W."""
    square = 0.0
    for i in range(len(y)):
        y[i] = -R.price[i] * R.rows[i]
        square += y[i] * y[i]
    factor = 1.0 / max(np.sqrt(square), 1e-300)
    for i in range(len(y)):
        y[i] *= factor
    return OPEN if value >= 100.0 * doubt else DOUBTFUL


@reordered
def read_weights(first: int, n: int, weights: Floats, doubt: float, x: Floats, R: Room) -> int:
    """The verdict that an optimum of zero means, and x in the units of W."""
    full, total, scaled = True, 0.0, 0.0
    for j in range(first):
        total += weights[j]
        x[j] = weights[j] * R.sizes[j]
        scaled += x[j]
    for j in range(first, n):
        x[j] = 0.0
    for i in range(len(R.basis)):
        j = R.basis[i]
        if j >= n:
            full = False
        else:
            more = max(R.level[i], 0.0)
            total += more
            x[j] += more * R.sizes[j]
            scaled += more * R.sizes[j]
    factor = 1.0 / scaled
    for j in range(n):
        x[j] *= factor
    return SPANS if full and total <= 1.0 / doubt else DOUBTFUL


@reordered
def has_full_rank(unroll: tuple[int, ...], n: int, R: Room) -> bool:
    """Whether the normalised columns surely span the space: det(A A') is far from zero."""
    m = len(unroll)
    G = np.empty((m, m))
    for a in range(m):
        for b in range(a + 1):
            total = 0.0
            for j in range(n):
                total += R.A[a, j] * R.A[b, j]
            G[a, b] = total
    share, mean = 1.0, n / m
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
def stands_apart(unroll: tuple[int, ...], D: Floats, n: int, y: Floats, R: Room) -> bool:
    """Is the set clearly away from the origin, which may lie on its boundary for all that the program says?

    Args:
        unroll: m zeros.
        D: (k, parts, m) discs in scaled rows.
        n: columns; they must surely span the space with signs.
        y: (m,) out: of length 1 with y . w > 0 on the whole set, if so.
        R: room as the program left it.
    """
    if not has_full_rank(unroll, n, R):
        return False
    if not lies_apart(D, y):
        return False
    square = 0.0
    for i in range(len(y)):
        y[i] *= R.rows[i]
        square += y[i] * y[i]
    for i in range(len(y)):
        y[i] /= np.sqrt(square)
    return True


@compiled
def positive_span(unroll: tuple[int, ...], W: Floats, weights: Floats, doubt: float, x: Floats, y: Floats) -> int:
    """Verdict on one matrix of finitely many columns; OPEN only as `stands_apart` says.

    Args:
        unroll: m zeros.
        W: (m, n).
        weights, doubt, x, y: as in `span`.
    """
    m, n = W.shape
    R = make_room(m, n)
    verdict, _ = span(unroll, W, np.empty((0, 1, m)), np.empty((m, 0)), weights, doubt, x, y, R)
    if verdict != OPEN:
        return verdict
    D = np.empty((n, 1, m))
    for j in range(n):
        for i in range(m):
            D[j, 0, i] = R.A[i, j]
    return OPEN if stands_apart(unroll, D, n, y, R) else DOUBTFUL


@compiled
def positive_span_of_discs(
    unroll: tuple[int, ...], D: Floats, W: Floats, more: Floats, weights: Floats, doubt: float, x: Floats, y: Floats
) -> tuple[int, int]:
    """Verdict on the hull of discs; OPEN only as `stands_apart` says.

    Args:
        unroll: m zeros.
        D: (k, parts, m) discs.
        W: (m, n) columns on them that span their space.
        more: (m, most - n) out.
        weights, doubt, x, y: as in `span`.

    Returns:
        The verdict and the number of columns that W and more and x have then.
    """
    R = make_room(len(unroll), W.shape[1] + more.shape[1])
    verdict, n = span(unroll, W, D, more, weights, doubt, x, y, R)
    if verdict != OPEN:
        return verdict, n
    return (OPEN if stands_apart(unroll, D * R.rows, n, y, R) else DOUBTFUL), n


@compiled
def positive_spans(
    unroll: tuple[int, ...], W: Floats, weights: Floats, doubt: float, x: Floats, y: Floats, verdict: Floats
) -> None:
    """The verdict on each matrix of a batch, flat ones included.

    Args:
        unroll: m zeros.
        W: (b, m, n).
        weights: (n,).
        doubt: as in `span`.
        x, y: (b, n), (b, m) out.
        verdict: (b,) out, as floats.
    """
    b, m, n = W.shape
    R, none, more = make_room(m, n), np.empty((0, 1, m)), np.empty((m, 0))
    for k in range(b):
        verdict[k] = span(unroll, W[k], none, more, weights, doubt, x[k], y[k], R)[0]
        for j in range(n if verdict[k] != SPANS else 0):
            x[k, j] = np.nan
        for i in range(m if verdict[k] != OPEN else 0):
            y[k, i] = np.nan
