"""Where a corner, an edge or a rim of one core is nearest to one of another, compiled: Newton's method ends a search.

On cylinders and cones the bounds of GJK meet slowly. Near the end the features that face each other show in the
direction found so far; their distance follows in a few steps, with a lower bound by which a wrong guess is known.
"""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats
from mafsil.collision.piece_loops import BOX, CONE, CYLINDER, HULL, SEGMENT, corner, furthest
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.kernels.loops.loop import compiled, inlined

ALONG = 0.05
"""Sine of the angle to a direction below which an edge or a side is guessed to lie across it."""
TURNED = 1e-14
"""Square of the angle of the last step of Newton's method: its own error is smaller by far."""
TURNS = 6
"""Steps of Newton's method at most."""


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
def feature_distance(
    kind_a: int, size_a: Floats, vertices_a: Floats, kind_b: int, size_b: Floats, vertices_b: Floats,
    M: Floats, v: Floats, W: Floats,
) -> tuple[float, float]:  # fmt: skip
    """Bounds of the distance, from the features that face each other; points in row 13 of W.

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
    e, f, place = W[11], W[12], W[13]
    for k in range(3):
        e[k] = 1.0 if edge_a == k + 1 else 0.0
        f[k] = M[k, edge_b - 1] if edge_b > 0 else 0.0
    both, one = edge_a > 0 and edge_b > 0, (edge_a > 0) != (edge_b > 0)
    if both:  # 1
        cx, cy, cz = e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]
        sine = np.sqrt(cx * cx + cy * cy + cz * cz)
        if sine < ALONG:
            return 0.0, np.inf
        side = np.copysign(1.0, cx * x + cy * y + cz * z) / sine
        x, y, z = side * cx, side * cy, side * cz
    gx, gy, gz = e[0] + f[0], e[1] + f[1], e[2] + f[2]
    for _ in range(TURNS):
        if one:
            out = gx * x + gy * y + gz * z
            x, y, z = x - out * gx, y - out * gy, z - out * gz
        share = 1.0 / np.sqrt(x * x + y * y + z * z)
        x, y, z = share * x, share * y, share * z
        _place_features(kind_a, size_a, vertices_a, edge_a, kind_b, size_b, vertices_b, edge_b, M, x, y, z, place)
        if both:
            break
        # Axes across m: the edge, or any; and what is across both.
        ox, oy, oz = (gx, gy, gz) if one else (0.0, z, -y) if abs(x) < 0.6 else (-z, 0.0, x)
        share = 1.0 / np.sqrt(ox * ox + oy * oy + oz * oz)
        ox, oy, oz = share * ox, share * oy, share * oz
        tx, ty, tz = oy * z - oz * y, oz * x - ox * z, ox * y - oy * x
        about_o, about_t = _turns(kind_a, size_a, kind_b, size_b, M, x, y, z, ox, oy, oz, tx, ty, tz, one, place)
        if about_o == np.inf:
            return 0.0, np.inf
        x, y, z = x + about_t * ox + about_o * tx, y + about_t * oy + about_o * ty, z + about_t * oz + about_o * tz
        if about_o * about_o + about_t * about_t < TURNED:
            break
    wx, wy, wz = place[0] - place[3], place[1] - place[4], place[2] - place[5]  # 2
    on_a, on_b = wx * e[0] + wy * e[1] + wz * e[2], wx * f[0] + wy * f[1] + wz * f[2]
    c = e[0] * f[0] + e[1] * f[1] + e[2] * f[2]
    on_a, on_b = (on_a - c * on_b) / (1.0 - c * c), (on_b - c * on_a) / (1.0 - c * c)
    if (edge_a > 0 and abs(on_a) > size_a[edge_a - 1]) or (edge_b > 0 and abs(on_b) > size_b[edge_b - 1]):
        return 0.0, np.inf
    for k in range(3):
        place[k], place[3 + k] = place[k] - on_a * e[k], place[3 + k] + on_b * f[k]
    wx, wy, wz = place[0] - place[3], place[1] - place[4], place[2] - place[5]
    length = np.sqrt(wx * wx + wy * wy + wz * wz)
    if not length > 0.0:
        return 0.0, np.inf
    corner(kind_a, size_a, vertices_a, kind_b, size_b, vertices_b, M, -wx, -wy, -wz, W[12])
    return (wx * W[12, 0] + wy * W[12, 1] + wz * W[12, 2]) / length, length


@inlined
def _place_features(
    kind_a: int, size_a: Floats, vertices_a: Floats, edge_a: int, kind_b: int, size_b: Floats, vertices_b: Floats,
    edge_b: int, M: Floats, x: float, y: float, z: float, place: Floats,
) -> None:  # fmt: skip
    """What of A reaches furthest along a unit direction, and of B against it, in A; of an edge its middle."""
    u, p, q = _in_b(M, x, y, z)
    ax, ay, az = furthest(kind_a, size_a, vertices_a, x, y, z)
    bx, by, bz = furthest(kind_b, size_b, vertices_b, -u, -p, -q)
    place[0], place[1], place[2] = ax * (edge_a != 1), ay * (edge_a != 2), az * (edge_a != 3)
    bx, by, bz = bx * (edge_b != 1), by * (edge_b != 2), bz * (edge_b != 3)
    for k in range(3):
        place[3 + k] = M[k, 0] * bx + M[k, 1] * by + M[k, 2] * bz + M[k, 3]


@inlined
def _turns(
    kind_a: int, size_a: Floats, kind_b: int, size_b: Floats, M: Floats, x: float, y: float, z: float,
    ox: float, oy: float, oz: float, tx: float, ty: float, tz: float, one: bool, place: Floats,
) -> tuple[float, float]:  # fmt: skip
    """A step of Newton's method for a unit direction m: how far it turns about the axes o and t across it.

    Args:
        x, y, z: m.
        ox, oy, oz, tx, ty, tz: o, t.
        one: whether it turns about o alone.
        place: points of A and B whose difference is the gradient of the reach along m.

    Returns:
        About o and about t; infinite where the reach has no minimum nearby.
    """
    u, p, q = _in_b(M, x, y, z)
    bend_a = _bend(kind_a, size_a, x, y, z) / max(x * x + y * y, LEAST_DIVISOR)
    bend_b = _bend(kind_b, size_b, -u, -p, -q) / max(u * u + p * p, LEAST_DIVISOR)
    rx, ry, rz = M[1, 2] * z - M[2, 2] * y, M[2, 2] * x - M[0, 2] * z, M[0, 2] * y - M[1, 2] * x
    wx, wy, wz = place[0] - place[3], place[1] - place[4], place[2] - place[5]
    reach = wx * x + wy * y + wz * z
    at, bt, slope_t = ty * x - tx * y, tx * rx + ty * ry + tz * rz, wx * tx + wy * ty + wz * tz
    ao, bo, slope_o = 0.0, 0.0, 0.0
    if not one:
        ao, bo, slope_o = oy * x - ox * y, ox * rx + oy * ry + oz * rz, wx * ox + wy * oy + wz * oz
    tt, oo = bend_a * at * at + bend_b * bt * bt - reach, bend_a * ao * ao + bend_b * bo * bo - reach
    to = bend_a * at * ao + bend_b * bt * bo
    scale = tt * oo - to * to
    if not scale > 0.0 or not reach < 0.0:
        return np.inf, np.inf
    return (to * slope_o - oo * slope_t) / scale, (to * slope_t - tt * slope_o) / scale


@inlined
def _in_b(M: Floats, x: float, y: float, z: float) -> tuple[float, float, float]:
    """A direction in the frame of B."""
    return (
        M[0, 0] * x + M[1, 0] * y + M[2, 0] * z,
        M[0, 1] * x + M[1, 1] * y + M[2, 1] * z,
        M[0, 2] * x + M[1, 2] * y + M[2, 2] * z,
    )
