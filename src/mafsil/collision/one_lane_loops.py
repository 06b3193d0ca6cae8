"""Whether a body meets something in one of eight states, compiled: what is within reach, eight of its pieces at once.

Where few of the states bring a body near something, its pieces in all of them are mostly asked in vain. Here the lanes
are pieces: the balls of a body stand in groups of eight in the frame of its link, to be placed together.

1. The balls of a group against the other.
2. What is a ball has its answer, but for cones and hulls; the rest goes to `separation`.

A motion brings its states near the same things, so only states by themselves are asked so.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from mafsil.collision.arm_loops import just_above
from mafsil.collision.pair_loops import separation
from mafsil.collision.piece_loops import BALL, CONE, CYLINDER, DEPTH, HULL, PLANE, POINT, SEGMENT, Pieces, product
from mafsil.collision.placing_loops import LaneScratch, pose_in_lanes
from mafsil.collision.workshop_loops import (
    AROUND,
    BALLS,
    EVERY,
    FROM_ITSELF,
    FROM_SURROUNDINGS,
    Workshop,
    World,
    group_count,
    piece_count,
)
from mafsil.kernels.loops.entry import Held, open_held
from mafsil.kernels.loops.lanes import WIDTH, buffer, get, lane_bits, larger, magnitude, part, seen, square_root
from mafsil.kernels.loops.loop import compiled, inlined

if TYPE_CHECKING:
    from mafsil.kernels.loops.lanes import Buffer, Lanes, Mask


NEAR, MEETS = 1, 3
"""Within clearance + M; within the clearance, which is near too."""


@inlined
def _place_group(world: World, b: int, group: int, lane: int, s: LaneScratch, out: Buffer) -> None:
    """Balls of a group of body b in {s} and their radii, in the state of one lane."""
    T, balls = pose_in_lanes(s, int(world.arm.bodies[b, 0])), part(seen(world.groups.balls), 4 * group)
    x, y, z = balls[0], balls[1], balls[2]
    for r in range(3):
        turned = get(T, 4 * r, lane) * x + get(T, 4 * r + 1, lane) * y + get(T, 4 * r + 2, lane) * z
        out[r] = turned + get(T, 4 * r + 3, lane)
    out[3] = balls[3]


@compiled
def _meets_around(shop: Held[Workshop], b: int, lane: int, count: int) -> bool:
    """Whether body b meets one of the pieces of the surroundings in `s.near`, in one lane."""
    world, bench = open_held(shop)
    arm, around, s, clearance, balls = (
        world.arm,
        world.around.pieces,
        bench.s,
        world.clearance[FROM_SURROUNDINGS],
        buffer(4),
    )
    members = world.groups.members
    link, first = int(arm.bodies[b, 0]), int(arm.bodies[b, 1])
    for g in range(group_count(int(arm.bodies[b, 3]) - first)):
        group = world.groups.first[b] + g
        _place_group(world, b, group, lane, s, balls)
        for k in range(count):
            if (s.near[1, DEPTH + k] >> lane) & 1 == 0:
                continue
            j = s.near[0, DEPTH + k]
            near = lane_bits(within_reach(around, j, balls, balls[3] + clearance)) & members[group, AROUND]  # 1
            if near == 0:
                continue
            if around.rows[j, 0] not in (HULL, CONE) and near & members[group, BALLS]:  # 2
                return True
            for i in range(WIDTH):
                piece = first + g * WIDTH + i
                if (near >> i) & 1 and exact_answer(shop, piece, link, j, -1, FROM_SURROUNDINGS, 0.0, lane) == MEETS:
                    return True
    return False


@inlined
def _near_ball(balls: Buffer, x: float, y: float, z: float, reach: Lanes) -> Mask:
    u, v, w = balls[0] - x, balls[1] - y, balls[2] - z
    return u * u + v * v + w * w <= reach * reach


@compiled
def _meets_itself(shop: Held[Workshop], a: int, b: int, keep: int, lane: int) -> bool:
    """Whether two bodies of the arm meet in one lane; `keep` is the place of their clearance in `World.clearance`."""
    world, bench = open_held(shop)
    arm, s, clearance, ours, theirs = world.arm, bench.s, world.clearance[keep], buffer(4), buffer(4)
    members = world.groups.members
    p, q, round = int(arm.bodies[a, 0]), int(arm.bodies[b, 0]), arm.bodies[b, 7] + clearance
    middle = part(seen(s.balls), 3 * b)
    starts = world.groups.first
    for g in range(starts[a + 1] - starts[a]):
        group = starts[a] + g
        _place_group(world, a, group, lane, s, ours)
        x, y, z = get(middle, 0, lane), get(middle, 1, lane), get(middle, 2, lane)
        open = lane_bits(_near_ball(ours, x, y, z, ours[3] + round)) & members[group, EVERY]
        for d in range(starts[b + 1] - starts[b] if open != 0 else 0):
            beside = starts[b] + d
            _place_group(world, b, beside, lane, s, theirs)
            for i in range(WIDTH):
                if (open >> i) & 1 == 0:
                    continue
                x, y, z, touch = get(ours, 0, i), get(ours, 1, i), get(ours, 2, i), get(ours, 3, i) + clearance
                near = lane_bits(_near_ball(theirs, x, y, z, theirs[3] + touch)) & members[beside, EVERY]  # 1
                if near == 0:
                    continue
                if (members[group, BALLS] >> i) & 1 and near & members[beside, BALLS]:  # 2
                    return True
                piece, first = int(arm.bodies[a, 1]) + g * WIDTH + i, int(arm.bodies[b, 1]) + d * WIDTH
                for k in range(WIDTH):
                    if (near >> k) & 1 and exact_answer(shop, piece, p, first + k, q, keep, 0.0, lane) == MEETS:
                        return True
    return False


@compiled
def around_by_lanes(shop: Held[Workshop], b: int, count: int) -> int:
    """Bits of `meeting_loops.meets_around` at states, in one lane after the other.

    Args:
        count: of the pieces in `s.near` that may be near, with the bits of the lanes.
    """
    found, open, near = 0, 0, open_held(shop).bench.s.near
    for k in range(count):
        open |= near[1, DEPTH + k]
    for lane in range(WIDTH):
        if (open >> lane) & 1 and _meets_around(shop, b, lane, count):
            found |= in_lane(MEETS, lane)
    return found


@compiled
def itself_by_lanes(shop: Held[Workshop], k: int, wanted: int) -> int:
    """Bits of `meeting_loops.meets_itself` at states, in one lane after the other.

    The pieces of the body with more of them stand side by side.
    """
    found, arm = 0, open_held(shop).world.arm
    a, b = arm.pairs[k, 0], arm.pairs[k, 1]
    if piece_count(arm, a) > piece_count(arm, b):
        a, b = b, a
    for lane in range(WIDTH):
        if (wanted >> lane) & 1 and _meets_itself(shop, a, b, FROM_ITSELF + k, lane):
            found |= in_lane(MEETS, lane)
    return found


@inlined
def in_lane(answer: int, lane: int) -> int:
    """NEAR or MEETS as bits of a lane: bit l for near, bit 8 + l for meets."""
    return ((answer & 1) | (answer >> 1) << WIDTH) << lane


@inlined
def beyond(x: Lanes) -> Lanes:
    """What of a number is above zero."""
    return larger(x, 0.0)


@inlined
def within_reach(B: Pieces, j: int, ball: Buffer, reach: Lanes) -> Mask:
    """Where a point is within reach (>= 0) of piece j; of cones and hulls, of the ball around them."""
    row, x, y, z = B.rows[j], ball[0], ball[1], ball[2]
    kind = int(row[0])
    if kind in (HULL, CONE):
        x, y, z, reach = x - row[BALL], y - row[BALL + 1], z - row[BALL + 2], reach + row[BALL + 3]
        return x * x + y * y + z * z <= reach * reach
    T = B.T[j]
    x, y, z = x - T[0, 3], y - T[1, 3], z - T[2, 3]
    if kind == POINT:
        reach = reach + row[4]
        return x * x + y * y + z * z <= reach * reach
    along = x * T[0, 2] + y * T[1, 2] + z * T[2, 2]
    if kind == PLANE:
        return along <= reach
    over = beyond(magnitude(along) - row[3])
    if kind == SEGMENT:
        reach = reach + row[4]
        return (x * x + y * y + z * z) - along * along + over * over <= reach * reach
    if kind == CYLINDER:
        out = beyond(square_root(beyond(x * x + y * y + z * z - along * along)) - row[1])
        return out * out + over * over <= reach * reach
    u = beyond(magnitude(x * T[0, 0] + y * T[1, 0] + z * T[2, 0]) - row[1])
    v = beyond(magnitude(x * T[0, 1] + y * T[1, 1] + z * T[2, 1]) - row[2])
    return u * u + v * v + over * over <= reach * reach


@inlined
def balls_meet(a: Buffer, b: Buffer, reach: Lanes) -> Mask:
    """Where two points are within reach of each other."""
    x, y, z = a[0] - b[0], a[1] - b[1], a[2] - b[2]
    return x * x + y * y + z * z <= reach * reach


@inlined
def _pose_of_lane(s: LaneScratch, link: int, lane: int) -> None:
    T, row = pose_in_lanes(s, link), s.row_of_link[link]
    for r in range(3):
        for c in range(4):
            s.T[row, r, c] = get(T, 4 * r + c, lane)


@compiled
def exact_answer(shop: Held[Workshop], i: int, p: int, j: int, q: int, keep: int, M: float, lane: int) -> int:
    """NEAR, MEETS or 0, by `separation`, of piece i of the arm and piece j of the arm or of the surroundings.

    Args:
        p, q: the links that carry them; q = -1 for the surroundings.
        keep: place of the clearance in `World.clearance`.
        M: beyond the clearance [m], of that lane.
    """
    world, bench = open_held(shop)
    A, s, clearance = world.arm.pieces, bench.s, world.clearance[keep]
    B = A if q >= 0 else world.around.pieces
    P, Q, further = s.one.W[24:27], s.one.W[28:31], just_above(clearance) + M
    _pose_of_lane(s, p, lane)
    product(s.T[s.row_of_link[p]], A.T[i], P)
    if q >= 0:
        _pose_of_lane(s, q, lane)
        product(s.T[s.row_of_link[q]], B.T[j], Q)
    gap = separation(A, i, P, B, j, Q if q >= 0 else B.T[j], further, False, s.one.W, s.one.W[32])
    if gap <= clearance:
        return MEETS
    return NEAR if gap < further else 0


@compiled
def lane_by_lane(shop: Held[Workshop], i: int, p: int, j: int, q: int, keep: int, M: Lanes, bits: int) -> int:
    """Bits of what `exact_answer` says in some lanes."""
    found, per_lane = 0, buffer(1)
    per_lane[0] = M
    for lane in range(WIDTH):
        if (bits >> lane) & 1:
            found |= in_lane(exact_answer(shop, i, p, j, q, keep, get(per_lane, 0, lane), lane), lane)
    return found
