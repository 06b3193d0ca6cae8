"""Limits of joints as linear inequalities between the squared path velocities at both ends of an interval, compiled.

Between two places of the grid the path acceleration is constant, so with r = (s - s_i)/h in 0 .. 1 the square of the
path velocity is linear,  s'^2 = (1 - r) x + r y,  and the joints move with

    velocity^2   = D(r)^2 ((1 - r) x + r y)/h^2,        D = du/dr, a polynomial of degree m in r
    acceleration = (D'(r) ((1 - r) x + r y) + D(r) (y - x)/2)/h^2.

Both are polynomials in r whose Bernstein coefficients are linear in (x, y). A polynomial stays within the hull of its
Bernstein coefficients: what holds for them holds everywhere between the places, not only on them.

Joints stand in lanes, eight side by side, with empty ones at the end.

Imported only where a path is timed: numba is loaded with it.
"""

# pyright: reportMissingParameterType=false, reportUnknownVariableType=false, reportUnknownParameterType=false
# pyright: reportUnknownMemberType=false, reportUnknownArgumentType=false
from __future__ import annotations

import numpy as np

from mafsil.solvers.lane_loops import any_lane, buffer, get, lanes, magnitude, seen, where
from mafsil.solvers.loops import reordered

FREE = 1e300
"""Squared velocity where nothing limits it."""
STEEP = 1e-13
"""Below this ratio of its two factors a row does not speak about y."""
NARROW = 3.0
"""By how much a limit at one end may exceed the least within an interval: linear above a parabola from its vertex."""


@reordered
def weights_of(m):
    """Bernstein's numbers of degree m: from powers, (m + 1, m + 1), and of squares, (2 m + 1, m + 1).

    Row k: coefficient k is the sum over j of C(k, j)/C(m, j) e_j; that of a square the sum over i of
    C(m, i) C(m, k - i)/C(2 m, k) D_i D_{k - i}.
    """
    choose = np.zeros((2 * m + 1, 2 * m + 1))
    for n in range(2 * m + 1):
        choose[n, 0] = 1.0
        for k in range(1, n + 1):
            choose[n, k] = choose[n - 1, k - 1] + choose[n - 1, k]
    powers, squares = np.zeros((m + 1, m + 1)), np.zeros((2 * m + 1, m + 1))
    for k in range(m + 1):
        for j in range(k + 1):
            powers[k, j] = choose[k, j] / choose[m, j]
    for k in range(2 * m + 1):
        for i in range(max(0, k - m), min(k, m) + 1):
            squares[k, i] = choose[m, i] * choose[m, k - i] / choose[2 * m, k]
    return powers, squares


@reordered
def largest_lane(x):
    """The largest of eight lanes."""
    place = buffer(1)
    place[0] = x
    largest = get(place, 0, 0)
    for k in range(1, 8):
        largest = max(largest, get(place, 0, k))
    return largest


@reordered
def slope_controls(coefficients, a, h, powers, D):
    """Bernstein coefficients of du/dr on the part a .. a + h of a polynomial piece, in place.

    1. The derivative by s in powers of s.
    2. Moved to the part's start by repeated synthetic division, and from s to r by powers of h.
    3. From powers to Bernstein coefficients.

    Args:
        coefficients: (degree + 1, 8 w) in ascending powers.
        a, h: start and length of the part.
        powers: of `weights_of`.
        D: (degree, 8 w).
    """
    degree, w = D.shape[0], D.shape[1] // 8
    given, found = seen(coefficients), seen(D)
    for j in range(w):
        # 1.
        for k in range(degree):
            found[k * w + j] = given[(k + 1) * w + j] * (k + 1.0)
        # 2.
        for first in range(degree - 1):
            for k in range(degree - 2, first - 1, -1):
                found[k * w + j] = found[k * w + j] + found[(k + 1) * w + j] * a
        power = 1.0
        for k in range(degree):
            power *= h
            found[k * w + j] = found[k * w + j] * power
        # 3.
        for k in range(degree - 1, 0, -1):
            total = found[j] * powers[k, 0]
            for i in range(1, k + 1):
                total = total + found[i * w + j] * powers[k, i]
            found[k * w + j] = total


@reordered
def acceleration_rows(D, h, acceleration, alpha, beta, low, high):
    """Rows  low <= alpha x + beta y <= high  that keep the accelerations of the joints in one interval, in place.

    alpha_k = (m - k) (D_{k+1} - D_k) - D_k/2,   beta_k = k (D_k - D_{k-1}) + D_k/2.

    Args:
        D: (m + 1, 8 w) Bernstein coefficients of du/dr.
        h: length of the interval.
        acceleration: (2, 8 w) lower and upper bounds.
        alpha, beta, low, high: (rows,) of which the first (m + 1) 8 w are written.
    """
    m, w = D.shape[0] - 1, D.shape[1] // 8
    square = h * h
    given, bounds = seen(D), seen(acceleration)
    to_alpha, to_beta, to_low, to_high = seen(alpha), seen(beta), seen(low), seen(high)
    for k in range(m + 1):
        for j in range(w):
            here, at = given[k * w + j], k * w + j
            half = here * 0.5
            ahead, behind = lanes(0.0), lanes(0.0)
            if k < m:
                ahead = (given[at + w] - here) * float(m - k)
            if k > 0:
                behind = (here - given[at - w]) * float(k)
            to_alpha[at] = ahead - half
            to_beta[at] = behind + half
            to_low[at] = bounds[j] * square
            to_high[at] = bounds[w + j] * square


@reordered
def velocity_shares(D, slowness, shares):
    """D_k over the velocity limit in the direction of motion; over the lesser one where the direction turns, in place.

    Args:
        D: (m + 1, 8 w) Bernstein coefficients of du/dr.
        slowness: (2, 8 w) one over the magnitudes of the lower and the upper velocity limit.
        shares: (m + 1, 8 w).

    Returns:
        The largest magnitude of a share, and of those at the beginning and at the end.
    """
    m, w = D.shape[0] - 1, D.shape[1] // 8
    given, slow, found = seen(D), seen(slowness), seen(shares)
    top, begin, end = lanes(0.0), lanes(0.0), lanes(0.0)
    for j in range(w):
        least = most = given[j]
        for k in range(1, m + 1):
            here = given[k * w + j]
            least, most = where(here < least, here, least), where(here > most, here, most)
        back, forth = slow[j], slow[w + j]
        larger = where(back > forth, back, forth)
        factor = where(least >= 0.0, forth, where(most <= 0.0, back, larger))
        for k in range(m + 1):
            share = given[k * w + j] * factor
            found[k * w + j] = share
            size = magnitude(share)
            top = where(size > top, size, top)
            if k == 0:
                begin = where(size > begin, size, begin)
            if k == m:
                end = where(size > end, size, end)
    return largest_lane(top), largest_lane(begin), largest_lane(end)


@reordered
def largest_square(shares, x, y, squares):
    """The largest Bernstein coefficient of  share(r)^2 ((1 - r) x + r y)  over all joints: a bound of what it reaches.

    Args:
        shares: (m + 1, 8 w) Bernstein coefficients of velocities as shares of their limits, by r.
        x, y: squared velocities at both ends.
        squares: of `weights_of`.
    """
    m, w = shares.shape[0] - 1, shares.shape[1] // 8
    top = 2 * m
    given, largest = seen(shares), lanes(0.0)
    for j in range(w):
        before = lanes(0.0)
        for k in range(top + 1):
            square = lanes(0.0)
            for i in range(max(0, k - m), min(k, m) + 1):
                square = square + given[i * w + j] * given[(k - i) * w + j] * squares[k, i]
            value = square * ((top + 1 - k) / (top + 1) * x) + before * (k / (top + 1) * y)
            largest = where(value > largest, value, largest)
            before = square
        value = before * y
        largest = where(value > largest, value, largest)
    return largest_lane(largest)


@reordered
def velocity_caps(shares, largest, begin, end, h, squares):
    """Squares of the path velocity at both ends of an interval below which every joint keeps its velocity limit.

    1. The limits at both ends, never more than NARROW times the least inside.
    2. The line between them, lowered until it stays below the limits of all joints everywhere.

    Args:
        shares: (m + 1, 8 w) and `largest`, `begin`, `end`: of `velocity_shares`.
        h: length of the interval.
        squares: of `weights_of`.
    """
    # 1.
    if largest == 0.0:
        return FREE, FREE
    narrow = NARROW * (h / largest) * (h / largest)
    x = narrow if begin == 0.0 else min(narrow, h / begin * (h / begin))
    y = narrow if end == 0.0 else min(narrow, h / end * (h / end))
    # 2.
    over = largest_square(shares, x / h / h, y / h / h, squares)
    return (x / over, y / over) if over > 1.0 else (x, y)


@reordered
def as_lines(alpha, beta, low, high, y_cap, slope, above, below):
    """Rows as bounds of y over x,  slope x + below <= y <= slope x + above, in place.

    Args:
        alpha, beta, low, high: (rows,), a multiple of eight.
        y_cap: the largest y, for rows that hardly speak about it.
        slope, above, below: (rows,) lines.

    Returns:
        The largest x that rows without y allow.
    """
    most = lanes(FREE)
    for k in range(len(alpha) // 8):
        a, b, lower, upper = seen(alpha)[k], seen(beta)[k], seen(low)[k], seen(high)[k]
        size = magnitude(a)
        flat = (magnitude(b) <= size * STEEP) | (b == 0.0)
        forth = b > 0.0
        one = 1.0 / where(flat, 1.0, b)
        seen(slope)[k] = where(flat, 0.0, -a * one)
        seen(above)[k] = where(flat, FREE, where(forth, upper, lower) * one)
        seen(below)[k] = where(flat, -FREE, where(forth, lower, upper) * one)
        speaking = flat & (size > 0.0)
        if any_lane(speaking):
            bound = where(a > 0.0, upper, -lower)
            spare = magnitude(b) * y_cap
            spare = where(spare < bound * 0.5, spare, bound * 0.5)
            limit = where(speaking, (bound - spare) / where(speaking, size, 1.0), FREE)
            most = where(limit < most, limit, most)
    return -largest_lane(-most)


@reordered
def used_of(alpha, beta, least, greatest, shares, h, x, y, added):
    """Mean over both ends of the largest share of a limit that is used there, and the largest excess of any row.

    Args:
        alpha, beta, least, greatest: (rows,) of one interval, the last ones `added` by the caller.
        shares: (m + 1, 8 w) of `velocity_shares`.
        h, x, y: length of the interval, squares of the path velocity at its ends.
        added: how many rows count at both ends.
    """
    m, w = shares.shape[0] - 1, shares.shape[1] // 8
    begin, finish, excess = lanes(0.0), lanes(0.0), lanes(0.0)
    own = len(alpha) // 8 - added // 8
    for k in range(len(alpha) // 8):
        lower, upper = seen(least)[k], seen(greatest)[k]
        value = seen(alpha)[k] * x + seen(beta)[k] * y
        bound = where(value > 0.0, upper, lower)
        share = where(bound == 0.0, 0.0, value / where(bound == 0.0, 1.0, bound))
        if k < w or k >= own:
            begin = where(share > begin, share, begin)
        if k >= m * w:
            finish = where(share > finish, share, finish)
        over = value - upper
        over = where(lower - value > over, lower - value, over)
        if any_lane(over > 0.0):
            size = where(upper > -lower, upper, -lower)
            over = where(over > 0.0, over / where(size > 0.0, size, 1.0 / FREE), 0.0)
            excess = where(over > excess, over, excess)
    fast, slow = np.sqrt(x) / h, np.sqrt(y) / h
    for j in range(w):
        at, then = magnitude(seen(shares)[j]) * fast, magnitude(seen(shares)[m * w + j]) * slow
        begin, finish = where(at > begin, at, begin), where(then > finish, then, finish)
    return 0.5 * (min(largest_lane(begin), 1.0) + min(largest_lane(finish), 1.0)), largest_lane(excess)
