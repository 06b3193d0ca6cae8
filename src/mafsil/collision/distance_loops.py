"""Distances of an arm, compiled: the nearest pair of each state, every pair that meets, every body; lower bounds first.

Bodies by the balls around them and the boxes around what is near them, pairs by their balls and by their tables.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.collision.arm_loops import Arm, Scratch, gap_around, gap_between, just_above, place_bodies, scratch_for
from mafsil.collision.clearance_loops import clearance, place_cells
from mafsil.collision.pair_loops import ROW, separation
from mafsil.collision.piece_loops import Surroundings, body_of, product
from mafsil.collision.placing_loops import Motion, without_pieces
from mafsil.collision.workshop_loops import (
    AT_ONCE,
    FROM_ITSELF,
    FROM_SURROUNDINGS,
    Bench,
    Workshop,
    World,
    pose_lanes_of,
)
from mafsil.kernels.loops.entry import Held, open_held
from mafsil.kernels.loops.lanes import (
    WIDTH,
    get,
    in_lanes,
    lanes,
    larger,
    magnitude,
    part,
    put,
    seen,
    smaller,
    square_root,
    where,
)
from mafsil.kernels.loops.loop import compiled, inlined

if TYPE_CHECKING:
    from mafsil.kernels.loops.lanes import Buffer, Lanes


SLACK = 1e-8
"""How much the bounds of a distance may be apart at most [m]."""


@compiled
def separation_between(arm: Arm, a: int, b: int, poses: Floats, cutoff: float, s: Scratch, out: Floats) -> bool:
    """Whether two bodies of the arm are nearer than the cutoff; `out` (ROW,) their separation."""
    A, best, found, P, Q = arm.pieces, cutoff, False, s.W[24:27], s.W[28:31]
    T_a, T_b = poses[int(arm.bodies[a, 0])], poses[int(arm.bodies[b, 0])]
    p, q = s.balls[a], s.balls[b]
    if np.sqrt((p[0] - q[0]) ** 2 + (p[1] - q[1]) ** 2 + (p[2] - q[2]) ** 2) - p[3] - q[3] > best:
        return False
    for i in range(int(arm.bodies[a, 1]), int(arm.bodies[a, 2])):
        product(T_a, A.T[i], P)
        u = A.rows[i]
        px = T_a[0, 0] * u[8] + T_a[0, 1] * u[9] + T_a[0, 2] * u[10] + T_a[0, 3]
        py = T_a[1, 0] * u[8] + T_a[1, 1] * u[9] + T_a[1, 2] * u[10] + T_a[1, 3]
        pz = T_a[2, 0] * u[8] + T_a[2, 1] * u[9] + T_a[2, 2] * u[10] + T_a[2, 3]
        for j in range(int(arm.bodies[b, 1]), int(arm.bodies[b, 2])):
            v = A.rows[j]
            dx = px - (T_b[0, 0] * v[8] + T_b[0, 1] * v[9] + T_b[0, 2] * v[10] + T_b[0, 3])
            dy = py - (T_b[1, 0] * v[8] + T_b[1, 1] * v[9] + T_b[1, 2] * v[10] + T_b[1, 3])
            dz = pz - (T_b[2, 0] * v[8] + T_b[2, 1] * v[9] + T_b[2, 2] * v[10] + T_b[2, 3])
            if np.sqrt(dx * dx + dy * dy + dz * dz) - u[11] - v[11] > best:
                continue
            product(T_b, A.T[j], Q)
            if separation(A, i, P, A, j, Q, best, True, s.W, s.W[32]) <= best:
                if not found or s.W[32, 0] < best:
                    best, found = s.W[32, 0], True
                    for c in range(ROW):
                        out[c] = s.W[32, c]
    return found


@compiled
def distances(
    workshop: Held[Workshop], q: Floats, poses: Floats, cutoff: float, out: Floats, who: NDArray[np.int64]
) -> None:  # fmt: skip
    """The smallest distance of each of m states.

    Args:
        workshop: the arm and what is around it.
        q, poses: (m, n), (m, L, 4, 4).
        cutoff: distances beyond it do not matter.
        out: (m, ROW) separation of the nearest pair; distance infinite where there is none.
        who: (m, 2) out: a body and an obstacle, or two bodies of which the second is written as -1 - body.
    """
    world, bench = open_held(workshop)
    lower, found, s = in_lanes(len(world.arm.bodies) + len(world.arm.pairs)), np.zeros(3, np.int64), bench.s.one
    out[:], out[:, 0] = 0.0, np.inf
    for first in range(0, len(q), WIDTH):
        pose_lanes_of(world.kinematics, q, first)
        place_lower_bounds(world, cutoff, bench, lower)
        for lane in range(min(WIDTH, len(q) - first)):
            r = first + lane
            _distance(workshop, poses[r], cutoff, lane, lower, out[r], who[r], found, s)


@inlined
def _next_item(world: World, lower: Floats, lane: int, best: float) -> int:
    """The body or pair that may be nearest in a lane, if it may be nearer than the best; else -1."""
    places, found = seen(lower), -1
    for k in range(len(world.arm.bodies) + len(world.arm.pairs)):
        away = get(places, k, lane)
        if away < best:
            best, found = away, k
    return found


@inlined
def _first_item(world: World, lower: Floats, lane: int, cutoff: float) -> int:
    """As `_next_item`, of the pairs with tables if there are: what they say is nearly the distance, unlike balls."""
    places, found, best, bodies = seen(lower), -1, cutoff, len(world.arm.bodies)
    for k in range(len(world.arm.pairs)):
        away = get(places, bodies + k, lane)
        if world.known.table[k] >= 0 and away < best:
            best, found = away, bodies + k
    return found if found >= 0 else _next_item(world, lower, lane, cutoff)


@compiled
def _look(
    world: World, k: int, poses: Floats, best: float, lane: int, lower: Floats, found: NDArray[np.int64], s: Scratch
) -> float:  # fmt: skip
    """The least distance so far after body or pair k, which is asked once, and only if it may be nearer.

    Args:
        best: the least distance before.
        found: (3,) what has the least distance: the body or pair, and the pieces between which it is.
    """
    arm, bodies, places = world.arm, len(world.arm.bodies), seen(lower)
    if k < 0 or get(places, k, lane) >= best:
        return best
    put(places, k, lane, np.inf)
    if k < bodies:
        gap = gap_around(arm, k, poses, world.around, best, -np.inf, s)
    else:
        gap = gap_between(arm, arm.pairs[k - bodies, 0], arm.pairs[k - bodies, 1], poses, best, -np.inf, s)
    if gap < best:
        found[0], found[1], found[2] = k, s.nearest[0], s.nearest[1]
    return gap


@compiled
def _distance(
    workshop: Held[Workshop], poses: Floats, cutoff: float, lane: int, lower: Floats, out: Floats,
    who: NDArray[np.int64], found: NDArray[np.int64], s: Scratch,
) -> None:  # fmt: skip
    """One state of `distances`.

    1. The body or pair that may be nearest, and the one that may be nearest then: the rest seldom comes nearer.
    2. The others that may.
    3. Points and normal between the nearest pieces alone.
    """
    world = open_held(workshop).world
    arm, around, bodies = world.arm, world.around, len(world.arm.bodies)
    place_bodies(arm, poses, s)
    found[0] = -1
    best = _look(world, _first_item(world, lower, lane, cutoff), poses, cutoff, lane, lower, found, s)  # 1
    best = _look(world, _next_item(world, lower, lane, best), poses, best, lane, lower, found, s)
    for k in range(bodies + len(arm.pairs)):
        best = _look(world, k, poses, best, lane, lower, found, s)  # 2
    k, i, j, P, Q = found[0], found[1], found[2], s.W[24:27], s.W[28:31]  # 3
    if 0 <= k < bodies:
        product(poses[int(arm.bodies[k, 0])], arm.pieces.T[i], P)
        separation(arm.pieces, i, P, around.pieces, j, around.pieces.T[j], best + SLACK, True, s.W, out)
        who[0], who[1] = k, body_of(around.pieces, j)
    elif k >= bodies:
        who[0], who[1] = arm.pairs[k - bodies, 0], -1 - arm.pairs[k - bodies, 1]
        product(poses[int(arm.bodies[who[0], 0])], arm.pieces.T[i], P)
        product(poses[int(arm.bodies[-1 - who[1], 0])], arm.pieces.T[j], Q)
        separation(arm.pieces, i, P, arm.pieces, j, Q, best + SLACK, True, s.W, out)


@compiled
def _add_rates(motion: Motion, poses: Floats, b: int, row: Floats, at: int, sign: float, out: Floats) -> None:
    """How fast a point of body b moves along the normal, per rate of each coordinate, added with a sign.

    Args:
        row: (ROW,) a separation; the point begins at column `at`.
    """
    for j in range(len(motion.joints)):
        if not motion.moves[j, b]:
            continue
        joint, T = motion.joints[j], poses[int(motion.joints[j, 0])]
        rate = 0.0
        for k in range(3):
            m, n = (k + 1) % 3, (k + 2) % 3
            turn_m = T[m, 0] * joint[5] + T[m, 1] * joint[6] + T[m, 2] * joint[7]
            turn_n = T[n, 0] * joint[5] + T[n, 1] * joint[6] + T[n, 2] * joint[7]
            along = T[k, 0] * joint[8] + T[k, 1] * joint[9] + T[k, 2] * joint[10]
            rate += row[7 + k] * (turn_m * (row[at + n] - T[n, 3]) - turn_n * (row[at + m] - T[m, 3]) + along)
        out[int(joint[1])] += sign * joint[2] * rate


@compiled
def gradients(motion: Motion, poses: Floats, rows: Floats, who: NDArray[np.int64], out: Floats) -> None:
    """Rates of distances by the coordinates: those of the first body's point along the normal, less the second's.

    Args:
        poses: (m, L, 4, 4) of the links.
        rows, who: (m, ROW), (m, 2) as `distances` found them.
        out: (m, n) out, zero before.
    """
    for r in range(len(rows)):
        _add_rates(motion, poses[r], who[r, 0], rows[r], 1, 1.0, out[r])
        if who[r, 1] < 0:
            _add_rates(motion, poses[r], -1 - who[r, 1], rows[r], 4, -1.0, out[r])


@compiled
def contacts(
    arm: Arm, poses: Floats, around: Surroundings, clearance: Floats, obstacles: int, out: Floats,
    who: NDArray[np.int64],
) -> int:  # fmt: skip
    """Every pair of one state that is within a clearance, with its deepest place; how many there are.

    1. A body whose gap to everything around it is more than the clearance is done.
    2. Else each of its pieces meets each piece of the surroundings; per obstacle the deepest place stays.
    3. Obstacles within the clearance become rows.
    4. So do pairs of bodies of the arm within it.

    Args:
        poses: (L, 4, 4).
        clearance: (1 + pairs,) as in `World` [m].
        obstacles: how many there are.
        out, who: (k, ROW), (k, 2) as in `distances`; rows beyond the last are not written.
    """
    s, row, count = scratch_for(arm), np.zeros(ROW), 0
    deepest, place = np.full(obstacles, np.inf), np.zeros((obstacles, ROW))
    around_margin = clearance[FROM_SURROUNDINGS]
    over = just_above(around_margin)
    place_bodies(arm, poses, s)
    for b in range(len(arm.bodies)):
        # 1.
        if (
            arm.bodies[b, 3] == arm.bodies[b, 1]
            or gap_around(arm, b, poses, around, over, around_margin, s) > around_margin
        ):
            continue
        # 2.
        deepest[:] = np.inf
        for i in range(int(arm.bodies[b, 1]), int(arm.bodies[b, 3])):
            product(poses[int(arm.bodies[b, 0])], arm.pieces.T[i], s.W[24:27])
            for j in range(len(around.pieces.rows)):
                k = body_of(around.pieces, j)
                most = min(over, deepest[k])
                if (
                    separation(arm.pieces, i, s.W[24:27], around.pieces, j, around.pieces.T[j], most, True, s.W, row)
                    < most
                ):
                    deepest[k] = row[0]
                    place[k] = row
        # 3.
        for k in range(obstacles):
            if deepest[k] < over and count < len(out):
                out[count], who[count, 0], who[count, 1] = place[k], b, k
                count += 1
    # 4.
    for k in range(len(arm.pairs)):
        a, b, self_clearance = arm.pairs[k, 0], arm.pairs[k, 1], clearance[FROM_ITSELF + k]
        over = just_above(self_clearance)
        if count == len(out) or gap_between(arm, a, b, poses, over, self_clearance, s) > self_clearance:
            continue
        if separation_between(arm, a, b, poses, over, s, row):
            out[count], who[count, 0], who[count, 1] = row, a, -1 - b
            count += 1
    return count


@compiled
def each_distance(
    arm: Arm, poses: Floats, around: Surroundings, cutoff: float, out: Floats, who: NDArray[np.int64]
) -> None:  # fmt: skip
    """Separations of bodies from the surroundings, then of pairs of bodies, at m states.

    1. The pieces that are nearest, if they are nearer than the cutoff.
    2. Points and normal between them.

    Args:
        poses: (m, L, 4, 4).
        cutoff: distances beyond it do not matter.
        out: (m, bodies + pairs, ROW) out; distance infinite beyond the cutoff.
        who: (m, bodies + pairs, 2) out: a body and 0, or two bodies of which the second is written as -1 - body.
    """
    s, A, B, bodies = scratch_for(arm), arm.pieces, around.pieces, len(arm.bodies)
    P, Q = s.W[24:27], s.W[28:31]
    for r in range(len(poses)):
        place_bodies(arm, poses[r], s)
        for k in range(bodies + len(arm.pairs)):
            row, a, b = out[r, k], k, -1
            row[:], row[0] = 0.0, np.inf
            if k < bodies:  # 1
                gap = gap_around(arm, a, poses[r], around, cutoff, -np.inf, s)
            else:
                a, b = arm.pairs[k - bodies, 0], arm.pairs[k - bodies, 1]
                gap = gap_between(arm, a, b, poses[r], cutoff, -np.inf, s)
            who[r, k, 0], who[r, k, 1] = a, -1 - b if b >= 0 else 0
            if not gap < cutoff:
                continue
            i, j = s.nearest[0], s.nearest[1]
            product(poses[r, int(arm.bodies[a, 0])], A.T[i], P)  # 2
            if b < 0:
                separation(A, i, P, B, j, B.T[j], gap + SLACK, True, s.W, row)
            else:
                product(poses[r, int(arm.bodies[b, 0])], A.T[j], Q)
                separation(A, i, P, A, j, Q, gap + SLACK, True, s.W, row)


@inlined
def _of_body(world: World, b: int, cutoff: float, ball: Buffer) -> Lanes:
    """How near body b may be to the surroundings at least; infinite where it is beyond the cutoff at any state.

    1. Of few pieces each box: outside of it the distance, inside minus that to its nearest side.
    2. Of many the root of the tree, which does not know half spaces.
    """
    around, radius, square, least = world.around, world.arm.bodies[b, 7], lanes(np.inf), lanes(np.inf)
    few = len(around.boxes) <= AT_ONCE
    for j in range(len(around.boxes) if few else 1):
        if few and world.few.apart[b, j] >= cutoff:
            continue
        if j < around.planes:
            if not few:
                return lanes(-np.inf)
            T = around.pieces.T[j]
            along = (ball[0] - T[0, 3]) * T[0, 2] + (ball[1] - T[1, 3]) * T[1, 2] + (ball[2] - T[2, 3]) * T[2, 2]
            least = smaller(along, least)
            continue
        away, inside = lanes(0.0), lanes(-np.inf)
        for r in range(3):
            if few:
                over = magnitude(ball[r] - around.boxes[j, r]) - around.boxes[j, 3 + r]  # 1
            else:
                over = larger(around.nodes[0, r] - ball[r], ball[r] - around.nodes[0, 3 + r])  # 2
            inside = larger(over, inside)
            over = larger(over, 0.0)
            away = away + over * over
        square = smaller(away, square)
        least = where(inside < 0.0, smaller(inside, least), least)
    return smaller(square_root(square), least) - radius


@inlined
def _of_pair(world: World, k: int, bench: Bench) -> Lanes:
    balls, bodies, known = seen(bench.s.balls), world.arm.bodies, world.known
    a, b, t = world.arm.pairs[k, 0], world.arm.pairs[k, 1], known.table[k]
    p, q, square = part(balls, 3 * a), part(balls, 3 * b), lanes(0.0)
    for r in range(3):
        square = square + (p[r] - q[r]) * (p[r] - q[r])
    away = square_root(square) - (bodies[a, 7] + bodies[b, 7])
    if t < 0:
        return away
    by_table = clearance(known, k, part(seen(bench.cells), t))
    return where(by_table > 0.0, larger(by_table, away), away)  # It knows no depths of bodies that meet.


@inlined
def place_lower_bounds(world: World, cutoff: float, bench: Bench, lower: Floats) -> None:
    """Lower bounds of the distances of bodies to the surroundings, then of pairs.

    Args:
        cutoff: distances beyond it do not matter.
        bench: poses in lanes went before.
        lower: (bodies + pairs) lanes out.
    """
    arm, out = world.arm, seen(lower)
    without_pieces(bench.s)
    place_cells(world.known, world.kinematics.q_lanes, bench.cells)
    for b in range(len(arm.bodies)):
        if len(world.around.boxes) == 0 or arm.bodies[b, 3] == arm.bodies[b, 1]:
            out[b] = np.inf
        else:
            out[b] = _of_body(world, b, cutoff, part(seen(bench.s.balls), 3 * b))
    for k in range(len(arm.pairs)):
        out[len(arm.bodies) + k] = _of_pair(world, k, bench)
