"""Distance of two convex cores by the method of Gilbert, Johnson and Keerthi, compiled, with a lower bound as proof.

1. v is a point of the difference A - B; the corner w of A - B that reaches least far along v is found.
2. v . w / |v| is a distance that all of A - B keeps from the origin: a lower bound; |v| is an upper bound.
3. Where the bounds meet, or the lower one passes the cutoff, that is the answer.
4. Else w joins the simplex, v becomes its point nearest to the origin, corners without weight leave, and again from 1.
   A tetrahedron around the origin is contact. Without progress rounding ends it: the bounds stay as they are.
5. A tetrahedron so flat that rounding decides its sides may seem to hold an origin that 2 has proved to be outside, or
   lose its nearest face: then all faces are looked at.

Reference:
    E. Gilbert, D. Johnson, S. Keerthi, A fast procedure for computing the distance between complex objects in
    three-dimensional space, IEEE J. Robotics and Automation 4(2), 1988.
    G. van den Bergen, Collision Detection in Interactive 3D Environments, 2003, ch. 4.
"""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats
from mafsil.collision.simplex_loops import nearest_on_faces, nearest_on_simplex
from mafsil.collision.support_loops import corner
from mafsil.kernels.loops.loop import compiled

STEPS = 200
GAP = 1e-12
"""Gap of the bounds, relative to the size of the difference, at which the distance is found."""
CONTACT = 1e-13
"""Distance of two cores, relative to the size of the difference, that counts as contact."""
WORKSPACE = (16, 8)
"""Shape of the array that `core_distance` works in."""


@compiled
def core_distance(
    kind_a: int, size_a: Floats, vertices_a: Floats, kind_b: int, size_b: Floats, vertices_b: Floats,
    M: Floats, cutoff: float, W: Floats,
) -> tuple[float, float, int]:  # fmt: skip
    """Bounds of the distance of two cores.

    Args:
        kind_a, size_a, vertices_a: core A, in whose frame all stands.
        kind_b, size_b, vertices_b: core B.
        M: (3, 4) pose of B in A.
        cutoff: a lower bound above it ends the search.
        W: WORKSPACE to work in; rows 0..3: corners of the simplex (6), row 5: the points a and b nearest to each other.

    Returns:
        Lower bound, upper bound, number of corners of the last simplex. Both bounds are 0 where the cores meet.
    """
    S, weights, v = W[0:5], W[6], W[7]
    for k in range(4):
        W[10, k] = 0.0
    v[0], v[1], v[2] = -M[0, 3], -M[1, 3], -M[2, 3]
    if v[0] == 0.0 and v[1] == 0.0 and v[2] == 0.0:
        v[0] = 1.0
    lower, upper, largest, count = -np.inf, np.inf, 0.0, 0
    for _ in range(STEPS):
        corner(  # 1
            kind_a, size_a, vertices_a, kind_b, size_b, vertices_b, M, -v[0], -v[1], -v[2], S[count]
        )  # fmt: skip
        w = S[count]
        length = np.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
        lower = max(lower, (v[0] * w[0] + v[1] * w[1] + v[2] * w[2]) / length)  # 2
        if lower > cutoff:  # 3
            return lower, upper, count
        largest = max(largest, w[0] * w[0] + w[1] * w[1] + w[2] * w[2])
        if count > 0 and upper - lower <= GAP * np.sqrt(largest):
            break
        known = False
        for i in range(count):
            known = known or (S[i, 0] == w[0] and S[i, 1] == w[1] and S[i, 2] == w[2])
        if known:
            break
        square = nearest_on_simplex(S, count + 1, weights, W[8:11])  # 4
        if count == 3 and lower > 0.0 and (square < lower * lower or not square < upper * upper):  # 5
            square = nearest_on_faces(S, weights, W[8], W[9])
        if not square < upper * upper:
            break
        upper = np.sqrt(square)
        kept = 0
        v[0], v[1], v[2] = 0.0, 0.0, 0.0
        for i in range(count + 1):
            if weights[i] > 0.0:
                for k in range(6):
                    S[kept, k] = S[i, k]
                weights[kept] = weights[i]
                for k in range(3):
                    v[k] += weights[kept] * S[kept, k]
                kept += 1
        count = kept
        for k in range(3):
            W[5, k] = 0.0
            for i in range(count):
                W[5, k] += weights[i] * S[i, 3 + k]
            W[5, 3 + k] = W[5, k] - v[k]
        if square <= CONTACT * CONTACT * largest:
            return 0.0, 0.0, count
    return max(lower, 0.0), upper, count
