"""Which of eight states bring an arm near its surroundings or itself, compiled: one question, eight lanes.

The states lie side by side (`kernels.loops.lanes`): one instruction compares a ball of the arm with an obstacle in all
of them. A lane is asked for two things at once: does the body come within clearance + M (M one number a lane: how far
it can move meanwhile), and within the clearance itself.

1. The ball around a body against the surroundings: the few pieces that matter, and in which lanes. Boxes along the axes
   go before exact tests, and pieces that the body never comes near are not asked. Pairs of bodies by their balls, and
   by a table where two coordinates decide (`clearance_loops`).
2. The balls around its pieces against those; exact where the piece is a ball and the other neither cone nor hull.
3. What is left goes lane by lane to `separation`.

Answers are bits: bit l for lane l within clearance + M, bit 8 + l for lane l within the clearance.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from mafsil.arrays import Floats
from mafsil.collision.arm_loops import FEW
from mafsil.collision.clearance_loops import clearance, place_cells
from mafsil.collision.one_lane_loops import (
    around_by_lanes,
    balls_meet,
    beyond,
    itself_by_lanes,
    lane_by_lane,
    within_reach,
)
from mafsil.collision.piece_loops import BALL, CONE, DEPTH, HULL, POINT, Surroundings
from mafsil.collision.placing_loops import (
    ALL,
    ROUNDING,
    LaneScratch,
    place_pieces_in_lanes,
    way_of_ball,
    without_pieces,
)
from mafsil.collision.workshop_loops import (
    AT_ONCE,
    FROM_ITSELF,
    FROM_SURROUNDINGS,
    Bench,
    Workshop,
    World,
    group_count,
    piece_count,
)
from mafsil.kernels.loops.entry import Held
from mafsil.kernels.loops.lanes import (
    WIDTH,
    any_lane,
    how_many,
    lane_bits,
    lanes,
    larger,
    part,
    seen,
)  # fmt: skip
from mafsil.kernels.loops.loop import compiled, inlined

if TYPE_CHECKING:
    from mafsil.collision.arm_loops import Arm
    from mafsil.kernels.loops.lanes import Buffer, Lanes

NEXT, LAST, LEFT = range(3)
"""Places of `walk`: the piece to look at next, the end of its leaf, nodes that wait."""

PLACE, ASK, COMPARE, TURN = 12, 30, 12, 60
"""What it takes, in instructions, to place eight balls, to ask whether they are near a piece or near a ball, and to
begin with a lane of its own."""


@inlined
def _meets_box(node: Floats, ball: Buffer, reach: Lanes) -> bool:
    """Whether a point is within reach of a box of the tree in some lane."""
    square = lanes(0.0)
    for r in range(3):
        low, high = node[r] - ball[r], ball[r] - node[3 + r]
        over = beyond(larger(low, high))
        square = square + over * over
    return any_lane(square <= reach * reach)


@inlined
def _pieces_at_once(world: World, b: int, ball: Buffer, M: Lanes, wanted: int, s: LaneScratch) -> int:
    """Of few pieces of the surroundings those within clearance + M of body b in some lane (step 1); how many.

    Those that the body does not come near at any configuration are not asked.
    """
    around, count, clearance = world.around, 0, world.clearance[FROM_SURROUNDINGS]
    apart, walls = world.few.apart[b], world.few.walls[b]
    slack, reach = M + clearance, M + (world.arm.bodies[b, 7] + clearance)
    x, y, z, X, Y, Z = (
        ball[0] + slack, ball[1] + slack, ball[2] + slack, ball[0] - slack, ball[1] - slack, ball[2] - slack
    )  # fmt: skip
    for j in range(len(around.boxes)):
        if apart[j] > clearance:
            continue
        wall = walls[j]
        meets = (x >= wall[0]) & (X <= wall[3]) & (y >= wall[1]) & (Y <= wall[4]) & (z >= wall[2]) & (Z <= wall[5])
        bits = lane_bits(meets) & wanted
        if bits != 0:
            bits = lane_bits(within_reach(around.pieces, j, ball, reach)) & bits
        if bits != 0:
            s.near[0, DEPTH + count], s.near[1, DEPTH + count] = j, bits
            count += 1
    return count


@inlined
def _begin_walk(around: Surroundings, s: LaneScratch) -> None:
    """The half spaces, then the leaves of the tree."""
    s.walk[NEXT], s.walk[LAST] = 0, around.planes
    s.walk[LEFT] = 0 if len(around.nodes) == 0 else 1
    s.near[0, 0] = 0


@inlined
def _walk_on(around: Surroundings, ball: Buffer, reach: Lanes, wanted: int, s: LaneScratch) -> int:
    """Pieces of the surroundings within reach of a point in some lane (step 1), FEW of them; how many.

    1. The pieces of the leaf at hand; where FEW are found, the walk can go on later.
    2. The next leaf whose box is within reach. Without one the walk has ended: nothing is left of `walk`.
    """
    B, waiting, count = around.pieces, s.near[0], 0
    j, last, left = s.walk[NEXT], s.walk[LAST], s.walk[LEFT]
    while True:
        while j < last:  # 1
            if count == FEW:
                s.walk[NEXT], s.walk[LAST], s.walk[LEFT] = j, last, left
                return count
            bits = lane_bits(within_reach(B, j, ball, reach)) & wanted
            if bits != 0:
                s.near[0, DEPTH + count], s.near[1, DEPTH + count] = j, bits
                count += 1
            j += 1
        while left > 0 and j == last:  # 2
            left -= 1
            node = around.nodes[waiting[left]]
            if not _meets_box(node, ball, reach):
                continue
            child = int(node[6])
            if child >= 0:
                waiting[left], waiting[left + 1] = child + 1, child
                left += 2
            else:
                j = around.planes + int(node[7])
                last = j + int(node[8])
        if j == last:
            s.walk[NEXT], s.walk[LAST], s.walk[LEFT] = 0, 0, 0
            return count


@compiled
def _walk_to_piece(around: Surroundings, ball: Buffer, reach: Lanes, wanted: int, s: LaneScratch) -> int:
    """As `_walk_on`, out of line: where there is much around, the walk is longer than the call."""
    return _walk_on(around, ball, reach, wanted, s)


@inlined
def _few_lanes_near(arm: Arm, b: int, count: int, s: LaneScratch) -> bool:
    """Whether the pieces near body b are asked sooner in one lane after the other."""
    pieces, asked, near = int(arm.bodies[b, 3] - arm.bodies[b, 1]), 0, 0
    for k in range(count):
        asked += how_many(s.near[1, DEPTH + k])
        near |= s.near[1, DEPTH + k]
    groups, place = group_count(pieces), PLACE * (1 - s.placed[b])
    by_lanes = how_many(near) * (TURN + PLACE * groups) + ASK * groups * asked
    return by_lanes < pieces * (place + ASK * count)


@compiled
def meets_around(
    shop: Held[Workshop], world: World, b: int, M: Lanes, wanted: int, h: Lanes, moving: bool, bench: Bench
) -> int:  # fmt: skip
    """Which lanes bring body b within clearance + M of the surroundings, and which within the clearance.

    Args:
        M: [m], >= 0.
        wanted: bits of the lanes that matter.
        h, moving: whether M is a way in an interval of half length h; then a piece that is within it is asked again
            with its own way, for what is near an axis hardly moves.
    """
    arm, around, clearance, s = world.arm, world.around, world.clearance[FROM_SURROUNDINGS], bench.s
    balls, body, found, few = seen(s.balls), arm.bodies[b], 0, len(around.boxes) <= AT_ONCE
    A, B, reach = arm.pieces, around.pieces, M + (body[7] + clearance)
    if few:
        count, crowded = _pieces_at_once(world, b, part(balls, 3 * b), M, wanted, s), False
    else:
        _begin_walk(around, s)
        count = _walk_on(around, part(balls, 3 * b), reach, wanted, s)
        crowded = s.walk[LEFT] > 0 or s.walk[NEXT] < s.walk[LAST]  # Then each piece looks for what is near by itself.
    if count == 0:
        return 0
    if not moving and not crowded and _few_lanes_near(arm, b, count, s):
        return around_by_lanes(shop, b, count)
    place_pieces_in_lanes(arm, b, s)
    for i in range(int(body[1]), int(body[3])):
        ball, radius, point = part(balls, 3 * (len(arm.bodies) + i)), A.rows[i, BALL + 3], A.rows[i, 0] == POINT
        if crowded:
            _begin_walk(around, s)
        more = True
        while more:
            if crowded:
                count = _walk_to_piece(around, ball, M + (radius + clearance), wanted, s)
            more = crowded and (s.walk[LEFT] > 0 or s.walk[NEXT] < s.walk[LAST])
            for k in range(count):
                j, open = s.near[0, DEPTH + k], s.near[1, DEPTH + k] & ~(found >> WIDTH)
                if open == 0:
                    continue
                bits, way = lane_bits(within_reach(B, j, ball, M + (radius + clearance))) & open, M  # 2
                if bits != 0 and moving:
                    way = way_of_ball(world.motion, bench.speeds, b, -1, h, ball, radius) + ROUNDING
                    bits = lane_bits(within_reach(B, j, ball, way + (radius + clearance))) & bits
                if bits == 0:
                    continue
                if point and B.rows[j, 0] != HULL and B.rows[j, 0] != CONE:
                    hits = lane_bits(within_reach(B, j, ball, lanes(radius + clearance))) & bits
                    found |= bits | (hits << WIDTH)
                else:
                    found |= lane_by_lane(shop, i, int(body[0]), j, -1, FROM_SURROUNDINGS, way, bits)  # 3
                if (found >> WIDTH) == wanted:
                    return found
    return found


@inlined
def bodies_near(world: World, k: int, M: Lanes, bench: Bench) -> int:
    """Bits of the lanes in which the bodies of pair k may be within clearance + M: by their balls, and by a table."""
    balls, bodies, known = seen(bench.s.balls), world.arm.bodies, world.known
    a, b, t = world.arm.pairs[k, 0], world.arm.pairs[k, 1], known.table[k]
    wanted = world.clearance[FROM_ITSELF + k]
    reach = M + (bodies[a, 7] + bodies[b, 7] + wanted)
    near = balls_meet(part(balls, 3 * a), part(balls, 3 * b), reach)
    if t >= 0 and any_lane(near):
        near = near & (clearance(known, k, part(seen(bench.cells), t)) <= M + wanted)
    return lane_bits(near)


@inlined
def _pieces_near(world: World, a: int, b: int, clearance: float, M: Lanes, wanted: int, s: LaneScratch) -> int:
    """Pieces of body a within clearance + M of the ball around body b in some lane, by their balls; how many."""
    arm = world.arm
    place_pieces_in_lanes(arm, a, s)
    A, bodies, balls, count = arm.pieces, len(arm.bodies), seen(s.balls), 0
    for i in range(int(arm.bodies[a, 1]), int(arm.bodies[a, 2])):
        reach = M + (A.rows[i, BALL + 3] + arm.bodies[b, 7] + clearance)
        bits = lane_bits(balls_meet(part(balls, 3 * (bodies + i)), part(balls, 3 * b), reach)) & wanted
        if bits != 0:
            s.near[0, DEPTH + count], s.near[1, DEPTH + count] = i, bits
            count += 1
    return count


@inlined
def _few_lanes_meet(arm: Arm, a: int, b: int, wanted: int) -> bool:
    """Whether two bodies are compared sooner in one lane after the other.

    Half of the pieces are near; that all of them are placed serves other pairs too.
    """
    fewer, more = min(piece_count(arm, a), piece_count(arm, b)), max(piece_count(arm, a), piece_count(arm, b))
    ours, theirs = group_count(fewer), group_count(more)
    by_lanes = TURN + (PLACE + COMPARE) * ours + (PLACE * ours + COMPARE * fewer // 2) * theirs
    return how_many(wanted) * by_lanes < COMPARE * (fewer + more + fewer * more // 4)


@compiled
def meets_itself(
    shop: Held[Workshop], world: World, k: int, M: Lanes, wanted: int, h: Lanes, moving: bool, bench: Bench
) -> int:  # fmt: skip
    """Which lanes bring the two bodies of pair k near each other.

    Args:
        wanted: bits of the lanes that matter; those of `bodies_near`.
        M, h, moving, bench: as in `meets_around`.
    """
    arm, clearance, motion, speeds, s = world.arm, world.clearance[FROM_ITSELF + k], world.motion, bench.speeds, bench.s
    A, bodies, balls, found = arm.pieces, len(arm.bodies), seen(s.balls), 0
    a, b, since = arm.pairs[k, 0], arm.pairs[k, 1], motion.common[k]
    if not moving and _few_lanes_meet(arm, a, b, wanted):
        return itself_by_lanes(shop, k, wanted)
    count = _pieces_near(world, b, a, clearance, M, wanted, s)  # 1
    if count == 0:
        return 0
    place_pieces_in_lanes(arm, a, s)
    p, q = int(arm.bodies[a, 0]), int(arm.bodies[b, 0])
    for i in range(int(arm.bodies[a, 1]), int(arm.bodies[a, 2])):
        ball, radius = part(balls, 3 * (bodies + i)), A.rows[i, BALL + 3] + clearance
        open = lane_bits(balls_meet(ball, part(balls, 3 * b), M + (radius + arm.bodies[b, 7]))) & wanted
        if open == 0:
            continue
        for m in range(count):
            j = s.near[0, DEPTH + m]
            other, reach = part(balls, 3 * (bodies + j)), radius + A.rows[j, BALL + 3]
            bits = lane_bits(balls_meet(ball, other, M + reach)) & open & s.near[1, DEPTH + m] & ~(found >> WIDTH)
            way = M
            if bits != 0 and moving:
                way = way_of_ball(motion, speeds, a, since, h, ball, A.rows[i, BALL + 3]) + ROUNDING
                way = way + way_of_ball(motion, speeds, b, since, h, other, A.rows[j, BALL + 3])
                bits = lane_bits(balls_meet(ball, other, way + reach)) & bits
            if bits == 0:
                continue
            if A.rows[i, 0] == POINT and A.rows[j, 0] == POINT:  # 2
                found |= bits | ((lane_bits(balls_meet(ball, other, lanes(reach))) & bits) << WIDTH)
            else:
                found |= lane_by_lane(shop, i, p, j, q, FROM_ITSELF + k, way, bits)  # 3
            if (found >> WIDTH) == wanted:
                return found
    return found


@inlined
def colliding_lanes(shop: Held[Workshop], world: World, wanted: int, bench: Bench) -> int:
    """Bits of the lanes whose state brings the arm within the clearance of its surroundings or of itself.

    Args:
        wanted: bits of the lanes that hold a state of their own; the others count as colliding.
    """
    arm, s = world.arm, bench.s
    without_pieces(s)
    place_cells(world.known, world.kinematics.q_lanes, bench.cells)
    found, none, some = ALL & ~wanted, lanes(0.0), len(world.around.boxes) > 0
    for b in range(len(arm.bodies)):
        if some and arm.bodies[b, 3] > arm.bodies[b, 1]:
            found |= meets_around(shop, world, b, none, ALL & ~found, none, False, bench) >> WIDTH
            if found == ALL:
                return found
    for k in range(len(arm.pairs)):
        near = bodies_near(world, k, none, bench) & ~found
        if near != 0:
            found |= meets_itself(shop, world, k, none, near, none, False, bench) >> WIDTH
            if found == ALL:
                return found
    return found
