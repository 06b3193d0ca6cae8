"""Signed distance of two convex pieces, compiled: closed forms where they are exact and short, else GJK and a depth.

1. Points and segments (balls and capsules), a point and a box, cylinder or cone, a half space and any: closed forms.
2. Else the cores' distance by GJK; where they meet, their depth and its points by a polytope (`depth_loops`). Where its
   bounds stay apart, B goes back by the depth and a little more, GJK finds the points, and what it found over is taken
   off again. On round cores the normal found there is nearer to the best one than the last was, so it is done again.
   Where cores all but touch, their distance has no direction: the normal is that of the depth.
3. The roundings come off: distance, points and normal are those of the pieces.
"""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats
from mafsil.collision import depth_loops
from mafsil.collision.depth_loops import box_depth, grown_depth
from mafsil.collision.gjk_loops import core_distance
from mafsil.collision.piece_loops import Pieces, furthest, relative
from mafsil.kernels.loops.loop import compiled

CLEAR = 0.1
"""How far, relative to the size of the smaller core, B is moved beyond its depth to find the points."""
CLOSED = 1e-9
"""Gap of the bounds of a depth, relative to the sizes of both cores, at which its points are taken as they are."""
TOUCHING = 1e-8
"""Distance of cores, relative to their sizes, below which rounding decides its direction: then the normal is that of
the faces that touch."""
TURNED = 1e-5
"""Gap of the bounds, relative to the distance, above which its direction is not known; cores may be nearer to each
other than this, relative to their sizes, for that."""
PARALLEL = 1e-6
"""Square of the sine of the angle between two lines below which where they are nearest is known too badly."""
SHARPENED = 40
"""Times that a depth of round cores is sharpened at most."""
WORKSPACE = (40 + depth_loops.WORKSPACE, 10)
"""Shape of the array that `separation` works in; rows 24 to 39 are the caller's."""
ROW = 10
"""Numbers of a separation: distance, point on A, point on B, normal from B to A."""


@compiled
def _set_normal(W: Floats, x: float, y: float, z: float, size: float) -> float:
    """Row 6 of W: the unit vector along (x, y, z), as it was if rounding decides its direction; the length.

    Args:
        size: of the cores.
    """
    length = np.sqrt(x * x + y * y + z * z)
    if length > TOUCHING * size:
        W[6, 0], W[6, 1], W[6, 2] = x / length, y / length, z / length
    return length


@compiled
def _segments(h: float, k: float, M: Floats, W: Floats) -> float:
    """Distance of two segments of half lengths h and k, points in row 5, normal in row 6.

    1. The point of each line nearest to the other line, if both lie within the segments.
    2. Each end to the other segment: without 1 the nearest pair has an end in it, and of lines that are nearly parallel
       rounding decides 1.
    3. Segments that meet lie in a plane, and its normal parts them.
    """
    dx, dy, dz = M[0, 2], M[1, 2], M[2, 2]
    cx, cy, cz = M[0, 3], M[1, 3], M[2, 3]
    best, s, t = np.inf, 0.0, 0.0
    across = dx * dx + dy * dy
    if across > 0.0:  # 1
        t = -(dx * cx + dy * cy) / across
        s = cz + t * dz
        if abs(t) <= k and abs(s) <= h:
            best = (cx + t * dx) ** 2 + (cy + t * dy) ** 2
    if best == np.inf or across < PARALLEL:
        for end in (-1.0, 1.0):  # 2
            u = end * h
            v = min(k, max(-k, dz * (u - cz) - dx * cx - dy * cy))
            square = (cx + v * dx) ** 2 + (cy + v * dy) ** 2 + (cz + v * dz - u) ** 2
            if square < best:
                best, s, t = square, u, v
            v = end * k
            u = min(h, max(-h, cz + v * dz))
            square = (cx + v * dx) ** 2 + (cy + v * dy) ** 2 + (cz + v * dz - u) ** 2
            if square < best:
                best, s, t = square, u, v
    W[5, 0], W[5, 1], W[5, 2] = 0.0, 0.0, s
    W[5, 3], W[5, 4], W[5, 5] = cx + t * dx, cy + t * dy, cz + t * dz
    W[6, 0], W[6, 1], W[6, 2] = 1.0, 0.0, 0.0  # 3
    if across > 0.0:
        W[6, 0], W[6, 1] = -dy / np.sqrt(across), dx / np.sqrt(across)
    return _set_normal(W, -W[5, 3], -W[5, 4], s - W[5, 5], h + k)


@compiled
def _point_in_box(size: Floats, x: float, y: float, z: float, W: Floats) -> float:
    """Signed distance of a box (A) and a point (B), points in row 5, normal in row 6."""
    W[5, 3], W[5, 4], W[5, 5] = x, y, z
    depth, axis = np.inf, 0
    for k in range(3):
        W[5, k] = min(size[k], max(-size[k], W[5, 3 + k]))
        W[6, k] = 0.0
        if size[k] - abs(W[5, 3 + k]) < depth:
            depth, axis = size[k] - abs(W[5, 3 + k]), k
    side = 1.0 if W[5, 3 + axis] >= 0.0 else -1.0
    W[6, axis] = -side
    length = _set_normal(W, W[5, 0] - x, W[5, 1] - y, W[5, 2] - z, size[0] + size[1] + size[2])
    if length > 0.0:
        return length
    W[5, axis] = side * size[axis]
    return -depth


@compiled
def _point_in_cylinder(size: Floats, x: float, y: float, z: float, W: Floats) -> float:
    """Signed distance of a cylinder (A) and a point (B), points in row 5, normal in row 6."""
    across = np.sqrt(x * x + y * y)
    ux, uy = (x / across, y / across) if across > 0.0 else (1.0, 0.0)
    side = 1.0 if z >= 0.0 else -1.0
    wall, cap = size[0] - across, size[2] - abs(z)
    W[5, 3], W[5, 4], W[5, 5] = x, y, z
    W[6, 0], W[6, 1], W[6, 2] = 0.0, 0.0, -side
    if wall < cap:
        W[6, 0], W[6, 1], W[6, 2] = -ux, -uy, 0.0
    if wall < 0.0 or cap < 0.0:
        radius, height = min(across, size[0]), min(size[2], max(-size[2], z))
        W[5, 0], W[5, 1], W[5, 2] = radius * ux, radius * uy, height
        return _set_normal(W, (radius - across) * ux, (radius - across) * uy, height - z, size[0] + size[2])
    if wall < cap:
        W[5, 0], W[5, 1], W[5, 2] = size[0] * ux, size[0] * uy, z
    else:
        W[5, 0], W[5, 1], W[5, 2] = x, y, side * size[2]
    return -min(wall, cap)


@compiled
def _point_in_cone(size: Floats, x: float, y: float, z: float, W: Floats) -> float:
    """Signed distance of a cone (A) and a point (B), points in row 5, normal in row 6.

    1. In the half plane through the axis and the point the cone is a triangle: the point nearest on its slant and on
       its base; the nearer of them, and the normal of that side.
    2. The point is inside if it is above the base and below the slant.
    """
    across = np.sqrt(x * x + y * y)
    ux, uy = (x / across, y / across) if across > 0.0 else (1.0, 0.0)
    r, h = size[0], size[2]
    share = (2.0 * h * (z + h) - r * (across - r)) / (r * r + 4.0 * h * h)  # 1
    share = min(1.0, max(0.0, share))
    slant_across, slant_up = r * (1.0 - share), 2.0 * h * share - h
    slant = np.sqrt((across - slant_across) ** 2 + (z - slant_up) ** 2)
    base = np.sqrt(max(0.0, across - r) ** 2 + (z + h) ** 2)
    side = np.sqrt(r * r + 4.0 * h * h)
    W[6, 0], W[6, 1], W[6, 2] = -2.0 * h / side * ux, -2.0 * h / side * uy, -r / side
    if base < slant:
        slant_across, slant_up = min(across, r), -h
        W[6, 0], W[6, 1], W[6, 2] = 0.0, 0.0, 1.0
    W[5, 0], W[5, 1], W[5, 2] = slant_across * ux, slant_across * uy, slant_up
    W[5, 3], W[5, 4], W[5, 5] = x, y, z
    inside = z > -h and 2.0 * h * across < r * (h - z)  # 2
    sign = -1.0 if inside else 1.0
    away = sign * (slant_across - across)
    return sign * _set_normal(W, away * ux, away * uy, sign * (slant_up - z), r + h)


@compiled
def _half_space(kind: int, size: Floats, vertices: Floats, M: Floats, W: Floats) -> float:
    """Signed distance of a core (A) and a half space (B), points in row 5, normal in row 6."""
    nx, ny, nz = M[0, 2], M[1, 2], M[2, 2]
    x, y, z = furthest(kind, size, vertices, -nx, -ny, -nz)
    height = (x - M[0, 3]) * nx + (y - M[1, 3]) * ny + (z - M[2, 3]) * nz
    W[5, 0], W[5, 1], W[5, 2] = x, y, z
    W[5, 3], W[5, 4], W[5, 5] = x - height * nx, y - height * ny, z - height * nz
    W[6, 0], W[6, 1], W[6, 2] = nx, ny, nz
    return height


@compiled
def _swap(W: Floats, M: Floats) -> None:
    """The points and normal in rows 5 and 6, found with A and B exchanged in the frame of B, in the frame of A."""
    for k in range(6):
        W[12, k], W[13, k] = W[5, k], W[6, k]
    for k in range(3):
        W[5, k] = M[k, 0] * W[12, 3] + M[k, 1] * W[12, 4] + M[k, 2] * W[12, 5] + M[k, 3]
        W[5, 3 + k] = M[k, 0] * W[12, 0] + M[k, 1] * W[12, 1] + M[k, 2] * W[12, 2] + M[k, 3]
        W[6, k] = -(M[k, 0] * W[13, 0] + M[k, 1] * W[13, 1] + M[k, 2] * W[13, 2])


@compiled
def _inverse(M: Floats, N: Floats) -> None:
    for i in range(3):
        for j in range(3):
            N[i, j] = M[j, i]
        N[i, 3] = -(M[0, i] * M[0, 3] + M[1, i] * M[1, 3] + M[2, i] * M[2, 3])


@compiled
def _meeting(
    kind_a: int, size_a: Floats, vertices_a: Floats, kind_b: int, size_b: Floats, vertices_b: Floats,
    M: Floats, corners: int, W: Floats,
) -> float:  # fmt: skip
    """Minus the depth of two cores that meet, points in row 5, normal in row 6.

    1. Two boxes or simpler have their depth in closed form, others bounds of it that meet; those have points too.
    2. Else B moves back along that direction until it is just clear; the distance there sharpens depth and direction,
       again while that gains something. B stands where it stood.
    3. The points nearest to each other are placed a depth apart about their middle.
    """
    n, sharpened, size = W[6], 1, _extent(kind_a, size_a, vertices_a)
    other = _extent(kind_b, size_b, vertices_b)
    if kind_a <= 2 and kind_b <= 2:  # 1
        depth = box_depth(size_a, size_b, M, n)
    else:
        lower, depth = grown_depth(
            kind_a, size_a, vertices_a, kind_b, size_b, vertices_b, M, W[0:5], corners, W[5:7], W[40:]
        )  # fmt: skip
        if depth != 0.0 and depth - lower <= CLOSED * (size + other):
            _part_about_middle(W[5], max(depth, 0.0), W)
            return -max(depth, 0.0)
        sharpened = SHARPENED
    depth = max(depth, 0.0)
    clear = CLEAR * (min(size, other) if min(size, other) > 0.0 else max(size, other))
    px, py, pz = M[0, 3], M[1, 3], M[2, 3]
    nx, ny, nz = n[0], n[1], n[2]
    found = np.inf
    for _ in range(sharpened):  # 2
        back = depth + clear
        M[0, 3], M[1, 3], M[2, 3] = px - back * nx, py - back * ny, pz - back * nz
        _, over, _ = core_distance(kind_a, size_a, vertices_a, kind_b, size_b, vertices_b, M, np.inf, W)
        if over <= 0.0:
            break
        ux, uy, uz = (W[5, 0] - W[5, 3]) / over, (W[5, 1] - W[5, 4]) / over, (W[5, 2] - W[5, 5]) / over
        reach = back * (nx * ux + ny * uy + nz * uz) - over
        if not reach < found + 1e-12 * clear:
            break
        gained = found - reach
        found = max(reach, 0.0)
        W[14, 0], W[14, 1], W[14, 2] = W[5, 0], W[5, 1], W[5, 2]
        W[14, 3], W[14, 4], W[14, 5] = W[5, 3] + back * nx, W[5, 4] + back * ny, W[5, 5] + back * nz
        depth, nx, ny, nz = found, ux, uy, uz
        if gained <= 1e-14 * clear or reach <= 0.0:
            break
    M[0, 3], M[1, 3], M[2, 3] = px, py, pz
    W[6, 0], W[6, 1], W[6, 2] = nx, ny, nz
    if found < np.inf:  # 3
        _part_about_middle(W[14], found, W)
    return -depth


@compiled
def _part_about_middle(points: Floats, depth: float, W: Floats) -> None:
    """Points in row 5, a depth apart along the normal about the middle of two points."""
    for k in range(3):
        middle, half = (points[k] + points[3 + k]) / 2.0, depth / 2.0 * W[6, k]
        W[5, k], W[5, 3 + k] = middle - half, middle + half


@compiled
def _extent(kind: int, size: Floats, vertices: Floats) -> float:
    """A length of the core: zero for a point alone."""
    if kind != 5:
        return size[0] + size[1] + size[2]
    most = 0.0
    for i in range(1, len(vertices)):
        for k in range(3):
            most = max(most, abs(vertices[i, k] - vertices[0, k]))
    return most


@compiled
def _point_in(kind: int, size: Floats, M: Floats, W: Floats) -> float:
    if kind == 2:
        return _point_in_box(size, M[0, 3], M[1, 3], M[2, 3], W)
    if kind == 4:
        return _point_in_cone(size, M[0, 3], M[1, 3], M[2, 3], W)
    return _point_in_cylinder(size, M[0, 3], M[1, 3], M[2, 3], W)


@compiled
def core_pair(
    kind_a: int, size_a: Floats, vertices_a: Floats, kind_b: int, size_b: Floats, vertices_b: Floats,
    M: Floats, cutoff: float, deep: bool, W: Floats,
) -> tuple[float, float]:  # fmt: skip
    """Bounds of the signed distance of two cores; the points in row 5 of W and the normal in row 6, unless cut off.

    Args:
        kind_a, size_a, vertices_a, kind_b, size_b, vertices_b, M, cutoff: as in `core_distance`.
        deep: whether to look for the depth of cores that meet; else their distance is 0, without points.
        W: WORKSPACE to work in.
    """
    if kind_b == 6:  # 1
        signed = _half_space(kind_a, size_a, vertices_a, M, W)
        return signed, signed
    if kind_a == 6:
        _inverse(M, W[16:19])
        signed = _half_space(kind_b, size_b, vertices_b, W[16:19], W)
        _swap(W, M)
        return signed, signed
    if kind_a <= 1 and kind_b <= 1:
        signed = _segments(size_a[2], size_b[2], M, W)
        return signed, signed
    if kind_b == 0 and 2 <= kind_a <= 4:
        signed = _point_in(kind_a, size_a, M, W)
        return signed, signed
    if kind_a == 0 and 2 <= kind_b <= 4:
        _inverse(M, W[16:19])
        signed = _point_in(kind_b, size_b, W[16:19], W)
        _swap(W, M)
        return signed, signed
    lower, upper, corners = core_distance(  # 2
        kind_a, size_a, vertices_a, kind_b, size_b, vertices_b, M, cutoff, W
    )  # fmt: skip
    if upper == 0.0:
        if not deep:
            return 0.0, 0.0
        upper = _meeting(kind_a, size_a, vertices_a, kind_b, size_b, vertices_b, M, corners, W)
        return upper, upper
    if lower > cutoff:
        return lower, upper
    x, y, z = W[5, 0] - W[5, 3], W[5, 1] - W[5, 4], W[5, 2] - W[5, 5]
    size = _extent(kind_a, size_a, vertices_a) + _extent(kind_b, size_b, vertices_b)
    if upper <= TOUCHING * size or (upper - lower > TURNED * upper and upper <= TURNED * size):
        for k in range(6):
            W[15, k] = W[5, k]
        _meeting(kind_a, size_a, vertices_a, kind_b, size_b, vertices_b, M, corners, W)
        _part_about_middle(W[15], -upper, W)
        return lower, upper
    _set_normal(W, x, y, z, 0.0)
    return lower, upper


@compiled
def separation(
    A: Pieces, i: int, T_a: Floats, B: Pieces, j: int, T_b: Floats, cutoff: float, deep: bool, W: Floats, out: Floats
) -> float:  # fmt: skip
    """Lower bound of the signed distance of piece i of A and piece j of B.

    Args:
        T_a, T_b: (3, 4) their poses in {s}.
        cutoff: a lower bound above it ends the search, and `out` stays as it was.
        deep: whether to look for the depth of cores that meet; else only the verdict counts.
        W: WORKSPACE to work in.
        out: (ROW,) distance, point on A, point on B, normal from B to A, in {s}.
    """
    M = W[20:23]
    relative(T_a, T_b, M)
    a, b = A.rows[i], B.rows[j]
    rounding = a[4] + b[4]
    lower, upper = core_pair(
        int(a[0]), a[1:4], A.vertices[int(a[5]) : int(a[5] + a[6])],
        int(b[0]), b[1:4], B.vertices[int(b[5]) : int(b[5] + b[6])],
        M, cutoff + rounding, deep, W,
    )  # fmt: skip
    if lower - rounding > cutoff:
        return lower - rounding
    out[0] = upper - rounding  # 3
    for k in range(3):
        out[1 + k], out[4 + k], out[7 + k] = T_a[k, 3], T_a[k, 3], 0.0
        for c in range(3):
            out[1 + k] += T_a[k, c] * (W[5, c] - a[4] * W[6, c])
            out[4 + k] += T_a[k, c] * (W[5, 3 + c] + b[4] * W[6, c])
            out[7 + k] += T_a[k, c] * W[6, c]
    return lower - rounding
