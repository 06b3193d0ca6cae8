"""The best efforts over a horizon within their limits, compiled: a dual active-set method with a guess in blocks.

Accelerations w = M^-1 (x - known) cost the sum over coordinates j of w_j' H_j w_j / 2 + g_j' w_j; the efforts x_k of
each interval k are to stay within -bound .. bound. With a multiplier m for each effort that is held at a bound,

    w_j = -H_j^-1 (g_j + (M' m)_j),      x = known + M w,

so the few multipliers are found from a small system whose entries are known in closed form, and the large Hessian,
which lives in all efforts of all intervals, is never built.

1. Blocks: efforts beyond a bound are held there, held ones whose multiplier pulls inward are let go, all at once, a
   few times; mostly nothing is wrong then.
2. Else one at a time, which ends: from multipliers of zero towards those of what is held; where one would pull inward
   on the way, it is let go there; else the effort that is furthest beyond its bound is held, too.

References:
    D. Goldfarb and A. Idnani, A numerically stable dual method for solving strictly convex quadratic programs,
    Mathematical Programming 27, 1983; D. Arnstroem, A. Bemporad and D. Axehill, A dual active-set solver for embedded
    quadratic programming using recursive LDL' updates, IEEE Transactions on Automatic Control 67, 2022.
    M. Hintermueller, K. Ito and K. Kunisch, The primal-dual active set strategy as a semismooth Newton method, SIAM J.
    Optimization 13, 2002.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.kernels.loops.loop import compiled, reordered
from mafsil.solvers.cholesky_loops import append_row, drop_row, factor, solve

BLOCKS = 6
"""Rounds in which all that is wrong changes at once."""
BEYOND, INWARD = 1e-11, 1e-11
"""Share of a bound, and of the largest multiplier, below which neither is wrong."""
STEPS = 20
"""Times the number of efforts: steps after which it is given up."""


@reordered
def efforts_of(K: Floats, M: Floats, free: Floats, multipliers: Floats, pulls: Floats, out: Floats) -> None:
    """The efforts that some multipliers leave: free - M K M' m, interval by interval.

    Args:
        K: (n, N, N) inverse Hessians.
        M: (n, n).
        free: (N, n) without limits.
        multipliers: (N, n), zero where an effort is free.
        pulls: (2, n, N) to work in.
        out: (N, n).
    """
    n, N = K.shape[:2]
    for j in range(n):
        for k in range(N):
            s = 0.0
            for a in range(n):
                s += M[a, j] * multipliers[k, a]
            pulls[0, j, k] = s
        for k in range(N):
            s = 0.0
            for i in range(N):
                s += K[j, k, i] * pulls[0, j, i]
            pulls[1, j, k] = s
    for k in range(N):
        for a in range(n):
            s = 0.0
            for j in range(n):
                s += M[a, j] * pulls[1, j, k]
            out[k, a] = free[k, a] - s


@reordered
def given_way(K: Floats, M: Floats, k: int, a: int, p: int, b: int) -> float:
    """By how much effort a of interval k gives way to the multiplier of effort b of interval p.

    Args:
        K: (n, N, N) inverse Hessians.
        M: (n, n).
        k, a: interval and coordinate of the one.
        p, b: of the other.
    """
    s = 0.0
    for j in range(len(M)):
        s += M[a, j] * K[j, k, p] * M[b, j]
    return s


@reordered
def system(K: Floats, M: Floats, held: NDArray[np.int64], m: int, S: Floats) -> None:
    """The matrix of the multipliers: how much each held effort gives way to each.

    Args:
        K: (n, N, N) inverse Hessians.
        M: (n, n).
        held: (>= m, 2) interval and coordinate of each.
        m: how many are held.
        S: (>= m, >= m) out, lower left.
    """
    for i in range(m):
        for c in range(i + 1):
            S[i, c] = given_way(K, M, held[i, 0], held[i, 1], held[c, 0], held[c, 1])


@compiled
def within(K: Floats, M: Floats, free: Floats, bound: Floats, out: Floats) -> bool:
    """The best efforts within their bounds.

    Args:
        K: (n, N, N) inverse Hessians of each coordinate's accelerations.
        M: (n, n) mass matrix.
        free: (N, n) best efforts without limits.
        bound: (n,) of their magnitudes, infinite where there is none.
        out: (N, n) the efforts.

    Returns:
        Whether they were found.
    """
    N, n = free.shape
    most = N * n
    side, held = np.zeros((N, n), np.int64), np.empty((most, 2), np.int64)
    S, b, multipliers = np.empty((most, most)), np.empty(most), np.zeros((N, n))
    pulls = np.empty((2, n, N))
    return in_blocks(K, M, free, bound, out, side, held, S, b, multipliers, pulls) or one_by_one(
        K, M, free, bound, out, side, held, S, b, multipliers, pulls
    )


@compiled
def in_blocks(
    K: Floats, M: Floats, free: Floats, bound: Floats, out: Floats, side: NDArray[np.int64],
    held: NDArray[np.int64], S: Floats, b: Floats, multipliers: Floats, pulls: Floats,
) -> bool:  # fmt: skip
    """A few rounds in which all that is wrong changes at once; arguments as `within` and `one_by_one`.

    1. Efforts beyond their bounds without limits are held there.
    2. The multipliers of what is held, and all efforts.
    3. Free efforts beyond a bound are held, held ones whose multiplier pulls inward are let go. Nothing: done.

    Args:
        K, M, free, bound, out: as `within`.
        side: (N, n) where each effort is: free 0, at a bound 1 or -1; zero before, what is best known after.
        held, S, b, multipliers, pulls: to work in.

    Returns:
        Whether nothing is wrong any more.
    """
    N, n = free.shape
    for k in range(N):
        for a in range(n):
            side[k, a] = 1 if free[k, a] > bound[a] else -1 if free[k, a] < -bound[a] else 0  # 1
    for _ in range(BLOCKS):
        m = 0
        for k in range(N):  # 2
            for a in range(n):
                multipliers[k, a] = 0.0
                if side[k, a] != 0:
                    held[m, 0], held[m, 1] = k, a
                    b[m] = free[k, a] - side[k, a] * bound[a]
                    m += 1
        system(K, M, held, m, S)
        if not factor(S, m):
            return False
        largest = refine_multipliers(K, M, free, bound, out, side, held, m, S, b, multipliers, pulls)
        changed = False
        for k in range(N):  # 3
            for a in range(n):
                x, limit = out[k, a], bound[a] * (1.0 + BEYOND)
                if side[k, a] == 0:
                    side[k, a] = 1 if x > limit else -1 if x < -limit else 0
                    changed |= side[k, a] != 0
                elif side[k, a] * multipliers[k, a] < -INWARD * largest:
                    side[k, a] = 0
                    changed = True
        if not changed:
            pin_to_bounds(bound, side, out)
            return True
    return False


@compiled
def one_by_one(
    K: Floats, M: Floats, free: Floats, bound: Floats, out: Floats, side: NDArray[np.int64],
    held: NDArray[np.int64], S: Floats, b: Floats, multipliers: Floats, pulls: Floats,
) -> bool:  # fmt: skip
    """The dual active-set method; arguments as `within` and `in_blocks`.

    1. What is held is factored; its multipliers are zero.
    2. Towards the multipliers of what is held, up to the first that would pull inward: that effort is let go.
    3. None does: the effort furthest beyond its bound is held, too. None is beyond: done, after a step of refinement.

    Args:
        K, M, free, bound, out: as `within`.
        side: (N, n) what is held at first: free 0, at a bound 1 or -1.
        held, S, b, multipliers, pulls: to work in.

    Returns:
        Whether the efforts were found.
    """
    N, n = free.shape
    most = N * n
    row = np.empty(most)
    multipliers[:] = 0.0
    m = _list_held(side, held)
    system(K, M, held, m, S)
    if not factor(S, m):  # 1
        return False
    for _ in range(STEPS * most):
        largest, share, gone = 0.0, 1.0, -1
        for i in range(m):
            k, a = held[i, 0], held[i, 1]
            b[i] = free[k, a] - side[k, a] * bound[a]
        solve(S, m, b)
        for i in range(m):
            largest = max(largest, abs(b[i]))
        for i in range(m):  # 2
            k, a = held[i, 0], held[i, 1]
            now, then = side[k, a] * multipliers[k, a], side[k, a] * b[i]
            if then < -INWARD * largest:
                part = max(now, 0.0) / (max(now, 0.0) - then)
                if gone < 0 or part < share:
                    share, gone = part, i
        for i in range(m):
            k, a = held[i, 0], held[i, 1]
            multipliers[k, a] += share * (b[i] - multipliers[k, a])
        if gone >= 0:
            multipliers[held[gone, 0], held[gone, 1]] = 0.0
            side[held[gone, 0], held[gone, 1]] = 0
            drop_row(S, m, gone, row)
            for i in range(gone, m - 1):
                held[i, 0], held[i, 1] = held[i + 1, 0], held[i + 1, 1]
            m -= 1
            continue
        efforts_of(K, M, free, multipliers, pulls, out)
        worst = _furthest_beyond(bound, side, out)  # 3
        if worst < 0:
            for i in range(m):
                k, a = held[i, 0], held[i, 1]
                b[i] = out[k, a] - side[k, a] * bound[a]
            refine_multipliers(K, M, free, bound, out, side, held, m, S, b, multipliers, pulls)
            pin_to_bounds(bound, side, out)
            return True
        k, a = worst // n, worst % n
        side[k, a] = 1 if out[k, a] > 0.0 else -1
        held[m, 0], held[m, 1] = k, a
        for i in range(m + 1):
            row[i] = given_way(K, M, k, a, held[i, 0], held[i, 1])
        if not append_row(S, m, row):
            return False
        m += 1
    return False


@compiled
def _list_held(side: NDArray[np.int64], held: NDArray[np.int64]) -> int:
    """How many efforts are held at a bound; their steps and coordinates are written to `held`."""
    m = 0
    for k in range(side.shape[0]):
        for a in range(side.shape[1]):
            if side[k, a] != 0:
                held[m, 0], held[m, 1] = k, a
                m += 1
    return m


@compiled
def _furthest_beyond(bound: Floats, side: NDArray[np.int64], out: Floats) -> int:
    """Index k n + a of the free effort furthest beyond its bound, as a share of it; -1 if none is."""
    furthest, worst = BEYOND, -1
    for k in range(out.shape[0]):
        for a in range(out.shape[1]):
            over = (abs(out[k, a]) - bound[a]) / bound[a]
            if side[k, a] == 0 and over > furthest:
                furthest, worst = over, k * out.shape[1] + a
    return worst


@compiled
def refine_multipliers(
    K: Floats, M: Floats, free: Floats, bound: Floats, out: Floats, side: NDArray[np.int64],
    held: NDArray[np.int64], m: int, L: Floats, b: Floats, multipliers: Floats, pulls: Floats,
) -> float:  # fmt: skip
    """The multipliers that `b` asks for, added to those there are, with a step of refinement, and all efforts.

    Args:
        K, M, free, bound, out, side, held, multipliers, pulls: as `one_by_one`.
        m: how many are held.
        L: (>= m, >= m) factor of their matrix.
        b: (>= m,) what they miss their bounds by; lost.

    Returns:
        The largest multiplier.
    """
    for _ in range(2):
        solve(L, m, b)
        for i in range(m):
            multipliers[held[i, 0], held[i, 1]] += b[i]
        efforts_of(K, M, free, multipliers, pulls, out)
        for i in range(m):
            k, a = held[i, 0], held[i, 1]
            b[i] = out[k, a] - side[k, a] * bound[a]
    largest = 0.0
    for i in range(m):
        largest = max(largest, abs(float(multipliers[held[i, 0], held[i, 1]])))
    return largest


@compiled
def pin_to_bounds(bound: Floats, side: NDArray[np.int64], out: Floats) -> None:
    """What is held lies on its bound, what is free within, to the last bit.

    Args:
        bound: (n,).
        side: (N, n) where each effort is.
        out: (N, n) in and out.
    """
    N, n = out.shape
    for k in range(N):
        for a in range(n):
            x = side[k, a] * bound[a] if side[k, a] != 0 else out[k, a]
            out[k, a] = min(max(x, -bound[a]), bound[a])


@compiled
def first_efforts(
    K: Floats, slope: Floats, M: Floats, known: Floats, errors: Floats, rates: Floats, bound: Floats, effort: Floats,
) -> int:  # fmt: skip
    """The first efforts of the horizon for each of many states.

    1. Without limits: w_j = -K_j slope_j (e, e'), efforts known + M w.
    2. Where one is beyond its bound: the best within.

    Args:
        K: (n, N, N) inverse Hessians.
        slope: (n, N, 2) of the cost's gradient by error and rate.
        M: (b, n, n) mass matrices.
        known: (b, n) efforts without errors.
        errors, rates: (b, n) of the coordinates.
        bound: (n,) of the efforts.
        effort: (b, n) out.

    Returns:
        The first state for which none were found, or -1.
    """
    n, N = K.shape[:2]
    w, free, out = np.empty((N, n)), np.empty((N, n)), np.empty((N, n))
    for r in range(len(known)):
        if not plan_efforts(K, slope, M[r], known[r], errors[r], rates[r], bound, w, free, out):
            return r
        for a in range(n):
            effort[r, a] = out[0, a]
    return -1


@compiled
def plan_efforts(
    K: Floats, slope: Floats, M: Floats, known: Floats, errors: Floats, rates: Floats, bound: Floats, w: Floats,
    free: Floats, out: Floats,
) -> bool:  # fmt: skip
    """All efforts of the horizon at one state; what is not finite passes through. Arguments as `first_efforts`.

    Args:
        K, slope, M, known, errors, rates, bound: as there.
        w, free: (N, n) to work in: accelerations and efforts without limits.
        out: (N, n) the efforts.

    Returns:
        Whether they were found.
    """
    n, N = K.shape[:2]
    beyond, finite = False, True
    for j in range(n):
        for k in range(N):
            free[k, j] = slope[j, k, 0] * errors[j] + slope[j, k, 1] * rates[j]
        for k in range(N):
            s = 0.0
            for i in range(N):
                s -= K[j, k, i] * free[i, j]
            w[k, j] = s
    for k in range(N):
        for a in range(n):
            s = known[a]
            for j in range(n):
                s += M[a, j] * w[k, j]
            free[k, a] = out[k, a] = s
            beyond |= abs(s) > bound[a]
            finite &= abs(s) < np.inf
    return within(K, M, free, bound, out) if beyond and finite else True
