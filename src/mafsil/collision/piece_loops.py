"""Convex pieces in compiled loops: what a row of `Pieces` means, its furthest point, and a tree of boxes around many.

A piece is a core and a rounding: all points within `rounding` of the core. A ball is a point, a capsule a segment, a
triangle or a hull its corners; what is round stays exact. Cores stand in their own frame:

    POINT      the origin
    SEGMENT    from (0, 0, -h) to (0, 0, h);                         size = (0, 0, h)
    BOX        |x| <= size[0], |y| <= size[1], |z| <= size[2]
    CYLINDER   radius r, axis along z, |z| <= h;                     size = (r, 0, h)
    CONE       radius r at z = -h, apex at z = h;                    size = (r, 0, h)
    HULL       the convex hull of `corners` rows of `vertices` from `first` on
    PLANE      the half space z <= 0

Directions need no unit length.

Reference:
    C. Ericson, Real-Time Collision Detection, 2005, ch. 6.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.kernels.loops.loop import compiled, inlined

POINT, SEGMENT, BOX, CYLINDER, CONE, HULL, PLANE = range(7)
KIND, SIZE, ROUNDING, FIRST, CORNERS, BODY, BALL = 0, 1, 4, 5, 6, 7, 8
"""Columns of a piece's row; SIZE has 3, BALL 4."""
COLUMNS = 12


class Pieces(NamedTuple):
    """Convex pieces, one row each. Few arrays: a compiled function is handed each of them in nine numbers.

    Attributes:
        rows: (k, COLUMNS) kind, size (3), rounding, first and number of the corners of a hull, index of the body (a
            body of the arm, an obstacle of a scene), centre and radius of a ball around the piece in its body's frame
            (infinite for a half space).
        T: (k, 3, 4) pose (R, p) of the piece in its body.
        vertices: (v, 3) corners in the frames of their pieces.
    """

    rows: Floats
    T: Floats
    vertices: Floats


@compiled
def kind_of(A: Pieces, i: int) -> int:
    """Kind of a piece."""
    return int(A.rows[i, 0])


@compiled
def body_of(A: Pieces, i: int) -> int:
    """Index of the body that a piece belongs to."""
    return int(A.rows[i, 7])


@compiled
def furthest(kind: int, size: Floats, vertices: Floats, x: float, y: float, z: float) -> tuple[float, float, float]:
    """The point of a core that reaches furthest along a direction, in the core's frame.

    Args:
        kind, size: of the core.
        vertices: (c, 3) corners of a hull.
        x, y, z: the direction.
    """
    if kind == 2:
        return np.copysign(size[0], x), np.copysign(size[1], y), np.copysign(size[2], z)
    if kind == 5:
        best, at = -np.inf, 0
        for i in range(len(vertices)):
            reach = x * vertices[i, 0] + y * vertices[i, 1] + z * vertices[i, 2]
            if reach > best:
                best, at = reach, i
        return vertices[at, 0], vertices[at, 1], vertices[at, 2]
    if kind == 1:
        return 0.0, 0.0, np.copysign(size[2], z)
    if kind == 0:
        return 0.0, 0.0, 0.0
    across = np.sqrt(x * x + y * y)
    share = size[0] / across if across > 0.0 else 0.0
    if kind == 4 and 2.0 * size[2] * z >= size[0] * across:
        return 0.0, 0.0, size[2]
    height = -size[2] if kind == 4 else np.copysign(size[2], z)
    return share * x, share * y, height


@inlined
def relative(A: Floats, B: Floats, M: Floats) -> None:
    """Pose M of B in A, from their poses (3, 4) in one frame."""
    for i in range(3):
        for j in range(3):
            M[i, j] = A[0, i] * B[0, j] + A[1, i] * B[1, j] + A[2, i] * B[2, j]
        M[i, 3] = A[0, i] * (B[0, 3] - A[0, 3]) + A[1, i] * (B[1, 3] - A[1, 3]) + A[2, i] * (B[2, 3] - A[2, 3])


@inlined
def product(A: Floats, B: Floats, M: Floats) -> None:
    """Pose M = A B of poses whose first three rows are used."""
    for i in range(3):
        for j in range(4):
            M[i, j] = A[i, 0] * B[0, j] + A[i, 1] * B[1, j] + A[i, 2] * B[2, j]
        M[i, 3] += A[i, 3]


@compiled
def corner(
    kind_a: int, size_a: Floats, vertices_a: Floats, kind_b: int, size_b: Floats, vertices_b: Floats,
    M: Floats, x: float, y: float, z: float, w: Floats,
) -> None:  # fmt: skip
    """The corner of the difference of two cores that reaches furthest along a direction.

    Args:
        kind_a, size_a, vertices_a: core A, in whose frame all stands.
        kind_b, size_b, vertices_b: core B.
        M: (3, 4) pose of B in A.
        x, y, z: the direction.
        w: (6,) out: the corner a - b, then a.
    """
    ax, ay, az = furthest(kind_a, size_a, vertices_a, x, y, z)
    u = -(M[0, 0] * x + M[1, 0] * y + M[2, 0] * z)
    v = -(M[0, 1] * x + M[1, 1] * y + M[2, 1] * z)
    t = -(M[0, 2] * x + M[1, 2] * y + M[2, 2] * z)
    bx, by, bz = furthest(kind_b, size_b, vertices_b, u, v, t)
    w[0] = ax - (M[0, 0] * bx + M[0, 1] * by + M[0, 2] * bz + M[0, 3])
    w[1] = ay - (M[1, 0] * bx + M[1, 1] * by + M[1, 2] * bz + M[1, 3])
    w[2] = az - (M[2, 0] * bx + M[2, 1] * by + M[2, 2] * bz + M[2, 3])
    w[3], w[4], w[5] = ax, ay, az


ROUNDED = 1e-12
"""What boxes are larger by than their pieces, so that no rounding of either matters [m]."""
LEAF = 4
"""Pieces in a leaf at most."""
DEPTH = 64
"""Nodes that wait while a tree is walked, at most: halves of halves end long before."""


class Surroundings(NamedTuple):
    """What stands still: convex pieces posed in one frame, with what finds the near ones.

    Attributes:
        pieces: posed in {s}; first the half spaces, then the others in the order of the tree's leaves.
        nodes: (m, 9) of the tree: lowest and highest coordinates (6) of what a node holds, index of its first child
            (the second follows it; -1 at a leaf), first row of `pieces` that it holds, number of rows; node 0 is the
            root. Empty without bounded pieces.
        boxes: (k, 6) middles and half extents of boxes around the pieces, along the axes of {s}; infinite for half
            spaces.
        planes: number of half spaces.
    """

    pieces: Pieces
    nodes: Floats
    boxes: Floats
    planes: int


@compiled
def boxes_of(pieces: Pieces) -> Floats:
    """(k, 6) lowest and highest coordinates of each piece in its body's frame; of a half space without bounds."""
    spread = np.empty((len(pieces.rows), 6))
    for i in range(len(pieces.rows)):
        row, T = pieces.rows[i], pieces.T[i]
        kind, grown = int(row[0]), max(row[4], 0.0)
        for c in range(3):
            low, high = np.inf, -np.inf
            if kind == PLANE:
                low, high = -np.inf, np.inf
            elif kind == HULL:
                for v in range(int(row[5]), int(row[5] + row[6])):
                    corner = pieces.vertices[v]
                    at = T[c, 0] * corner[0] + T[c, 1] * corner[1] + T[c, 2] * corner[2]
                    low, high = min(low, at), max(high, at)
            else:
                high = abs(T[c, 0]) * row[1] + abs(T[c, 1]) * row[2] + abs(T[c, 2]) * row[3]
                if kind in (CYLINDER, CONE):
                    high = np.sqrt(max(0.0, 1.0 - T[c, 2] * T[c, 2])) * row[1] + abs(T[c, 2]) * row[3]
                low = -high
            spread[i, c], spread[i, 3 + c] = T[c, 3] + low - grown, T[c, 3] + high + grown
    return spread


@compiled
def surround(pieces: Pieces) -> Surroundings:
    """Pieces posed in {s}, half spaces first, with a tree over those that have bounds."""
    count, planes, k = len(pieces.rows), 0, 0
    spread, order, bounded = boxes_of(pieces), np.empty(count, np.int64), np.empty(count, np.int64)
    for i in range(count):
        if int(pieces.rows[i, 0]) == PLANE:
            order[planes] = i
            planes += 1
        else:
            bounded[k] = i
            k += 1
    some = np.empty((k, 6))
    for i in range(k):
        some[i] = spread[bounded[i]]
    nodes, leaves = build_tree(some)
    for i in range(k):
        order[planes + i] = bounded[leaves[i]]
    rows, T, around = np.empty((count, COLUMNS)), np.empty((count, 3, 4)), np.empty((count, 6))
    for i in range(count):
        rows[i], T[i] = pieces.rows[order[i]], pieces.T[order[i]]
        for c in range(3):
            low, high = spread[order[i], c], spread[order[i], 3 + c]
            middle = (low + high) / 2 if i >= planes else 0.0
            around[i, c], around[i, 3 + c] = middle, max(high - middle, middle - low) + ROUNDED
    return Surroundings(Pieces(rows, T, pieces.vertices), nodes, around, planes)


@compiled
def _partition(order: NDArray[np.int64], keys: Floats, first: int, last: int, middle: int) -> None:
    """Rows of `order` so that those before `middle` have keys no larger than it, those behind no smaller (Hoare)."""
    while first < last:
        pivot = keys[order[(first + last) // 2]]
        i, j = first, last
        while i <= j:
            while keys[order[i]] < pivot:
                i += 1
            while keys[order[j]] > pivot:
                j -= 1
            if i <= j:
                order[i], order[j] = order[j], order[i]
                i += 1
                j -= 1
        if middle <= j:
            last = j
        elif middle >= i:
            first = i
        else:
            return


@compiled
def build_tree(boxes: Floats) -> tuple[Floats, NDArray[np.int64]]:
    """Nodes (m, 9) of the tree over boxes (k, 6), and the order of the boxes in its leaves.

    Each node is halved at the median of the centres along the longest extent of the centres.
    """
    k = len(boxes)
    nodes, order, keys = np.empty((2 * k, 9)), np.arange(k), np.empty(k)
    made, at = 0, 0
    if k > 0:
        nodes[0, 6], nodes[0, 7], nodes[0, 8], made = -1, 0, k, 1
    while at < made:
        node = nodes[at]
        first, length = int(node[7]), int(node[8])
        node[:3], node[3:6] = np.inf, -np.inf
        low, high = np.full(3, np.inf), np.full(3, -np.inf)
        for r in range(first, first + length):
            row = boxes[order[r]]
            for c in range(3):
                node[c], node[3 + c] = min(node[c], row[c]), max(node[3 + c], row[3 + c])
                centre = row[c] + row[3 + c]
                low[c], high[c] = min(low[c], centre), max(high[c], centre)
        if length > LEAF:
            axis = np.argmax(high - low)
            for r in range(first, first + length):
                keys[order[r]] = boxes[order[r], axis] + boxes[order[r], 3 + axis]
            half = length // 2
            _partition(order, keys, first, first + length - 1, first + half)
            node[6] = made
            nodes[made, 6], nodes[made, 7], nodes[made, 8] = -1, first, half
            nodes[made + 1, 6], nodes[made + 1, 7], nodes[made + 1, 8] = -1, first + half, length - half
            made += 2
        at += 1
    return nodes[:made].copy(), order


@inlined
def box_gap(box: Floats, x: float, y: float, z: float) -> float:
    """Signed distance of a point to a box (6,): inside minus the distance to the nearest side."""
    dx, dy, dz = max(box[0] - x, x - box[3]), max(box[1] - y, y - box[4]), max(box[2] - z, z - box[5])
    most = max(dx, dy, dz)
    if most <= 0.0:
        return most
    dx, dy, dz = max(0.0, dx), max(0.0, dy), max(0.0, dz)
    return np.sqrt(dx * dx + dy * dy + dz * dz)
