"""The shortest time along a path with limited jerk, compiled: a barrier method whose systems have five diagonals.

A motion u(tau) along the path is given; run with dt = dtau / sqrt(y(tau)) it has, with ' = d/dtau,

    v = u' sqrt(y),   a = u'' y + u' y'/2,   j = sqrt(y) (u''' y + 3/2 u'' y' + u' y''/2).

y is a quadratic spline, so at every place three coefficients decide. Velocity, acceleration and all that is linear in
s'' and s'^2 is linear in them; the jerk's limit, divided by sqrt(y), is  f(y, y', y'') <= J y^(-1/2)  with a linear f.
"""

from __future__ import annotations

from math import inf, log, sqrt
from typing import NamedTuple

import numpy as np

from mafsil.arrays import Floats
from mafsil.kernels.loops.loop import compiled

PLACES = 3
"""Of each piece of the spline at which limits are imposed: both ends and the middle."""
FIRST_GAP, SHRINK = 1.0, 0.15
"""Share of the duration that the barrier may cost at first, and from one barrier to the next."""
MOST_STEPS = 60
"""Newton steps under one barrier."""
NEAR = 0.1
"""Newton decrement, in units of the barrier's weight, at which a barrier is done."""
ARMIJO, SHORTEST = 1e-4, 1e-10
"""Share of the predicted decrease that a step must bring, and the share of a step below which there is none."""


class Imposed(NamedTuple):
    """What holds at the places of all pieces, three for each.

    Attributes:
        basis: (places, 3, 3) of each basis function that counts there value, slope and second derivative.
        weight: (places,) of the integral over tau (Simpson).
        first, second, third: (places, n) derivatives of the motion that is given.
        jerk: (2, n) lower and upper limits, infinite where there is none.
        share: (places,) of the limits of jerk that counts there.
        by_square, by_slope: (places, k) factors of y and y' of the linear limits.
        low, high: (places, k) their bounds, infinite where there is none.
    """

    basis: Floats
    weight: Floats
    first: Floats
    second: Floats
    third: Floats
    jerk: Floats
    share: Floats
    by_square: Floats
    by_slope: Floats
    low: Floats
    high: Floats


@compiled
def shortest(c: Floats, imposed: Imposed, gap: float) -> int:
    """The coefficients of the shortest time, in place of those given; how many Newton steps it took.

    1. The barrier T - mu sum log(slack), its weight mu such that T at its minimum is above the optimum by some share.
    2. Newton's method, with the limits of jerk linearised: their slack is convex in y, so its tangent lies inside.
    3. Steps are halved until they stay inside and the barrier falls.
    4. A smaller weight, until the share is `gap`.

    Args:
        c: (pieces + 2,) coefficients of y, strictly inside all limits.
        imposed: at the places.
        gap: share of the duration.

    Reference: Boyd and Vandenberghe, Convex Optimization, ch. 11; Verscheure et al., Time-optimal path tracking for
        robots: a convex optimization approach, IEEE TAC 2009; the inner approximation of the jerk is ours.
    """
    m, rows = len(c), 2 * len(imposed.weight) * (imposed.first.shape[1] + imposed.by_square.shape[1])
    gradient, bands, step = np.zeros(m), np.zeros((3, m)), np.zeros(m)
    duration, share, count = barrier(c, imposed, 0.0), FIRST_GAP, 0
    while True:
        # 1.
        weight = share * duration / rows
        before = barrier(c, imposed, weight)
        for _ in range(MOST_STEPS):
            # 2.
            _newton_system(c, imposed, weight, gradient, bands)
            if not _solve(bands, gradient, step):
                return count
            count += 1
            decrement = -(gradient * step).sum()
            if decrement < NEAR * weight:
                break
            # 3.
            length = 1.0
            after = barrier(c + step, imposed, weight)
            while not after <= before - ARMIJO * length * decrement and length > SHORTEST:
                length *= 0.5
                after = barrier(c + length * step, imposed, weight)
            if length <= SHORTEST:
                break
            for k in range(m):
                c[k] += length * step[k]
            before = after
        # 4.
        if share <= gap:
            return count
        share = max(share * SHRINK, gap)


@compiled
def barrier(c: Floats, imposed: Imposed, weight: float) -> float:
    """The duration less `weight` times the logarithms of all slacks; infinite where a limit is not kept strictly.

    Args:
        c: (pieces + 2,) coefficients of y.
        imposed: at the places.
        weight: of the logarithms; zero for the duration alone.
    """
    total = 0.0
    for p in range(len(imposed.weight)):
        y, slope, bend = _local(c, imposed.basis, p)
        if not y > 0.0:
            return inf
        root = 1.0 / sqrt(y)
        allowed = imposed.share[p] * root
        total += imposed.weight[p] * root
        for i in range(imposed.by_square.shape[1]):
            value = imposed.by_square[p, i] * y + imposed.by_slope[p, i] * slope
            total -= weight * (_logarithm(imposed.high[p, i] - value) + _logarithm(value - imposed.low[p, i]))
        for j in range(imposed.first.shape[1]):
            value = imposed.third[p, j] * y + 1.5 * imposed.second[p, j] * slope + 0.5 * imposed.first[p, j] * bend
            high, low = imposed.jerk[1, j] * allowed - value, value - imposed.jerk[0, j] * allowed
            total -= weight * (_logarithm(high) + _logarithm(low))
        if not total < inf:
            return inf
    return total


@compiled
def _logarithm(slack: float) -> float:
    """Of a slack; -inf where there is none, zero where there is no limit."""
    if slack == inf:
        return 0.0
    return log(slack) if slack > 0.0 else -inf


@compiled
def _local(c: Floats, basis: Floats, p: int) -> tuple[float, float, float]:
    """y, y' and y'' at place p."""
    k = p // PLACES
    y = basis[p, 0, 0] * c[k] + basis[p, 1, 0] * c[k + 1] + basis[p, 2, 0] * c[k + 2]
    slope = basis[p, 0, 1] * c[k] + basis[p, 1, 1] * c[k + 1] + basis[p, 2, 1] * c[k + 2]
    bend = basis[p, 0, 2] * c[k] + basis[p, 1, 2] * c[k + 1] + basis[p, 2, 2] * c[k + 2]
    return y, slope, bend


@compiled
def _newton_system(c: Floats, imposed: Imposed, weight: float, gradient: Floats, bands: Floats) -> None:
    """Gradient (m,) and the diagonals (3, m) of the Hessian on and below the main one; both written.

    1. Gradient g and Hessian H at a place in (y, y', y''): of the duration, of the linear limits, of the jerk. Those
       of a slack s with gradient d are  -mu d/s  and  mu d d^T/s^2.
    2. By the basis to the three coefficients.

    Args:
        c: coefficients.
        imposed: at the places.
        weight: mu.
        gradient, bands: written.
    """
    gradient[:] = 0.0
    bands[:] = 0.0
    g, H, d = np.zeros(3), np.zeros((3, 3)), np.zeros(3)
    for p in range(len(imposed.weight)):
        # 1.
        y, slope, bend = _local(c, imposed.basis, p)
        root = 1.0 / sqrt(y)
        g[:] = 0.0
        H[:] = 0.0
        g[0], H[0, 0] = -0.5 * imposed.weight[p] * root / y, 0.75 * imposed.weight[p] * root / y**2
        for i in range(imposed.by_square.shape[1]):
            d[0], d[1], d[2] = imposed.by_square[p, i], imposed.by_slope[p, i], 0.0
            value = d[0] * y + d[1] * slope
            _push(d, 1.0 / (imposed.high[p, i] - value), 1.0 / (value - imposed.low[p, i]), weight, g, H)
        for j in range(imposed.first.shape[1]):
            third = imposed.third[p, j]
            d[1], d[2] = 1.5 * imposed.second[p, j], 0.5 * imposed.first[p, j]
            value = third * y + d[1] * slope + d[2] * bend
            for side in range(2):
                limit = imposed.share[p] * imposed.jerk[side, j]
                if abs(limit) == inf:
                    continue
                d[0] = third + 0.5 * limit * root / y
                above = 1.0 / (limit * root - value) if side == 1 else 0.0
                _push(d, above, 1.0 / (value - limit * root) if side == 0 else 0.0, weight, g, H)
        # 2.
        k = p // PLACES
        for i in range(3):
            a, b, e = imposed.basis[p, i, 0], imposed.basis[p, i, 1], imposed.basis[p, i, 2]
            gradient[k + i] += a * g[0] + b * g[1] + e * g[2]
            r0 = a * H[0, 0] + b * H[1, 0] + e * H[2, 0]
            r1 = a * H[1, 0] + b * H[1, 1] + e * H[2, 1]
            r2 = a * H[2, 0] + b * H[2, 1] + e * H[2, 2]
            for l in range(i + 1):
                bands[i - l, k + l] += (
                    r0 * imposed.basis[p, l, 0] + r1 * imposed.basis[p, l, 1] + r2 * imposed.basis[p, l, 2]
                )


@compiled
def _push(d: Floats, above: float, below: float, weight: float, g: Floats, H: Floats) -> None:
    """Adds what the logarithms of two slacks with gradients -d and d bring; the lower half of H.

    Args:
        d: (3,) gradient of what is limited.
        above, below: reciprocals of the slacks to the upper and to the lower limit.
        weight: of the logarithms.
        g, H: (3,) and (3, 3), added to.
    """
    pull, stiff = weight * (above - below), weight * (above * above + below * below)
    for r in range(3):
        g[r] += pull * d[r]
        for c in range(r + 1):
            H[r, c] += stiff * d[r] * d[c]


@compiled
def _solve(bands: Floats, gradient: Floats, step: Floats) -> bool:
    """step = -H^-1 gradient by L D L^T of five diagonals; False where H is not positive.

    1. Elimination, column by column.
    2. Forwards, by the diagonal, backwards.

    Args:
        bands: (3, m) diagonals of H on and below the main one; overwritten: D, and the rows of L below.
        gradient: (m,).
        step: (m,) written.
    """
    m = len(gradient)
    # 1.
    for k in range(m):
        if not bands[0, k] > 0.0:
            return False
        near, far = bands[1, k] / bands[0, k], bands[2, k] / bands[0, k]
        if k + 1 < m:
            bands[0, k + 1] -= near * bands[1, k]
        if k + 2 < m:
            bands[1, k + 1] -= near * bands[2, k]
            bands[0, k + 2] -= far * bands[2, k]
        bands[1, k], bands[2, k] = near, far
    # 2.
    for k in range(m):
        step[k] = -gradient[k]
        if k >= 1:
            step[k] -= bands[1, k - 1] * step[k - 1]
        if k >= 2:
            step[k] -= bands[2, k - 2] * step[k - 2]
    for k in range(m):
        step[k] /= bands[0, k]
    for k in range(m - 2, -1, -1):
        step[k] -= bands[1, k] * step[k + 1]
        if k + 2 < m:
            step[k] -= bands[2, k] * step[k + 2]
    return True
