"""Limits of joints as linear inequalities between the squared path velocities at both ends of an interval, compiled.

Between two places of the grid the path acceleration is constant, so with r = (s - s_i)/h in 0 .. 1 the square of the
path velocity is linear,  s'^2 = (1 - r) x + r y,  and the joints move with

    velocity^2   = D(r)^2 ((1 - r) x + r y)/h^2,        D = du/dr, a polynomial of degree m in r
    acceleration = (D'(r) ((1 - r) x + r y) + D(r) (y - x)/2)/h^2.

Both are polynomials in r whose Bernstein coefficients are linear in (x, y). A polynomial stays within the hull of its
Bernstein coefficients: what holds for them holds everywhere between the places, not only on them.

Eight paths stand side by side in lanes: each is one interval of each of them. Rows come k by k, joint by joint.
"""

# pyright: reportMissingParameterType=false, reportUnknownVariableType=false, reportUnknownParameterType=false
# pyright: reportUnknownMemberType=false, reportUnknownArgumentType=false
from __future__ import annotations

import numpy as np

from mafsil.kernels.loops.lanes import any_lane, lanes, magnitude, part, put, square_root, where
from mafsil.kernels.loops.loop import compiled
from mafsil.trajectory.tolerances import CORNER, FEW_ROUNDINGS

FREE = 1e300
"""Squared velocity where nothing limits it."""
NARROW = 3.0
"""By how much a limit at one end may exceed the least within an interval: linear above a parabola from its vertex."""


@compiled
def chosen_of(m):
    """Binomial coefficients C(i, k) for i up to 2 m, (2 m + 1, 2 m + 1)."""
    choose = np.zeros((2 * m + 1, 2 * m + 1))
    for n in range(2 * m + 1):
        choose[n, 0] = 1.0
        for k in range(1, n + 1):
            choose[n, k] = choose[n - 1, k - 1] + choose[n - 1, k]
    return choose


@compiled
def lesser(a, b):
    """The smaller of each lane."""
    return where(a < b, a, b)


@compiled
def larger(a, b):
    """The larger of each lane."""
    return where(a > b, a, b)


@compiled
def taken(row, slopes, lane):
    """The derivative of a polynomial into a lane.

    Args:
        row: (degree + 1, n) in ascending powers.
        slopes: degree n lanes.
        lane: which.
    """
    degree, n = len(row) - 1, row.shape[1]
    for k in range(degree):
        for j in range(n):
            put(slopes, k * n + j, lane, row[k + 1, j] * (k + 1.0))


@compiled
def lanes_that_turn(ending, before, beginning, h, n):
    """The lanes in which the direction of the path jumps where one interval ends and the next begins.

    Args:
        ending: n lanes, change of the coordinates at the end of the interval, over its parameter 0 .. 1.
        before: length of that interval.
        beginning, h: of the next interval, at its beginning.
        n: coordinates.
    """
    size, jump = lanes(0.0), lanes(0.0)
    for j in range(n):
        last, first = ending[j] / before, beginning[j] / h
        size = larger(larger(magnitude(first), magnitude(last)), size)
        jump = larger(magnitude(first - last), jump)
    return jump > size * CORNER


@compiled
def part_weights(a, h, choose, m, weights):
    """What each power of du/ds contributes to each Bernstein coefficient of du/dr on the part a .. a + h, in place.

    Coefficient k is h times the blossom at a (m - k times) and b = a + h (k times): of s^i the sum of all products of i
    of these numbers, over C(m, i). Those sums are the coefficients of (1 + a z)^(m - k) (1 + b z)^k.

    Args:
        a, h: start and length of the part, in lanes.
        choose: of `chosen_of`.
        m: degree of du/ds.
        weights: (m + 1)^2 lanes, those of one coefficient beside each other.
    """
    b = a + h
    for k in range(m + 1):
        row = part(weights, k * (m + 1))
        row[0] = lanes(1.0)
        for count in range(m):
            factor = b if count < k else a
            row[count + 1] = row[count] * factor
            for i in range(count, 0, -1):
                row[i] = row[i] + row[i - 1] * factor
        for i in range(m + 1):
            row[i] = row[i] * h * (1.0 / choose[m, i])


@compiled
def slope_controls(slopes, m, n, weights, D):
    """Bernstein coefficients of du/dr on a part of polynomial pieces, in place.

    Args:
        slopes: (m + 1) n lanes, du/ds in ascending powers.
        m, n: degree and coordinates.
        weights: of `part_weights`.
        D: (m + 1) n lanes.
    """
    for k in range(m + 1):
        row = part(weights, k * (m + 1))
        for j in range(n):
            total = slopes[j] * row[0]
            for i in range(1, m + 1):
                total = total + slopes[i * n + j] * row[i]
            D[k * n + j] = total


@compiled
def row_of(D, m, n, k, j):
    """alpha and beta of the row  low <= alpha x + beta y <= high  that keeps one Bernstein coefficient.

    alpha_k = (m - k) (D_{k+1} - D_k) - D_k/2,   beta_k = k (D_k - D_{k-1}) + D_k/2;   low and high are the limits of
    acceleration times h^2.

    Args:
        D, m, n: of `slope_controls`.
        k, j: which coefficient of which coordinate.
    """
    here = D[k * n + j]
    half = here * 0.5
    alpha, beta = -half, half
    if k < m:
        alpha = (D[(k + 1) * n + j] - here) * float(m - k) - half
    if k > 0:
        beta = (here - D[(k - 1) * n + j]) * float(k) + half
    return alpha, beta


@compiled
def line_of(alpha, beta, low, high, y_cap):
    """A row as bounds of y over x,  slope x + below <= y <= slope x + above.

    Args:
        alpha, beta, low, high: of the row.
        y_cap: the largest y, for rows that hardly speak about it.

    Returns:
        slope, above, below, and the largest x that the row allows if it does not speak about y.
    """
    size = magnitude(alpha)
    flat = (magnitude(beta) <= size * FEW_ROUNDINGS) | (beta == lanes(0.0))
    forth = beta > 0.0
    one = 1.0 / where(flat, 1.0, beta)
    slope = where(flat, 0.0, -alpha * one)
    above = where(flat, FREE, where(forth, high, low) * one)
    below = where(flat, -FREE, where(forth, low, high) * one)
    most = lanes(FREE)
    speaking = flat & (size > 0.0)
    if any_lane(speaking):
        bound = where(alpha > 0.0, high, -low)
        spare = lesser(magnitude(beta) * y_cap, bound * 0.5)
        most = where(speaking, (bound - spare) / where(speaking, size, 1.0), FREE)
    return slope, above, below, most


@compiled
def velocity_shares(D, m, n, slowness, factors, shares):
    """The largest share of a velocity limit in each Bernstein coefficient, in place.

    Where a joint does not turn inside the interval its limit in the direction of motion counts, else the lesser one.
    The polynomial of these coefficients is above the shares of all joints everywhere.

    Args:
        D: (m + 1) n lanes, Bernstein coefficients of du/dr.
        m, n: degree and coordinates.
        slowness: 2 n lanes, one over the magnitudes of the lower and the upper velocity limits.
        factors: n lanes, written over.
        shares: m + 1 lanes.
    """
    for j in range(n):
        least = most = D[j]
        for k in range(1, m + 1):
            here = D[k * n + j]
            least, most = lesser(here, least), larger(here, most)
        back, forth = slowness[j], slowness[n + j]
        factors[j] = where(least >= 0.0, forth, where(most <= 0.0, back, larger(back, forth)))
    for k in range(m + 1):
        largest = lanes(0.0)
        for j in range(n):
            largest = larger(magnitude(D[k * n + j]) * factors[j], largest)
        shares[k] = largest


@compiled
def largest_square(shares, m, x, y, choose):
    """The largest Bernstein coefficient of  share(r)^2 ((1 - r) x + r y): a bound of what it reaches.

    1. Coefficient k of share^2 is the sum over i of C(m, i) C(m, k - i)/C(2 m, k) share_i share_{k - i}.
    2. Times the line, of degree q = 2 m + 1: (1 - k/q) x of coefficient k and k/q y of the one before.

    Args:
        shares: m + 1 lanes, Bernstein coefficients of velocities as shares of their limits, by r.
        m: degree.
        x, y: squared velocities at both ends, in lanes.
        choose: of `chosen_of`.
    """
    q, before, largest = 2 * m + 1, lanes(0.0), lanes(0.0)
    for k in range(q):
        # 1.
        square = lanes(0.0)
        for i in range(max(0, k - m), min(k, m) + 1):
            square = square + shares[i] * shares[k - i] * (choose[m, i] * choose[m, k - i] / choose[2 * m, k])
        # 2.
        largest = larger(square * (1.0 - k / q) * x + before * (k / q) * y, largest)
        before = square
    return larger(before * y, largest)


@compiled
def velocity_caps(shares, m, h, choose):
    """Squares of the path velocity at both ends of an interval below which every joint keeps its velocity limit.

    1. The limits at both ends, never more than NARROW times the least inside.
    2. The line between them, lowered until it stays below the limits of all joints everywhere.

    Args:
        shares, m: of `velocity_shares`.
        h: length of the interval, in lanes.
        choose: of `chosen_of`.
    """
    # 1.
    begin, end, largest = shares[0], shares[m], shares[0]
    for k in range(1, m + 1):
        largest = larger(shares[k], largest)
    limited, square = largest > 0.0, h * h
    narrow = NARROW / where(limited, largest * largest, 1.0)
    x = where(begin > 0.0, lesser(1.0 / (begin * begin), narrow), narrow)
    y = where(end > 0.0, lesser(1.0 / (end * end), narrow), narrow)
    # 2.
    over = larger(largest_square(shares, m, x, y, choose), lanes(1.0))
    scale = square / over
    return where(limited, x * scale, FREE), where(limited, y * scale, FREE)


@compiled
def share_used(value, low, high):
    """The share of its limit that the value of a row uses; 0 where the limit in its direction is zero.

    Args:
        value, low, high: of the row, in lanes.
    """
    bound = where(value > 0.0, high, low)
    none = bound == lanes(0.0)
    return where(none, 0.0, value / where(none, 1.0, bound))


@compiled
def beyond(value, low, high):
    """What the value of a row exceeds its limits by.

    Args:
        value, low, high: of the row, in lanes.
    """
    return larger(value - high, low - value)


@compiled
def used_at_ends(D, m, n, bounds, h, x, y, shares):
    """The largest share of a limit of velocity or acceleration that is used at each end.

    Args:
        D, shares: of `slope_controls` and `velocity_shares`.
        m, n: degree and coordinates.
        bounds: 2 n lanes, lower and upper limits of acceleration.
        h, x, y: length of the interval, squares of the path velocity at its ends, in lanes.
    """
    square = h * h
    begin, finish = shares[0] * square_root(x) / h, shares[m] * square_root(y) / h
    for j in range(n):
        low, high = bounds[j] * square, bounds[n + j] * square
        alpha, beta = row_of(D, m, n, 0, j)
        begin = larger(share_used(alpha * x + beta * y, low, high), begin)
        alpha, beta = row_of(D, m, n, m, j)
        finish = larger(share_used(alpha * x + beta * y, low, high), finish)
    return begin, finish
