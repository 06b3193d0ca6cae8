"""Matrix games by the simplex method on a condensed tableau, compiled."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.kernels.loops.loop import compiled
from mafsil.solvers.tolerances import TINY


@compiled
def game(A: Floats, count: int, shift: float, t: Floats, weights: Floats, T: Floats, side: Floats) -> None:
    """Value of the matrix game: weights >= 0 of rows that maximise the least column of weights' A, t of columns.

    The simplex method for max sum y, (A + shift) y <= 1, y >= 0, on a condensed tableau:

    1. From y = 0: rows (A + shift | 1), and -1 for the costs; `side` and `t` say which variable a row or column is.
    2. The column of least cost enters, the row of least ratio leaves, and the tableau is pivoted, until no cost is
       negative.
    3. Costs of the slack variables are the weights of the rows, levels of y the mixture of the columns; each is
       divided by its sum.
    """
    m = len(t)
    for p in range(count):  # 1
        for j in range(m):
            T[p, j] = A[p, j] + shift
        T[p, m] = 1.0
        side[p] = m + p
    for j in range(m):
        T[count, j] = -1.0
        t[j] = j
    T[count, m] = 0.0
    for _ in range(60):  # 2
        enter, least = -1, -TINY
        for j in range(m):
            if T[count, j] < least:
                enter, least = j, T[count, j]
        if enter < 0:
            break
        leave, ratio = -1, np.inf
        for p in range(count):
            if T[p, enter] > TINY and T[p, m] < ratio * T[p, enter]:
                leave, ratio = p, T[p, m] / T[p, enter]
        if leave < 0:
            break
        _pivot(T, count, m, leave, enter)
        side[leave], t[enter] = t[enter], side[leave]
    _read_game(T, count, t, weights, side)  # 3


@compiled
def _pivot(T: Floats, count: int, m: int, leave: int, enter: int) -> None:
    """Exchange the variable of a row for that of a column."""
    pivot = T[leave, enter]
    for j in range(m + 1):
        T[leave, j] /= pivot
    T[leave, enter] = 1.0 / pivot
    for p in range(count + 1):
        f = T[p, enter]
        if p == leave or f == 0.0:
            continue
        for j in range(m + 1):
            if j != enter:
                T[p, j] -= f * T[leave, j]
        T[p, enter] = -f / pivot


@compiled
def _read_game(T: Floats, count: int, t: Floats, weights: Floats, side: Floats) -> None:
    """Weights of the rows and mixture of the columns of a solved tableau; arguments as of `game`."""
    m = len(t)
    weights[:count] = 0.0
    total = 0.0
    for j in range(m):
        if t[j] >= m:
            weights[int(t[j]) - m] = max(0.0, T[count, j])
            total += max(0.0, T[count, j])
    for p in range(count):
        weights[p] /= max(total, LEAST_DIVISOR)
    t[:] = 0.0
    for p in range(count):
        if side[p] < m:
            t[int(side[p])] = max(0.0, T[p, m])
    total = 0.0
    for j in range(m):
        total += t[j]
    for j in range(m):
        t[j] /= max(total, LEAST_DIVISOR)
