"""Limits of joints as linear inequalities between the squared path velocities at both ends of an interval, compiled.

Between two places of the grid the path acceleration is constant, so with r = (s - s_i)/h in 0 .. 1 the square of the
path velocity is linear,  s'^2 = (1 - r) x + r y,  and the joints move with

    velocity^2   = D(r)^2 ((1 - r) x + r y)/h^2,        D = du/dr, a polynomial of degree m in r
    acceleration = (D'(r) ((1 - r) x + r y) + D(r) (y - x)/2)/h^2.

Both are polynomials in r whose Bernstein coefficients are linear in (x, y). A polynomial stays within the hull of its
Bernstein coefficients: what holds for them holds everywhere between the places, not only on them.

Imported only where a path is timed: numba is loaded with it.
"""

# pyright: reportMissingParameterType=false, reportUnknownVariableType=false, reportUnknownParameterType=false
# pyright: reportUnknownMemberType=false, reportUnknownArgumentType=false
from __future__ import annotations

import numpy as np

from mafsil.solvers.loops import compiled

FREE = 1e300
"""Squared velocity where nothing limits it."""
STEEP = 1e-13
"""Below this ratio of its two factors a row does not speak about y."""
NARROW = 3.0
"""By how much a limit at one end may exceed the least within an interval: linear above a parabola from its vertex."""


@compiled
def binomials(degree):
    """(degree + 1, degree + 1) numbers n over k."""
    table = np.zeros((degree + 1, degree + 1))
    for n in range(degree + 1):
        table[n, 0] = 1.0
        for k in range(1, n + 1):
            table[n, k] = table[n - 1, k - 1] + table[n - 1, k]
    return table


@compiled
def slope_controls(coefficients, a, h, choose, D):
    """Bernstein coefficients of du/dr on the part a .. a + h of a polynomial piece, in place.

    1. The derivative by s in powers of s.
    2. Moved to the part's start by repeated synthetic division, and from s to r by powers of h.
    3. From powers to Bernstein coefficients: D_k = sum_j C(k, j)/C(m, j) e_j.

    Args:
        coefficients: (degree + 1, n) in ascending powers.
        a, h: start and length of the part.
        choose: binomials up to twice the degree.
        D: (degree, n).
    """
    degree, n = coefficients.shape[0] - 1, coefficients.shape[1]
    # 1.
    for k in range(degree):
        for j in range(n):
            D[k, j] = (k + 1) * coefficients[k + 1, j]
    # 2.
    for first in range(degree - 1):
        for k in range(degree - 2, first - 1, -1):
            for j in range(n):
                D[k, j] += a * D[k + 1, j]
    power = 1.0
    for k in range(degree):
        power *= h
        for j in range(n):
            D[k, j] *= power
    # 3.
    for k in range(degree - 1, 0, -1):
        for j in range(n):
            total = 0.0
            for i in range(k + 1):
                total += choose[k, i] / choose[degree - 1, i] * D[i, j]
            D[k, j] = total


@compiled
def acceleration_rows(D, h, acceleration, alpha, beta, low, high):
    """Rows  low <= alpha x + beta y <= high  that keep the accelerations of the joints in one interval, in place.

    alpha_k = (m - k) (D_{k+1} - D_k) - D_k/2,   beta_k = k (D_k - D_{k-1}) + D_k/2.

    Args:
        D: (m + 1, n) Bernstein coefficients of du/dr.
        h: length of the interval.
        acceleration: (2, n) lower and upper bounds.
        alpha, beta, low, high: ((m + 1) n,) rows.
    """
    m, n = D.shape[0] - 1, D.shape[1]
    square = h * h
    for k in range(m + 1):
        for j in range(n):
            half = 0.5 * D[k, j]
            ahead = (m - k) * (D[k + 1, j] - D[k, j]) if k < m else 0.0
            behind = k * (D[k, j] - D[k - 1, j]) if k else 0.0
            alpha[k * n + j] = ahead - half
            beta[k * n + j] = behind + half
            low[k * n + j] = acceleration[0, j] * square
            high[k * n + j] = acceleration[1, j] * square


@compiled
def velocity_shares(D, slowness, shares):
    """D_k over the velocity limit in the direction of motion; over the lesser one where the direction turns, in place.

    Args:
        D: (m + 1, n) Bernstein coefficients of du/dr.
        slowness: (2, n) one over the magnitudes of the lower and the upper velocity limit.
        shares: (m + 1, n).

    Returns:
        The largest magnitude of a share.
    """
    largest = 0.0
    for j in range(D.shape[1]):
        least, most = D[0, j], D[0, j]
        for k in range(1, D.shape[0]):
            least, most = min(least, D[k, j]), max(most, D[k, j])
        back, forth = slowness[0, j], slowness[1, j]
        slow = forth if least >= 0.0 else back if most <= 0.0 else max(back, forth)
        for k in range(D.shape[0]):
            shares[k, j] = D[k, j] * slow
            largest = max(largest, abs(shares[k, j]))
    return largest


@compiled
def largest_square(shares, x, y, choose):
    """The largest Bernstein coefficient of  share(r)^2 ((1 - r) x + r y)  over all joints: a bound of what it reaches.

    Args:
        shares: (m + 1, n) Bernstein coefficients of velocities as shares of their limits, by r.
        x, y: squared velocities at both ends.
        choose: binomials up to 2 m.
    """
    m = shares.shape[0] - 1
    top = 2 * m
    largest = 0.0
    for j in range(shares.shape[1]):
        before = 0.0
        for k in range(top + 1):
            square = 0.0
            for i in range(max(0, k - m), min(k, m) + 1):
                square += choose[m, i] * choose[m, k - i] * shares[i, j] * shares[k - i, j]
            square /= choose[top, k]
            largest = max(largest, ((top + 1 - k) * square * x + k * before * y) / (top + 1))
            before = square
        largest = max(largest, before * y)
    return largest


@compiled
def velocity_caps(shares, largest, h, choose):
    """Squares of the path velocity at both ends of an interval below which every joint keeps its velocity limit.

    1. The limits at both ends, never more than NARROW times the least inside.
    2. The line between them, lowered until it stays below the limits of all joints everywhere.

    Args:
        shares: (m + 1, n) and `largest`: of `velocity_shares`.
        h: length of the interval.
        choose: binomials up to 2 m.
    """
    # 1.
    if largest == 0.0:
        return FREE, FREE
    begin = end = 0.0
    for j in range(shares.shape[1]):
        begin = max(begin, abs(shares[0, j]))
        end = max(end, abs(shares[-1, j]))
    largest = largest / h
    narrow = NARROW / largest / largest
    x = narrow if begin == 0.0 else min(narrow, h / begin * (h / begin))
    y = narrow if end == 0.0 else min(narrow, h / end * (h / end))
    # 2.
    over = largest_square(shares, x / h / h, y / h / h, choose)
    return (x / over, y / over) if over > 1.0 else (x, y)
