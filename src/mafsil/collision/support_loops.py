"""Convex pieces in compiled loops: what a row of `Pieces` means, and its furthest point in a direction.

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
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

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
