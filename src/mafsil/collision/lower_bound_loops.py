"""How near each body and pair of an arm may be at least, compiled, in eight states at once.

Bodies by the balls around them and the boxes around what is near them, pairs by their balls and by their tables.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mafsil.arrays import Floats
from mafsil.collision.clearance_loops import clearance, place_cells
from mafsil.collision.placing_loops import without_pieces
from mafsil.collision.workshop_loops import AT_ONCE, Bench, World
from mafsil.kernels.loops.lanes import lanes, larger, magnitude, part, seen, smaller, square_root, where
from mafsil.kernels.loops.loop import inlined

if TYPE_CHECKING:
    from mafsil.kernels.loops.lanes import Buffer, Lanes


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
