"""How deep two convex cores lie in each other, compiled: the shortest translation that parts them.

The depth is the least reach of the difference A - B over all directions n. Segments and boxes are sums of segments:
the least reach is at a normal of a face of their difference, a cross product of two edges (`box_depth`). For other
cores a polytope inside the difference grows where its nearest face is (`grown_depth`): that face's distance bounds the
depth from below, the reach along its normal from above.

Reference:
    G. van den Bergen, Proximity queries and penetration depth computation on 3D game objects, GDC 2001.
"""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats
from mafsil.collision.piece_loops import corner
from mafsil.kernels.loops.loop import compiled, inlined

MOST_CORNERS = 160
WORKSPACE = 11 * MOST_CORNERS + 2
"""Rows of the array that a polytope grows in."""
GAP = 1e-10
"""Gap of the bounds of a depth, relative to the size of the difference, at which it is found."""
FLAT = 1e-10
"""Thickness, relative to its length, below which a simplex is flat."""


@compiled
def box_depth(size_a: Floats, size_b: Floats, M: Floats, n: Floats) -> float:
    """Depth of two boxes, or of a segment (a box without width) and a box, that overlap.

    1. Normals: the axes of A, the axes of B, cross products of one of A and one of B.
    2. The reach of A - B along +n and -n; the least of all is the depth, n the way for A out of B.

    Args:
        size_a, size_b: (3,) half lengths.
        M: (3, 4) pose of B in A.
        n: (3,) out: unit direction in A along which A leaves B soonest.
    """
    best = np.inf
    for k in range(15):  # 1
        x, y, z = 0.0, 0.0, 0.0
        if k < 3:
            x, y, z = 1.0 * (k == 0), 1.0 * (k == 1), 1.0 * (k == 2)
        elif k < 6:
            x, y, z = M[0, k - 3], M[1, k - 3], M[2, k - 3]
        else:
            i, j = (k - 6) // 3, (k - 6) % 3
            bx, by, bz = M[0, j], M[1, j], M[2, j]
            if i == 0:
                y, z = -bz, by
            elif i == 1:
                x, z = bz, -bx
            else:
                x, y = -by, bx
            length = np.sqrt(x * x + y * y + z * z)
            if length < 1e-9:
                continue
            x, y, z = x / length, y / length, z / length
        reach = abs(x) * size_a[0] + abs(y) * size_a[1] + abs(z) * size_a[2]  # 2
        for j in range(3):
            reach += size_b[j] * abs(x * M[0, j] + y * M[1, j] + z * M[2, j])
        offset = x * M[0, 3] + y * M[1, 3] + z * M[2, 3]
        depth = reach - abs(offset)
        if depth < best:
            best = depth
            sign = -1.0 if offset > 0.0 else 1.0
            n[0], n[1], n[2] = sign * x, sign * y, sign * z
    return best


@compiled
def _cross(a: Floats, b: Floats, c: Floats, n: Floats) -> float:
    """Normal n of the triangle abc, of length one if it has an area; its length before."""
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    n[0], n[1], n[2] = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    length = np.sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2])
    if length > 0.0:
        for k in range(3):
            n[k] /= length
    return length


@compiled
def _thicken(
    kind_a: int, size_a: Floats, vertices_a: Floats, kind_b: int, size_b: Floats, vertices_b: Floats,
    M: Floats, C: Floats, count: int, n: Floats,
) -> int:  # fmt: skip
    """Corners of a simplex around the origin made a tetrahedron; how many there are: fewer than 4 if A - B is flat.

    1. A point becomes a segment: the first corner along an axis that lies elsewhere.
    2. A segment becomes a triangle: the first corner off its line, in six directions around it.
    3. A triangle becomes a tetrahedron: a corner off its plane, to one side or the other.

    Args:
        C: (4 or more, 6) the first `count` rows are corners of A - B; the others are filled in.
        n: (3,) out: of a flat difference its normal.
    """
    scale = np.sqrt(size_of(C, count))
    if count == 1:  # 1
        for k in range(6):
            sign, axis = 1.0 - 2.0 * (k % 2), k // 2
            corner(
                kind_a, size_a, vertices_a, kind_b, size_b, vertices_b, M,
                sign * (axis == 0), sign * (axis == 1), sign * (axis == 2), C[1],
            )  # fmt: skip
            scale = max(scale, np.sqrt(size_of(C, 2)))
            if _apart(C[0], C[1]) > FLAT * scale and _apart(C[0], C[1]) > 0.0:
                count = 2
                break
        if count == 1:
            n[0], n[1], n[2] = 0.0, 0.0, 1.0
            return 1
    if count == 2:  # 2
        ux, uy, uz = C[1, 0] - C[0, 0], C[1, 1] - C[0, 1], C[1, 2] - C[0, 2]
        length = np.sqrt(ux * ux + uy * uy + uz * uz)
        ux, uy, uz = ux / length, uy / length, uz / length
        ax, ay, az = (1.0, 0.0, 0.0) if abs(ux) < 0.6 else (0.0, 1.0, 0.0)
        px, py, pz = uy * az - uz * ay, uz * ax - ux * az, ux * ay - uy * ax
        for k in range(6):
            turn = k * np.pi / 3.0
            c, s = np.cos(turn), np.sin(turn)
            x = c * px + s * (uy * pz - uz * py)
            y = c * py + s * (uz * px - ux * pz)
            z = c * pz + s * (ux * py - uy * px)
            corner(kind_a, size_a, vertices_a, kind_b, size_b, vertices_b, M, x, y, z, C[2])
            if _cross(C[0], C[1], C[2], n) > FLAT * length * max(scale, length):
                count = 3
                break
        if count == 2:
            n[0], n[1], n[2] = px, py, pz
            return 2
    if count == 3:  # 3
        _cross(C[0], C[1], C[2], n)
        for sign in (1.0, -1.0):
            corner(
                kind_a, size_a, vertices_a, kind_b, size_b, vertices_b, M,
                sign * n[0], sign * n[1], sign * n[2], C[3],
            )  # fmt: skip
            height = 0.0
            for k in range(3):
                height += n[k] * (C[3, k] - C[0, k])
            if abs(height) > FLAT * scale:
                return 4
        return 3
    return 4


@compiled
def size_of(C: Floats, count: int) -> float:
    """Largest square of the distance of some corners from the origin."""
    most = 0.0
    for i in range(count):
        most = max(most, C[i, 0] * C[i, 0] + C[i, 1] * C[i, 1] + C[i, 2] * C[i, 2])
    return most


@compiled
def _apart(a: Floats, b: Floats) -> float:
    return np.sqrt((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2)


@inlined
def _add_face(faces: Floats, at: int, i: int, j: int, k: int, C: Floats, inside: Floats) -> None:
    """Row `at` of the faces: the normal of three corners away from `inside`, its distance, the corners' indices."""
    ax, ay, az = C[i, 0], C[i, 1], C[i, 2]
    ux, uy, uz = C[j, 0] - ax, C[j, 1] - ay, C[j, 2] - az
    vx, vy, vz = C[k, 0] - ax, C[k, 1] - ay, C[k, 2] - az
    x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    length = np.sqrt(x * x + y * y + z * z)
    share = 1.0 / length if length > 0.0 else 0.0
    if x * (inside[0] - ax) + y * (inside[1] - ay) + z * (inside[2] - az) > 0.0:
        share, j, k = -share, k, j
    n = faces[at]
    n[0], n[1], n[2] = share * x, share * y, share * z
    n[3] = n[0] * ax + n[1] * ay + n[2] * az if length > 0.0 else np.inf
    n[4], n[5], n[6] = i, j, k


@inlined
def _nearest_face(faces: Floats, total: int) -> int:
    """The face whose plane is nearest to the origin."""
    near, least = 0, faces[0, 3]
    for k in range(1, total):
        if faces[k, 3] < least:
            near, least = k, faces[k, 3]
    return near


@compiled
def grown_depth(
    kind_a: int, size_a: Floats, vertices_a: Floats, kind_b: int, size_b: Floats, vertices_b: Floats,
    M: Floats, S: Floats, count: int, deepest: Floats, W: Floats,
) -> tuple[float, float]:  # fmt: skip
    """Bounds of the depth of two cores that meet, by a polytope that grows inside their difference.

    1. The corners that GJK left become a tetrahedron; a difference without volume has depth 0.
    2. The face nearest to the origin bounds the depth from below, the corner furthest along its normal from above.
    3. Where the bounds of one face meet, that is the depth; else the corner joins: faces that see it go, and it is
       joined to the edges that only one of them had.
    4. The foot of the origin on the best face is a mean of its corners; the same mean of points of A and B is where
       they are deepest.

    Args:
        kind_a, size_a, vertices_a, kind_b, size_b, vertices_b, M: as in `core_distance`.
        S: (4 or more, 6) corners of the simplex that GJK ended with.
        count: of them.
        deepest: (2, 6) out: points of A and B; unit direction in A along which A leaves B soonest, as far as the upper
            bound. Of a difference without volume the direction alone.
        W: (WORKSPACE, 10) to work in: corners, faces, edges.

    Returns:
        Lower and upper bound.
    """
    last = MOST_CORNERS + 4 * MOST_CORNERS
    C, faces, edges = W[:MOST_CORNERS], W[MOST_CORNERS:last], W[last : last + 6 * MOST_CORNERS]
    inside, best = W[last + 6 * MOST_CORNERS], W[last + 6 * MOST_CORNERS + 1]
    for k in range(count):
        for c in range(6):
            C[k, c] = S[k, c]
    if _thicken(kind_a, size_a, vertices_a, kind_b, size_b, vertices_b, M, C, count, deepest[1]) < 4:  # 1
        return 0.0, 0.0
    for k in range(3):
        inside[k] = (C[0, k] + C[1, k] + C[2, k] + C[3, k]) / 4.0
    for k in range(4):
        _add_face(faces, k, k, (k + 1) % 4, (k + 2) % 4, C, inside)
    corners, total, lower, upper = 4, 4, 0.0, np.inf
    gap = GAP * np.sqrt(size_of(C, 4))
    while True:
        near = _nearest_face(faces, total)  # 2
        x, y, z, height = faces[near, 0], faces[near, 1], faces[near, 2], faces[near, 3]
        w = C[corners]
        corner(kind_a, size_a, vertices_a, kind_b, size_b, vertices_b, M, x, y, z, w)
        wx, wy, wz = w[0], w[1], w[2]
        reach = x * wx + y * wy + z * wz
        lower = max(lower, height)
        closed = reach - height <= gap
        if closed or reach < upper:
            upper = reach
            for c in range(7):
                best[c] = faces[near, c]
        if closed or corners == MOST_CORNERS - 1:
            break
        count, k = 0, 0  # 3
        while k < total:
            if faces[k, 0] * wx + faces[k, 1] * wy + faces[k, 2] * wz <= faces[k, 3] and k != near:
                k += 1
                continue
            if count + 3 > len(edges):  # Of a polytope so thin that its faces are turned at random.
                total = 0
                break
            for c in range(3):
                count = _open_edge(edges, count, faces[k, 4 + c], faces[k, 4 + (c + 1) % 3])
            total -= 1
            if near == k:
                near = -1
            elif near == total:
                near = k
            for c in range(7):
                faces[k, c] = faces[total, c]
        if total == 0 or count == 0 or total + count > len(faces):
            break
        for e in range(count):
            _add_face(faces, total + e, int(edges[e, 0]), int(edges[e, 1]), corners, C, inside)
        total += count
        corners += 1
    off, k = _place_foot(C, best, best, deepest), 0
    while off > gap and k < total:
        if faces[k, 3] <= upper + gap:
            off = _place_foot(C, best, faces[k], deepest)
        k += 1
    return min(max(lower, 0.0) - off, upper), upper


@inlined
def _open_edge(edges: Floats, count: int, i: float, j: float) -> int:
    """The edges that one face alone had, after one of a face that goes, from i to j; how many."""
    for e in range(count):
        if edges[e, 0] == j and edges[e, 1] == i:
            edges[e, 0], edges[e, 1] = edges[count - 1, 0], edges[count - 1, 1]
            return count - 1
    edges[count, 0], edges[count, 1] = i, j
    return count + 1


@compiled
def _place_foot(C: Floats, best: Floats, face: Floats, deepest: Floats) -> float:
    """Points of A and B whose difference is the foot of the origin on the best face (step 4), and the way along it.

    Args:
        face: that face, or one in the same plane, which is to hold the foot.

    Returns:
        How far their difference is from the foot: more than rounding if that lies beside the face.
    """
    total, x, y, z = 0.0, 0.0, 0.0, 0.0
    for k in range(6):
        deepest[0, k] = 0.0
    for c in range(3):
        a, b, w = C[int(face[4 + c])], C[int(face[4 + (c + 1) % 3])], C[int(face[4 + (c + 2) % 3])]
        share = (
            face[0] * (a[1] * b[2] - a[2] * b[1])
            + face[1] * (a[2] * b[0] - a[0] * b[2])
            + face[2] * (a[0] * b[1] - a[1] * b[0])
        )
        share = max(share, 0.0)
        total, x, y, z = total + share, x + share * w[0], y + share * w[1], z + share * w[2]
        for k in range(3):
            deepest[0, k] += share * w[3 + k]
    if total > 0.0:
        x, y, z, total = x / total, y / total, z / total, 1.0 / total
    for k in range(3):
        deepest[0, k] *= total
        deepest[0, 3 + k] = deepest[0, k] - best[3] * best[k]
        deepest[1, k] = -best[k]
    x, y, z = x - best[3] * best[0], y - best[3] * best[1], z - best[3] * best[2]
    return np.sqrt(x * x + y * y + z * z) if total > 0.0 else np.inf
