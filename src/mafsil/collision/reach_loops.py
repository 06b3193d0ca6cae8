"""Whether points, eight at once, and pieces are within reach of each other, compiled: in states, or of one state."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mafsil.collision.arm_loops import just_above
from mafsil.collision.pair_loops import separation
from mafsil.collision.placing_loops import LaneScratch, pose_in_lanes
from mafsil.collision.support_loops import BALL, CONE, CYLINDER, HULL, PLANE, POINT, SEGMENT, Pieces, product
from mafsil.collision.workshop_loops import Workshop
from mafsil.kernels.loops.entry import Held, open_held
from mafsil.kernels.loops.lanes import WIDTH, buffer, get, larger, magnitude, square_root
from mafsil.kernels.loops.loop import compiled, inlined

if TYPE_CHECKING:
    from mafsil.kernels.loops.lanes import Buffer, Lanes, Mask


NEAR, MEETS = 1, 3
"""Within clearance + M; within the clearance, which is near too."""


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
