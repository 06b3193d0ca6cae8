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
from mafsil.collision.piece_loops import BOX, CONE, CYLINDER, HULL, SEGMENT, corner, furthest
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.kernels.loops.loop import compiled, inlined

STEPS = 200
ROUND = CYLINDER, CONE
GUESSES, NEAR = 3, 0.05
"""Times that features are guessed at most, and the gap of the bounds, relative to the distance, from which on."""
ALONG = 0.05
"""Sine of the angle to a direction below which an edge or a side is guessed to lie across it."""
TURNED = 1e-14
"""Square of the angle of the last step of Newton's method: its own error is smaller by far."""
TURNS = 6
"""Steps of Newton's method at most."""
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
            least, most = _smooth_distance(kind_a, size_a, vertices_a, kind_b, size_b, vertices_b, M, v, W)
            if most - least <= GAP * np.sqrt(largest):
                for k in range(6):
                    W[5, k] = W[11, k]
                return max(least, lower), most, count
    return max(lower, 0.0), upper, count


@inlined
def _feature(kind: int, size: Floats, x: float, y: float, z: float) -> int:
    """What of a core reaches furthest along a unit direction.

    0 for a corner or a place of a rim, 1 to 3 for an edge along that axis, -1 for what is flat or not known.
    """
    across = np.sqrt(x * x + y * y)
    if kind == HULL:
        return -1
    if kind == CONE:
        slant = 2.0 * size[2] * z - size[0] * across
        flat = abs(slant) < ALONG * (2.0 * size[2] + size[0]) or (across < ALONG and z < 0.0)
        return -1 if flat else 0
    if kind == BOX:
        edges = int(abs(x) < ALONG) + int(abs(y) < ALONG) + int(abs(z) < ALONG)
        axis = 1 if abs(x) < ALONG else 2 if abs(y) < ALONG else 3
        return -1 if edges > 1 else axis * edges
    if kind == CYLINDER and across < ALONG:
        return -1
    return 3 if kind in (SEGMENT, CYLINDER) and abs(z) < ALONG else 0


@inlined
def _bend(kind: int, size: Floats, x: float, y: float, z: float) -> float:
    """How far the furthest place of a core moves per angle that the direction turns about the core's axis."""
    across = np.sqrt(x * x + y * y)
    turns = kind == CYLINDER or (kind == CONE and 2.0 * size[2] * z < size[0] * across)
    return size[0] / across if turns and across > 0.0 else 0.0


@compiled
def _smooth_distance(
    kind_a: int, size_a: Floats, vertices_a: Floats, kind_b: int, size_b: Floats, vertices_b: Floats,
    M: Floats, v: Floats, W: Floats,
) -> tuple[float, float]:  # fmt: skip
    """Bounds of the distance, from the features that face each other; points in row 11 of W.

    The reach H(m) of A - B along a unit direction m is least where its gradient, the furthest corner w of A - B, lies
    along m. Across the edges among the features, and with the bends of rims, its second derivative is known:

    1. Without edges m turns about two axes across it, with one about that edge; two edges say what it is.
    2. What w lacks to lie along m is made up along the edges; beyond their ends the guess was wrong.

    Args:
        kind_a, size_a, vertices_a, kind_b, size_b, vertices_b, M, W: as in `core_distance`.
        v: from the point of B to the point of A that are nearest so far.

    Returns:
        Lower and upper bound; the latter infinite where the guess was wrong.
    """
    length = np.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
    x, y, z = -v[0] / length, -v[1] / length, -v[2] / length
    u, p, q = _in_b(M, x, y, z)
    edge_a, edge_b = _feature(kind_a, size_a, x, y, z), _feature(kind_b, size_b, -u, -p, -q)
    if edge_a < 0 or edge_b < 0:
        return 0.0, np.inf
    ex, ey, ez = float(edge_a == 1), float(edge_a == 2), float(edge_a == 3)
    fx, fy, fz = 0.0, 0.0, 0.0
    if edge_b > 0:
        fx, fy, fz = M[0, edge_b - 1], M[1, edge_b - 1], M[2, edge_b - 1]
    if edge_a > 0 and edge_b > 0:  # 1
        cx, cy, cz = ey * fz - ez * fy, ez * fx - ex * fz, ex * fy - ey * fx
        sine = np.sqrt(cx * cx + cy * cy + cz * cz)
        if sine < ALONG:
            return 0.0, np.inf
        side = np.copysign(1.0, cx * x + cy * y + cz * z) / sine
        x, y, z = side * cx, side * cy, side * cz
    gx, gy, gz = ex + fx, ey + fy, ez + fz
    one, reach, ax, ay, az, bx, by, bz = (edge_a > 0) != (edge_b > 0), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for _ in range(TURNS):
        if one:
            out = gx * x + gy * y + gz * z
            x, y, z = x - out * gx, y - out * gy, z - out * gz
        share = 1.0 / np.sqrt(x * x + y * y + z * z)
        x, y, z = share * x, share * y, share * z
        u, p, q = _in_b(M, x, y, z)
        ax, ay, az = furthest(kind_a, size_a, vertices_a, x, y, z)
        bx, by, bz = furthest(kind_b, size_b, vertices_b, -u, -p, -q)
        ax, ay, az = ax * (edge_a != 1), ay * (edge_a != 2), az * (edge_a != 3)
        bx, by, bz = bx * (edge_b != 1), by * (edge_b != 2), bz * (edge_b != 3)
        bx, by, bz = (
            M[0, 0] * bx + M[0, 1] * by + M[0, 2] * bz + M[0, 3],
            M[1, 0] * bx + M[1, 1] * by + M[1, 2] * bz + M[1, 3],
            M[2, 0] * bx + M[2, 1] * by + M[2, 2] * bz + M[2, 3],
        )
        wx, wy, wz = ax - bx, ay - by, az - bz
        reach = wx * x + wy * y + wz * z
        if edge_a > 0 and edge_b > 0:
            break
        # Axes across m: the edge, or any; and what is across both.
        ox, oy, oz = (gx, gy, gz) if one else (0.0, z, -y) if abs(x) < 0.6 else (-z, 0.0, x)
        share = 1.0 / np.sqrt(ox * ox + oy * oy + oz * oz)
        ox, oy, oz = share * ox, share * oy, share * oz
        tx, ty, tz = oy * z - oz * y, oz * x - ox * z, ox * y - oy * x
        bend_a, bend_b = _bend(kind_a, size_a, x, y, z), _bend(kind_b, size_b, -u, -p, -q)
        share_a, share_b = x * x + y * y, u * u + p * p
        bend_a, bend_b = bend_a / max(share_a, LEAST_DIVISOR), bend_b / max(share_b, LEAST_DIVISOR)
        rx, ry, rz = M[0, 2], M[1, 2], M[2, 2]
        rx, ry, rz = ry * z - rz * y, rz * x - rx * z, rx * y - ry * x
        at, bt = tx * -y + ty * x, tx * rx + ty * ry + tz * rz
        ao, bo = (ox * -y + oy * x, ox * rx + oy * ry + oz * rz) if not one else (0.0, 0.0)
        tt = bend_a * at * at + bend_b * bt * bt - reach
        to, oo = bend_a * at * ao + bend_b * bt * bo, bend_a * ao * ao + bend_b * bo * bo - reach
        slope_t = wx * tx + wy * ty + wz * tz
        slope_o = wx * ox + wy * oy + wz * oz if not one else 0.0
        scale = tt * oo - to * to
        if not scale > 0.0 or not reach < 0.0:
            return 0.0, np.inf
        turn_t, turn_o = (to * slope_o - oo * slope_t) / scale, (to * slope_t - tt * slope_o) / scale
        x, y, z = x + turn_t * tx + turn_o * ox, y + turn_t * ty + turn_o * oy, z + turn_t * tz + turn_o * oz
        if turn_t * turn_t + turn_o * turn_o < TURNED:
            break
    wx, wy, wz = ax - bx, ay - by, az - bz  # 2
    on_a, on_b, c = wx * ex + wy * ey + wz * ez, wx * fx + wy * fy + wz * fz, ex * fx + ey * fy + ez * fz
    on_a, on_b = (on_a - c * on_b) / (1.0 - c * c), (on_b - c * on_a) / (1.0 - c * c)
    if (edge_a > 0 and abs(on_a) > size_a[edge_a - 1]) or (edge_b > 0 and abs(on_b) > size_b[edge_b - 1]):
        return 0.0, np.inf
    ax, ay, az = ax - on_a * ex, ay - on_a * ey, az - on_a * ez
    bx, by, bz = bx + on_b * fx, by + on_b * fy, bz + on_b * fz
    W[11, 0], W[11, 1], W[11, 2], W[11, 3], W[11, 4], W[11, 5] = ax, ay, az, bx, by, bz
    wx, wy, wz = ax - bx, ay - by, az - bz
    length = np.sqrt(wx * wx + wy * wy + wz * wz)
    if not length > 0.0:
        return 0.0, np.inf
    corner(kind_a, size_a, vertices_a, kind_b, size_b, vertices_b, M, -wx, -wy, -wz, W[12])
    return (wx * W[12, 0] + wy * W[12, 1] + wz * W[12, 2]) / length, length


@inlined
def _in_b(M: Floats, x: float, y: float, z: float) -> tuple[float, float, float]:
    """A direction in the frame of B."""
    return (
        M[0, 0] * x + M[1, 0] * y + M[2, 0] * z,
        M[0, 1] * x + M[1, 1] * y + M[2, 1] * z,
        M[0, 2] * x + M[1, 2] * y + M[2, 2] * z,
    )


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
