"""What cables that only pull can hold, compiled: margins with their certificates, and tensions.

Tensions between bounds make the wrenches W t of a zonotope. Its facets are spanned by n - 1 cables each, so their
normals are the directions on which the other cables decide.
"""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats, Integers
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.kernels.loops.loop import compiled
from mafsil.parallel.linear_loops import solve_in_place
from mafsil.parallel.tolerances import RANK

MOST_STEPS = 400
"""Newton steps of the dual, those that are taken back among them."""
SETTLED = 1e-13
"""Wrench that is left over the largest one of a cable at its bound, at which tensions are exact."""
UNSEEN = 1e-11
"""Growth of the dual, over its value, that rounding hides: there what is left of the wrench has to become less."""
SOFT, SOFTEST = 1e-6, 1e-14
"""First and least share of the Hessian of all cables that is added to that of the free ones."""


@compiled
def normal_of(W: Floats, chosen: Integers, A: Floats, places: Integers, c: Floats) -> float:
    """The unit vector c (n,) normal to n - 1 columns of W; returns the least pivot over the largest.

    1. Elimination with the largest pivot of all entries left, columns change places.
    2. Back from the last row; the column without pivot has one.
    """
    n = W.shape[0]
    for i in range(n - 1):
        for j in range(n):
            A[i, j] = W[j, chosen[i]]
    for j in range(n):
        places[j] = j
    least, most = 1e308, 0.0
    # 1.
    for k in range(n - 1):
        size, row, column = 0.0, k, k
        for i in range(k, n - 1):
            for j in range(k, n):
                if abs(A[i, j]) > size:
                    size, row, column = abs(A[i, j]), i, j
        if size == 0.0:
            return 0.0
        least, most = min(least, size), max(most, size)
        for j in range(n):
            A[k, j], A[row, j] = A[row, j], A[k, j]
        for i in range(n - 1):
            A[i, k], A[i, column] = A[i, column], A[i, k]
        places[k], places[column] = places[column], places[k]
        for i in range(k + 1, n - 1):
            factor = A[i, k] / A[k, k]
            for j in range(k, n):
                A[i, j] -= factor * A[k, j]
    # 2.
    square = 1.0
    c[places[n - 1]] = 1.0
    for k in range(n - 2, -1, -1):
        value = -A[k, n - 1]
        for j in range(k + 1, n - 1):
            value -= A[k, j] * c[places[j]]
        c[places[k]] = value / A[k, k]
        square += c[places[k]] ** 2
    for j in range(n):
        c[j] /= np.sqrt(square)
    return least / most


@compiled
def following(chosen: Integers, m: int) -> bool:
    """The next choice of as many of m, in order; False after the last."""
    k = chosen.shape[0]
    for i in range(k - 1, -1, -1):
        if chosen[i] < m - k + i:
            chosen[i] += 1
            for j in range(i + 1, k):
                chosen[j] = chosen[j - 1] + 1
            return True
    return False


@compiled
def margins(
    W: Floats, low: Floats, high: Floats, wanted: Floats, capacity: Floats, direction: Floats, offered: Floats,
    closure: Floats, loose: Floats,
) -> None:  # fmt: skip
    """How far wrenches are inside what the cables can make, and how well the cables enclose every direction.

    1. Each choice of n - 1 independent cables has a normal c.
    2. Along c the others make between the sum of their least and of their greatest parts.
    3. The wanted wrench is that far from both sides; the nearest one of all is its capacity, negative outside.
    4. Enclosed is c if some cable pulls along it and some against it; the weakest of all says how well.

    Args:
        W: (rows, n, m) wrenches of unit tensions.
        low, high: (m,) tensions.
        wanted: (rows, n) of the cables.
        capacity: (rows,) set: least distance to a facet.
        direction: (rows, n) set: its normal, outwards.
        offered: (rows,) set: the most that cables make along it.
        closure: (rows,) set: least over the normals of the strongest pull of a cable along it; zero or less, none.
        loose: (rows, n) set: that normal.
    """
    rows, n, m = W.shape
    A, places, c, chosen = np.empty((n, n)), np.empty(n, np.int64), np.empty(n), np.empty(n - 1, np.int64)
    for row in range(rows):
        capacity[row], closure[row], offered[row] = np.inf, np.inf, 0.0
        direction[row], loose[row] = 0.0, 0.0
        for i in range(n - 1):
            chosen[i] = i
        more, none = True, True
        while more:
            # 1.
            independent = normal_of(W[row], chosen, A, places, c) > RANK
            if independent:
                none = False
                least, most, strongest, weakest, load = 0.0, 0.0, 0.0, 0.0, 0.0
                picked = 0
                for i in range(n):
                    load += c[i] * wanted[row, i]
                for j in range(m):
                    if picked < n - 1 and chosen[picked] == j:
                        picked += 1
                        continue
                    # 2.
                    part = 0.0
                    for i in range(n):
                        part += c[i] * W[row, i, j]
                    least += min(part * low[j], part * high[j])
                    most += max(part * low[j], part * high[j])
                    strongest, weakest = max(strongest, part), min(weakest, part)
                # 3.
                if most - load < capacity[row]:
                    capacity[row], offered[row] = most - load, most
                    direction[row] = c
                if load - least < capacity[row]:
                    capacity[row], offered[row] = load - least, -least
                    direction[row] = -c
                # 4.
                if strongest < closure[row]:
                    closure[row] = strongest
                    loose[row] = c
                if -weakest < closure[row]:
                    closure[row] = -weakest
                    loose[row] = -c
            more = following(chosen, m)
        if none:
            capacity[row], closure[row] = np.nan, 0.0


@compiled
def tensions(
    W: Floats, low: Floats, high: Floats, preferred: Floats, wanted: Floats, out: Floats, left: Floats
) -> None:
    """The tensions nearest to preferred ones that make a wrench, within their bounds, by Newton's method on the dual.

    1. Forces y (n,) on the wrench give t(y) = preferred + W' y, cut at the bounds; W t(y) is to be the wrench.
    2. What is left is the gradient of a concave function, its Hessian that of the cables between their bounds. These
       may be too few: a share of the Hessian of all cables is added, with which no step can be too long if it is one.
    3. The share is ten times as large where the function does not grow, else a tenth.

    Args:
        W: (rows, n, m) wrenches of unit tensions.
        low, high, preferred: (m,) tensions.
        wanted: (rows, n) of the cables, inside what they can make.
        out: (rows, m) set.
        left: (rows,) set: largest part of the wrench that is missing.
    """
    rows, n, m = W.shape
    H, step = np.empty((n, n)), np.empty((n, 1))
    y, tried, rest, t = np.empty(n), np.empty(n), np.empty(n), np.empty(m)
    for row in range(rows):
        size, share = LEAST_DIVISOR, SOFT
        for j in range(m):
            for i in range(n):
                size = max(size, abs(W[row, i, j]) * high[j])
        # 1.
        y[:] = 0.0
        value = _dual(W[row], low, high, preferred, wanted[row], y, t, rest)
        for _ in range(MOST_STEPS):
            error = 0.0
            for i in range(n):
                error = max(error, abs(rest[i]))
            if error <= SETTLED * size:
                break
            # 2.
            for i in range(n):
                step[i, 0] = rest[i]
                for k in range(n):
                    total = 0.0
                    for j in range(m):
                        free = 1.0 if low[j] < t[j] < high[j] else 0.0
                        total += (free + share) * W[row, i, j] * W[row, k, j]
                    H[i, k] = total
            solve_in_place(H, step)
            # 3.
            slope = 0.0
            for i in range(n):
                slope += rest[i] * step[i, 0]
                tried[i] = y[i] + step[i, 0]
            grown, then = _dual(W[row], low, high, preferred, wanted[row], tried, t, rest), 0.0
            for i in range(n):
                then = max(then, abs(rest[i]))
            if grown >= value + 1e-4 * slope or (slope <= UNSEEN * abs(value) and then < error):
                y[:], value, share = tried, grown, max(0.1 * share, SOFTEST)
            else:
                share = min(10.0 * share, 1.0)
                value = _dual(W[row], low, high, preferred, wanted[row], y, t, rest)
        left[row] = 0.0
        for i in range(n):
            left[row] = max(left[row], abs(rest[i]))
        out[row] = t


@compiled
def _dual(
    W: Floats, low: Floats, high: Floats, preferred: Floats, wanted: Floats, y: Floats, t: Floats, rest: Floats
) -> float:
    """The dual at y: t and the wrench that is left are set."""
    n, m = W.shape
    for i in range(n):
        rest[i] = wanted[i]
    value = 0.0
    for j in range(m):
        pull = preferred[j]
        for i in range(n):
            pull += W[i, j] * y[i]
        t[j] = min(max(pull, low[j]), high[j])
        value += 0.5 * (t[j] - preferred[j]) ** 2
        for i in range(n):
            rest[i] -= W[i, j] * t[j]
    for i in range(n):
        value += y[i] * rest[i]
    return value
