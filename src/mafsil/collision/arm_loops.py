"""How near an arm comes to its surroundings and to itself, compiled: one state, given the poses of its links.

Every question is "is anything within this cutoff, and how near?", so that most pairs end at two balls:

1. The ball around a body against the tree of the surroundings gives the few pieces that can matter (`_gather`).
2. The ball around a piece of the body against such a piece: exact for most kinds (`_gap`); a ball of the arm is done.
3. What is left goes to `separation`.

What is nearest to a single piece (`nearest`) walks the tree, the nearer child first, and leaves a node whose box is
further from the piece's ball than the best so far.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.collision.pair_loops import ROW, WORKSPACE, separation
from mafsil.collision.piece_loops import DEPTH, Pieces, Surroundings, box_gap, product, relative
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.kernels.loops.loop import compiled, inlined

FEW = 64
"""Pieces of the surroundings that are looked at one by one near a body; more are asked for through the tree."""


class Arm(NamedTuple):
    """What collides of an arm.

    Attributes:
        pieces: in the frames of their links, body by body.
        bodies: (b, 8) index of the link that carries a body, first and last + 1 of its pieces, last + 1 of those
            that the surroundings matter to, centre and radius of a ball around it in its link's frame. The others
            stand where they are whatever the joints do.
        pairs: (m, 2) bodies that are checked against each other.
    """

    pieces: Pieces
    bodies: Floats
    pairs: NDArray[np.int64]


class Scratch(NamedTuple):
    """Arrays to work in.

    Attributes:
        W: for `separation`: WORKSPACE; rows 24 to 31 for poses, row 32 for a separation.
        balls: (bodies + pieces, 5) balls of bodies and pieces in {s}; column 4 of a body: are its pieces placed.
        near: (DEPTH + FEW,) nodes of a walk through the tree, pieces found.
        nearest: (2,) the pieces between which the last gap below its cutoff is.
    """

    W: Floats
    balls: Floats
    near: NDArray[np.int64]
    nearest: NDArray[np.int64]


@compiled
def scratch_for(arm: Arm) -> Scratch:
    """Arrays for one thread."""
    rows = len(arm.bodies) + len(arm.pieces.rows)
    return Scratch(np.empty(WORKSPACE), np.zeros((rows, 5)), np.zeros(DEPTH + FEW, np.int64), np.zeros(2, np.int64))


@compiled
def just_above(clearance: float) -> float:
    """The next larger number, above zero one that processors add as quickly as any other."""
    return max(np.nextafter(clearance, np.inf), LEAST_DIVISOR)


@inlined
def _move(T: Floats, x: float, y: float, z: float, radius: float, out: Floats) -> None:
    """A ball under a pose."""
    for k in range(3):
        out[k] = T[k, 0] * x + T[k, 1] * y + T[k, 2] * z + T[k, 3]
    out[3] = radius


@inlined
def place_bodies(arm: Arm, poses: Floats, s: Scratch) -> None:
    """Balls of the bodies in {s}; those of the pieces follow when they are needed."""
    for b in range(len(arm.bodies)):
        body = arm.bodies[b]
        _move(poses[int(body[0])], body[4], body[5], body[6], body[7], s.balls[b])
        s.balls[b, 4] = 0.0


@inlined
def _place_pieces(arm: Arm, b: int, poses: Floats, s: Scratch) -> None:
    body, bodies = arm.bodies[b], len(arm.bodies)
    T = poses[int(body[0])]
    for i in range(int(body[1]), int(body[2])):
        row = arm.pieces.rows[i]
        _move(T, row[8], row[9], row[10], row[11], s.balls[bodies + i])
    s.balls[b, 4] = 1.0


@inlined
def _gap(B: Pieces, j: int, x: float, y: float, z: float) -> float:
    """Lower bound of the signed distance of a point and piece j; exact but for cones and hulls."""
    row = B.rows[j]
    kind = int(row[0])
    if kind == 5 or kind == 4:
        dx, dy, dz = x - row[8], y - row[9], z - row[10]
        return np.sqrt(dx * dx + dy * dy + dz * dz) - row[11]
    T = B.T[j]
    dx, dy, dz = x - T[0, 3], y - T[1, 3], z - T[2, 3]
    if kind == 0:
        return np.sqrt(dx * dx + dy * dy + dz * dz) - row[4]
    w = abs(T[0, 2] * dx + T[1, 2] * dy + T[2, 2] * dz)
    if kind == 6:
        return T[0, 2] * dx + T[1, 2] * dy + T[2, 2] * dz
    if kind == 1:
        across = max(0.0, dx * dx + dy * dy + dz * dz - w * w)
        w = max(0.0, w - row[3])
        return np.sqrt(across + w * w) - row[4]
    w -= row[3]
    if kind == 3:
        square = max(0.0, dx * dx + dy * dy + dz * dz - (w + row[3]) ** 2)
        u = np.sqrt(square) - row[1]
        if u <= 0.0 and w <= 0.0:
            return max(u, w)
        u, w = max(0.0, u), max(0.0, w)
        return np.sqrt(u * u + w * w)
    u = abs(T[0, 0] * dx + T[1, 0] * dy + T[2, 0] * dz) - row[1]
    v = abs(T[0, 1] * dx + T[1, 1] * dy + T[2, 1] * dz) - row[2]
    if u <= 0.0 and v <= 0.0 and w <= 0.0:
        return max(u, v, w)
    u, v, w = max(0.0, u), max(0.0, v), max(0.0, w)
    return np.sqrt(u * u + v * v + w * w)


@inlined
def _gather(around: Surroundings, ball: Floats, cutoff: float, waiting: NDArray[np.int64]) -> int:
    """Pieces of the surroundings that may be within the cutoff of a ball (step 1); how many, -1 if more than FEW.

    Args:
        waiting: (DEPTH + FEW,) nodes to walk; the pieces found, from DEPTH on.
    """
    nodes, count = around.nodes, 0
    x, y, z, reach = ball[0], ball[1], ball[2], ball[3] + cutoff
    for j in range(around.planes):
        if _gap(around.pieces, j, x, y, z) <= reach:
            if count == FEW:
                return -1
            waiting[DEPTH + count] = j
            count += 1
    if len(nodes) == 0:
        return count
    waiting[0], left = 0, 1
    while left > 0:
        left -= 1
        node = nodes[waiting[left]]
        if box_gap(node, x, y, z) > reach:
            continue
        child = int(node[6])
        if child >= 0:
            waiting[left], waiting[left + 1] = child + 1, child
            left += 2
            continue
        first = around.planes + int(node[7])
        for j in range(first, first + int(node[8])):
            if _gap(around.pieces, j, x, y, z) <= reach:
                if count == FEW:
                    return -1
                waiting[DEPTH + count] = j
                count += 1
    return count


@compiled
def gap_around(
    arm: Arm, b: int, poses: Floats, around: Surroundings, cutoff: float, enough: float, s: Scratch
) -> float:  # fmt: skip
    """How near body b comes to the surroundings, if nearer than the cutoff; else the cutoff.

    Args:
        poses: (L, 4, 4) of the links in {s}; `place_bodies` went before.
        cutoff: distances beyond it do not matter.
        enough: the search ends at a distance below the cutoff that is no more than this; where it is not -inf the
            depth of bodies that meet is not looked for.
        s: to work in; what is nearest stands in `s.nearest` if it is nearer than the cutoff.
    """
    count = _gather(around, s.balls[b], cutoff, s.near)
    return cutoff if count == 0 else _gap_to_found(arm, b, poses, around, count, cutoff, enough, s)


@compiled
def _gap_to_found(
    arm: Arm, b: int, poses: Floats, around: Surroundings, count: int, cutoff: float, enough: float, s: Scratch
) -> float:  # fmt: skip
    """As `gap_around`, from the pieces that `_gather` found."""
    A, B, best, deep = arm.pieces, around.pieces, cutoff, enough == -np.inf
    T, P, out, bodies = poses[int(arm.bodies[b, 0])], s.W[24:27], s.W[32], len(arm.bodies)
    if s.balls[b, 4] == 0.0:
        _place_pieces(arm, b, poses, s)
    for i in range(int(arm.bodies[b, 1]), int(arm.bodies[b, 3])):
        if count < 0:
            j = nearest(A, i, T[:3], around, best, s.near, s.W, s.W[24:28], out)
            if j >= 0 and out[0] < best:
                best, s.nearest[0], s.nearest[1] = out[0], i, j
            if best <= enough and best < cutoff:
                return best
            continue
        ball, posed, point = s.balls[bodies + i], False, A.rows[i, 0] == 0.0
        for k in range(count):
            j = s.near[DEPTH + k]
            gap = _gap(B, j, ball[0], ball[1], ball[2]) - ball[3]  # 2
            if gap >= best:
                continue
            if not point or B.rows[j, 0] == 5.0 or B.rows[j, 0] == 4.0:
                if not posed:
                    product(T, A.T[i], P)
                    posed = True
                gap = separation(A, i, P, B, j, B.T[j], best, deep, s.W, out)  # 3
            if gap < best:
                best, s.nearest[0], s.nearest[1] = gap, i, j
            if best <= enough and best < cutoff:
                return best
    return best


@inlined
def _beyond(p: Floats, q: Floats, cutoff: float) -> bool:
    """Whether two balls are further apart than a cutoff."""
    reach = p[3] + q[3] + cutoff
    x, y, z = p[0] - q[0], p[1] - q[1], p[2] - q[2]
    return reach < 0.0 or x * x + y * y + z * z > reach * reach


@compiled
def gap_between(arm: Arm, a: int, b: int, poses: Floats, cutoff: float, enough: float, s: Scratch) -> float:
    """How near two bodies of the arm come to each other, if nearer than the cutoff; arguments as `gap_around`."""
    A, best, bodies, balls, deep = arm.pieces, cutoff, len(arm.bodies), s.balls, enough == -np.inf
    if _beyond(balls[a], balls[b], best):
        return best
    for c in (a, b):
        if balls[c, 4] == 0.0:
            _place_pieces(arm, c, poses, s)
    P, Q = s.W[24:27], s.W[28:31]
    for i in range(int(arm.bodies[a, 1]), int(arm.bodies[a, 2])):
        p, posed = balls[bodies + i], False
        if _beyond(p, balls[b], best):
            continue
        for j in range(int(arm.bodies[b, 1]), int(arm.bodies[b, 2])):
            q = balls[bodies + j]
            if _beyond(p, q, best):
                continue
            if A.rows[i, 0] == 0.0 and A.rows[j, 0] == 0.0:
                square = (p[0] - q[0]) ** 2 + (p[1] - q[1]) ** 2 + (p[2] - q[2]) ** 2
                gap = np.sqrt(square) - p[3] - q[3]
            else:
                if not posed:
                    product(poses[int(arm.bodies[a, 0])], A.T[i], P)
                    posed = True
                product(poses[int(arm.bodies[b, 0])], A.T[j], Q)
                gap = separation(A, i, P, A, j, Q, best, deep, s.W, s.W[32])
            if gap < best:
                best, s.nearest[0], s.nearest[1] = gap, i, j
            if best <= enough and best < cutoff:
                return best
    return best


@compiled
def nearest(
    A: Pieces, i: int, T: Floats, around: Surroundings, cutoff: float,
    waiting: NDArray[np.int64], W: Floats, row: Floats, out: Floats,
) -> int:  # fmt: skip
    """The piece of the surroundings nearest to piece i of A, if nearer than the cutoff; else -1.

    Args:
        T: (3, 4) pose of A's body in the frame of the surroundings.
        cutoff: distances beyond it do not matter.
        waiting: (DEPTH,) nodes to walk.
        W, row: WORKSPACE and (ROW + 2, 4) to work in.
        out: (ROW,) separation from the piece found; as it was if there is none.
    """
    B, nodes = around.pieces, around.nodes
    P, best, found = row[:3], cutoff, -1
    posed = False
    x = T[0, 0] * A.rows[i, 8] + T[0, 1] * A.rows[i, 9] + T[0, 2] * A.rows[i, 10] + T[0, 3]
    y = T[1, 0] * A.rows[i, 8] + T[1, 1] * A.rows[i, 9] + T[1, 2] * A.rows[i, 10] + T[1, 3]
    z = T[2, 0] * A.rows[i, 8] + T[2, 1] * A.rows[i, 9] + T[2, 2] * A.rows[i, 10] + T[2, 3]
    radius = A.rows[i, 11]
    for j in range(around.planes):
        F = B.T[j]
        height = F[0, 2] * (x - F[0, 3]) + F[1, 2] * (y - F[1, 3]) + F[2, 2] * (z - F[2, 3])
        if height - radius > best:
            continue
        if not posed:
            product(T, A.T[i], P)
            posed = True
        if separation(A, i, P, B, j, F, best, True, W, out) <= best:
            best, found = min(best, out[0]), j
    if len(nodes) == 0:
        return found
    waiting[0], count = 0, 1
    while count > 0:
        count -= 1
        node = waiting[count]
        if box_gap(nodes[node], x, y, z) - radius > best:  # 1
            continue
        left = int(nodes[node, 6])
        if left >= 0:
            near, far = left, left + 1
            if box_gap(nodes[far], x, y, z) < box_gap(nodes[near], x, y, z):
                near, far = far, near
            waiting[count], waiting[count + 1] = far, near
            count += 2
            continue
        first = around.planes + int(nodes[node, 7])
        for j in range(first, first + int(nodes[node, 8])):  # 2
            dx, dy, dz = B.rows[j, 8] - x, B.rows[j, 9] - y, B.rows[j, 10] - z
            reach = best + radius + B.rows[j, 11]
            if reach < 0.0 or dx * dx + dy * dy + dz * dz > reach * reach:
                continue
            if not posed:
                product(T, A.T[i], P)
                posed = True
            if separation(A, i, P, B, j, B.T[j], best, True, W, out) <= best:
                best, found = min(best, out[0]), j
    return found


@compiled
def nearest_of_all(A: Pieces, T_a: Floats, around: Surroundings, T_b: Floats, out: Floats) -> None:
    """Separation of all pieces of A from the surroundings, for many poses of both.

    Args:
        T_a, T_b: (m, 4, 4) poses of A's body and of the surroundings.
        out: (m, ROW) the nearest pair's separation, in the frame that the poses are in.
    """
    W, row, waiting = np.empty(WORKSPACE), np.zeros((4, 4)), np.empty(DEPTH, np.int64)
    T, one = np.empty((3, 4)), np.empty(ROW)
    for r in range(len(T_a)):
        relative(T_b[r], T_a[r], T)
        best = np.inf
        for i in range(len(A.rows)):
            if nearest(A, i, T, around, best, waiting, W, row, one) >= 0 and one[0] < best:
                best = one[0]
                out[r, 0] = one[0]
                for k in range(3):
                    for part in range(1, ROW, 3):
                        out[r, part + k] = T_b[r, k, 3] if part < 7 else 0.0
                        for c in range(3):
                            out[r, part + k] += T_b[r, k, c] * one[part + c]
