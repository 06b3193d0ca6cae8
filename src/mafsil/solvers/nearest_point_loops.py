"""The point of a convex set nearest to the origin, for a set known by its support function, compiled: Wolfe's method.

1. The first corner is the set's furthest point against the sum of its centres; v is that corner.
2. The set's furthest point s against v bounds the distance from below, the length of v from above: if they meet, done.
3. Else s joins the corners of the simplex (corral).
4. Weights of the point nearest to the origin in the flat through the corners (`affine_weights`): where some are
   negative, the walk towards them stops at the simplex's boundary, and the corners without weight leave (`drop`).
5. When all weights are positive v is that point, and again from 2; without progress rounding ends it.

A question is answered sooner: is the set clearly away from the origin? Sets of wrenches come with rows of equal size.
The facet of a hull of points that a direction is nearly normal to (`facet_through`) goes exactly through its points.

Reference:
    P. Wolfe, Finding the nearest point in a polytope, Mathematical Programming 11, 1976.
"""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats
from mafsil.kernels.loops.loop import compiled
from mafsil.solvers.disc_loops import Dimension, dot, support
from mafsil.solvers.tolerances import DEPENDENT, FEW_ROUNDINGS, NEAR_BOUNDARY, ON_FACET

STEPS = 1000
GILBERT = 6
"""Cheap steps away from the origin before the nearest point is sought."""
LOOSE = 0.9
"""Gap of the bounds of a distance, relative, at which its lower bound says enough."""


@compiled
def affine_weights(S: Floats, count: int, weights: Floats, Q: Floats, R: Floats, b: Floats) -> bool:
    """Weights of sum 1, of any sign, of the point nearest to the origin in the flat through some corners.

    1. Edges from corner 0 are made orthonormal one after the other, twice each (Gram and Schmidt): edges = R' Q.
    2. Corner 0 along Q gives the right side; R is solved backwards for the weights of the edges.

    Args:
        S: (m + 1, m) corners.
        count: of them.
        weights: (m + 1,) out.
        Q, R, b: (m + 2, m), (m + 2, m + 2), (m + 2,) to work in.

    Returns:
        Whether the corners are in general position.
    """
    m = S.shape[1]
    for i in range(1, count):  # 1
        for k in range(1, i):
            R[k, i] = 0.0
        for c in range(m):
            Q[i, c] = S[i, c] - S[0, c]
        length = np.sqrt(dot(Q[i], Q[i]))
        for _ in range(2):
            for k in range(1, i):
                s = dot(Q[k], Q[i])
                R[k, i] += s
                for c in range(m):
                    Q[i, c] -= s * Q[k, c]
        R[i, i] = np.sqrt(dot(Q[i], Q[i]))
        if not R[i, i] > DEPENDENT * length:
            return False
        for c in range(m):
            Q[i, c] /= R[i, i]
        b[i] = -dot(Q[i], S[0])
    weights[0] = 1.0  # 2
    for i in range(count - 1, 0, -1):
        for k in range(i + 1, count):
            b[i] -= R[i, k] * weights[k]
        weights[i] = b[i] / R[i, i]
        weights[0] -= weights[i]
    return True


@compiled
def drop(S: Floats, share: Floats, weights: Floats, count: int) -> int:
    """Walk from the shares towards the weights until a corner has none left, and drop such corners; how many remain.

    1. The share of the way at which the first weight is zero.
    2. The weights there; a corner with none left goes, and later ones close the gap.
    """
    step = 1.0  # 1
    for i in range(count):
        if weights[i] < 0.0:
            step = min(step, share[i] / (share[i] - weights[i]))
    kept = 0  # 2
    for i in range(count):
        left = share[i] + step * (weights[i] - share[i])
        if left > FEW_ROUNDINGS or (weights[i] >= 0.0 and left > 0.0):
            share[kept] = left
            for c in range(S.shape[1]):
                S[kept, c] = S[i, c]
            kept += 1
    return kept


@compiled
def nearest_point(D: Floats, tolerance: float, v: Floats, apart: Floats) -> tuple[float, float]:
    """Bounds of the distance from the origin to the hull of discs.

    Args:
        D: (k, parts, m) as in `disc_loops`.
        tolerance: largest gap of the bounds, relative.
        v: (m,) out: the nearest point found, as long as the upper bound.
        apart: (m,) out: unit direction along which every point of the set is at least the lower bound away.

    Returns:
        Lower and upper bound; both 0 if the origin is inside as far as rounding lets us see.
    """
    m = D.shape[2]
    S, share, weights = np.empty((m + 2, m)), np.zeros(m + 2), np.empty(m + 2)
    Q, R, b = np.empty((m + 2, m)), np.empty((m + 2, m + 2)), np.empty(m + 2)
    u, lower, size = np.zeros(m), 0.0, 0.0
    for i in range(len(D)):
        for c in range(m):
            u[c] -= D[i, 0, c]
    support(D, False, u, S[0])
    share[0], count = 1.0, 1  # 1
    v[:] = S[0]
    for _ in range(STEPS):
        length = np.sqrt(dot(v, v))
        size = max(size, np.sqrt(dot(S[count - 1], S[count - 1])))
        if length <= FEW_ROUNDINGS * size:
            v[:] = 0.0
            return 0.0, 0.0
        for c in range(m):
            u[c] = -v[c] / length
        reached = -support(D, False, u, S[count])  # 2
        if reached > lower or count == 1:
            lower = max(reached, 0.0)
            for c in range(m):
                apart[c] = -u[c]
        if length - lower <= tolerance * length + FEW_ROUNDINGS * size:
            return min(lower, length), length
        share[count], count = 0.0, count + 1  # 3
        while True:  # 4
            if count > m + 1 or not affine_weights(S, count, weights, Q, R, b):
                return min(lower, length), length
            before = count
            count = drop(S, share, weights, count)
            if count == before:
                break
        for c in range(m):  # 5
            v[c] = 0.0
            for i in range(count):
                v[c] += share[i] * S[i, c]
        if not np.sqrt(dot(v, v)) < length:
            return min(lower, length), length
    length = np.sqrt(dot(v, v))
    return min(lower, length), length


@compiled
def steps_apart(D: Floats, y: Floats) -> bool:
    """Whether a few cheap steps find a direction in which the whole set is clearly beyond the origin.

    1. v is the sum of the centres, the first guess.
    2. The set's point s that reaches least far along v is found; v . s over the length of v bounds the distance.
    3. Where that does not do, v moves to the point nearest to the origin between it and s, and again from 2.

    Args:
        D: (k, parts, m) discs.
        y: (m,) out: unit direction, if so.

    Reference:
        E. Gilbert, An iterative procedure for computing the minimum of a quadratic form on a convex set, SIAM J.
        Control 4(1), 1966.
    """
    m = len(y)
    v, s = np.zeros(m), np.empty(m)
    for i in range(len(D)):  # 1
        for c in range(m):
            v[c] += D[i, 0, c] / len(D)
    for _ in range(GILBERT):
        length = np.sqrt(dot(v, v))
        if not length > NEAR_BOUNDARY:
            return False
        for c in range(m):
            y[c] = -v[c] / length
        if -support(D, False, y, s) > 10.0 * NEAR_BOUNDARY:  # 2
            for c in range(m):
                y[c] = -y[c]
            return True
        square, along = 0.0, 0.0
        for c in range(m):  # 3
            square += (s[c] - v[c]) ** 2
            along -= v[c] * (s[c] - v[c])
        share = min(1.0, along / square) if square > 0.0 else 0.0
        for c in range(m):
            v[c] += share * (s[c] - v[c])
    return False


@compiled
def lies_apart(D: Floats, y: Floats) -> bool:
    """Whether the set is clearly away from the origin: by cheap steps, or by its nearest point as far as it is needed.

    Args:
        D: (k, parts, m) discs.
        y: (m,) out: unit direction in which all of it is beyond the origin, if so.
    """
    return steps_apart(D, y) or nearest_point(D, LOOSE, np.empty(len(y)), y)[0] > NEAR_BOUNDARY


@compiled
def facet_through(dimension: Dimension, W: Floats, u: Floats, v: Floats) -> bool:
    """The facet of the hull of columns that points nearly along u.

    1. The columns within `ON_FACET` of the furthest along u are gathered.
    2. Elimination with partial pivoting solves v . w = 1 on m of them.
    3. The others lie on that plane too, and no column of the set beyond it.

    Args:
        dimension: m zeros (see `disc_loops.Dimension`).
        W: (m, n) columns.
        u: (m,) direction.
        v: (m,) out.

    Returns:
        Whether such a facet was found.
    """
    (m, n), found, largest, furthest = W.shape, 0, 0.0, -np.inf
    A, heights = np.empty((n, m + 1)), np.empty(n)
    for j in range(n):
        square, height = 0.0, 0.0
        for c in range(m):
            square += W[c, j] * W[c, j]
            height += W[c, j] * u[c]
        heights[j] = height
        largest, furthest = max(largest, square), max(furthest, height)
    for j in range(n):  # 1
        if heights[j] >= furthest - ON_FACET * np.sqrt(largest):
            for c in range(m):
                A[found, c] = W[c, j]
            A[found, m] = 1.0
            found += 1
    if found < m:
        return False
    for r in range(m):  # 2
        pivot = r
        for i in range(r + 1, found):
            pivot = i if abs(A[i, r]) > abs(A[pivot, r]) else pivot
        if not abs(A[pivot, r]) > ON_FACET * np.sqrt(largest):
            return False
        for c in range(m + 1):
            A[r, c], A[pivot, c] = A[pivot, c], A[r, c]
        for i in range(r + 1, found):
            factor = A[i, r] / A[r, r]
            for c in range(r, m + 1):
                A[i, c] -= factor * A[r, c]
    for r in range(m - 1, -1, -1):
        total = A[r, m]
        for c in range(r + 1, m):
            total -= A[r, c] * v[c]
        v[r] = total / A[r, r]
    for j in range(n):  # 3
        height = 0.0
        for c in range(m):
            height += v[c] * W[c, j]
        if height > 1.0 + ON_FACET:
            return False
        if heights[j] >= furthest - ON_FACET * np.sqrt(largest) and height < 1.0 - ON_FACET:
            return False
    return True
