"""Distance of two convex cores by the method of Gilbert, Johnson and Keerthi, compiled, with a lower bound as proof.

1. v is a point of the difference A - B; the corner w of A - B that reaches least far along v is found.
2. v . w / |v| is a distance that all of A - B keeps from the origin: a lower bound; |v| is an upper bound.
3. Where the bounds meet, or the lower one passes the cutoff, that is the answer.
4. Else w joins the simplex, v becomes its point nearest to the origin, corners without weight leave, and again from 1.
   A tetrahedron around the origin is contact. Without progress rounding ends it: the bounds stay as they are.
5. A tetrahedron so flat that rounding decides its sides may seem to hold an origin that 2 has proved to be outside, or
   lose its nearest face: then all faces are looked at.
6. On cylinders and cones the bounds meet only slowly. Near the end the features of both cores that face each other are
   known: a corner, an edge, a rim; Newton's method finds where they are nearest, if the bounds of 2 agree.

References:
    E. Gilbert, D. Johnson, S. Keerthi, A fast procedure for computing the distance between complex objects in
    three-dimensional space, IEEE J. Robotics and Automation 4(2), 1988.
    G. van den Bergen, Collision Detection in Interactive 3D Environments, 2003, ch. 4.
    C. Ericson, Real-Time Collision Detection, 2005, sec. 5.1: the point of a simplex nearest to the origin.
"""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats
from mafsil.collision.feature_loops import feature_distance
from mafsil.collision.piece_loops import CONE, CYLINDER, corner
from mafsil.kernels.loops.loop import compiled

STEPS = 200
ROUND = CYLINDER, CONE
GUESSES, NEAR = 3, 0.05
"""Times that features are guessed at most, and the gap of the bounds, relative to the distance, from which on."""
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
    tries = GUESSES if kind_a in ROUND or kind_b in ROUND else 0
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
        if tries > 0 and upper - lower < NEAR * upper:  # 6
            tries -= 1
            least, most = feature_distance(kind_a, size_a, vertices_a, kind_b, size_b, vertices_b, M, v, W)
            if most - least <= GAP * np.sqrt(largest):
                for k in range(6):
                    W[5, k] = W[13, k]
                return max(least, lower), most, count
    return max(lower, 0.0), upper, count


@compiled
def _dot(a: Floats, b: Floats) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled
def nearest_on_segment(a: Floats, b: Floats, weights: Floats) -> float:
    """Square of the distance from the origin to the segment ab; weights (2,) out: of the nearest point."""
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    square = ux * ux + uy * uy + uz * uz
    t = -(a[0] * ux + a[1] * uy + a[2] * uz) / square if square > 0.0 else 0.0
    t = min(1.0, max(0.0, t))
    weights[0], weights[1] = 1.0 - t, t
    x, y, z = a[0] + t * ux, a[1] + t * uy, a[2] + t * uz
    return x * x + y * y + z * z


@compiled
def nearest_on_triangle(a: Floats, b: Floats, c: Floats, weights: Floats, edge: Floats) -> float:
    """Square of the distance from the origin to the triangle abc.

    1. The foot of the origin on the triangle's plane, by its areas; if it lies inside, that is the point.
    2. Else the nearest of the points nearest on the three edges.

    Args:
        a, b, c: (3,) corners.
        weights: (3,) out: of the nearest point.
        edge: (2,) to work in.
    """
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    square = nx * nx + ny * ny + nz * nz
    if square > 0.0:  # 1
        wa = nx * (b[1] * c[2] - b[2] * c[1]) + ny * (b[2] * c[0] - b[0] * c[2]) + nz * (b[0] * c[1] - b[1] * c[0])
        wb = nx * (c[1] * a[2] - c[2] * a[1]) + ny * (c[2] * a[0] - c[0] * a[2]) + nz * (c[0] * a[1] - c[1] * a[0])
        wc = nx * (a[1] * b[2] - a[2] * b[1]) + ny * (a[2] * b[0] - a[0] * b[2]) + nz * (a[0] * b[1] - a[1] * b[0])
        if wa >= 0.0 and wb >= 0.0 and wc >= 0.0:
            total = wa + wb + wc
            weights[0], weights[1], weights[2] = wa / total, wb / total, wc / total
            height = a[0] * nx + a[1] * ny + a[2] * nz
            return height * height / square
    best = nearest_on_segment(a, b, edge)  # 2
    weights[0], weights[1], weights[2] = edge[0], edge[1], 0.0
    found = nearest_on_segment(b, c, edge)
    if found < best:
        best = found
        weights[0], weights[1], weights[2] = 0.0, edge[0], edge[1]
    found = nearest_on_segment(c, a, edge)
    if found < best:
        best = found
        weights[0], weights[1], weights[2] = edge[1], 0.0, edge[0]
    return best


@compiled
def _side(a: Floats, b: Floats, c: Floats, p: Floats) -> float:
    """Six times the signed volume of the tetrahedron a, b, c, p."""
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    x, y, z = p[0] - a[0], p[1] - a[1], p[2] - a[2]
    return x * (uy * vz - uz * vy) + y * (uz * vx - ux * vz) + z * (ux * vy - uy * vx)


@compiled
def nearest_on_tetrahedron(S: Floats, weights: Floats, face: Floats, edge: Floats, origin: Floats) -> float:
    """Square of the distance from the origin to a tetrahedron; 0 if it holds the origin.

    1. A face that parts the origin from the fourth corner, or lies in one plane with it, may carry the point.
    2. Of those faces the nearest one has it; without any, the origin is inside.

    Args:
        S: (4, 3 or more) corners.
        weights: (4,) out: of the nearest point.
        face, edge: (3,), (2,) to work in.
        origin: (3,) zeros.
    """
    best = np.inf
    for k in range(4):
        i, j, m = (k + 1) % 4, (k + 2) % 4, (k + 3) % 4
        if _side(S[i], S[j], S[m], S[k]) * _side(S[i], S[j], S[m], origin) > 0.0:  # 1
            continue
        found = nearest_on_triangle(S[i], S[j], S[m], face, edge)
        if found < best:  # 2
            best = found
            weights[k], weights[i], weights[j], weights[m] = 0.0, face[0], face[1], face[2]
    if best == np.inf:
        for k in range(4):
            weights[k] = 0.25
        return 0.0
    return best


@compiled
def nearest_on_faces(S: Floats, weights: Floats, face: Floats, edge: Floats) -> float:
    """As `nearest_on_tetrahedron` where the origin is known to be outside: however flat, the nearest face has it."""
    best = np.inf
    for k in range(4):
        i, j, m = (k + 1) % 4, (k + 2) % 4, (k + 3) % 4
        found = nearest_on_triangle(S[i], S[j], S[m], face, edge)
        if found < best:
            best = found
            weights[k], weights[i], weights[j], weights[m] = 0.0, face[0], face[1], face[2]
    return best


@compiled
def nearest_on_simplex(S: Floats, count: int, weights: Floats, W: Floats) -> float:
    """Square of the distance from the origin to the simplex of the first `count` rows of S.

    Args:
        S: (4, 3 or more) corners.
        count: 1 to 4.
        weights: (4,) out: of the nearest point.
        W: (3, 4) to work in; its last row is zero.
    """
    if count == 1:
        weights[0] = 1.0
        return _dot(S[0], S[0])
    if count == 2:
        return nearest_on_segment(S[0], S[1], weights)
    if count == 3:
        return nearest_on_triangle(S[0], S[1], S[2], weights, W[1])
    return nearest_on_tetrahedron(S, weights, W[0], W[1], W[2])
