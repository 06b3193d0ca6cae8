"""A straight motion of the joints proved free or shown to collide, compiled.

1. Eight intervals of the motion are looked at together, one a lane, at first all of it in equal parts. At the middle of
   each the arm is posed, and bounds M follow of how far bodies can move in the interval (`placing_loops`).
2. Every body and pair of bodies that is not yet proved there is asked whether anything is within the clearance and M
   (`meeting_loops`). If nothing is, it is proved for the whole interval, and its parts need not ask again.
3. A state within the clearance ends it; so does a gap that is open by less than TOUCH: what is that near is not called
   free.
4. Intervals in which something is left are divided, into as many parts as there are lanes for.

No step is longer than its proof, so nothing thin is stepped over. Memory: (bodies + pairs) times 8 LEVELS numbers.

Reference:
    F. Schwarzer, M. Saha, J.-C. Latombe, Adaptive dynamic collision checking for single and multiple articulated robots
    in complex environments, IEEE Trans. Robotics 21(3), 2005: clearances as proofs; the bounds here are others.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.collision.clearance_loops import place_cells
from mafsil.collision.meeting_loops import bodies_near, colliding_lanes, meets_around, meets_itself
from mafsil.collision.placing_loops import ALL, ROUNDING, take_motion, way_of_body, without_pieces
from mafsil.collision.workshop_loops import (
    Bench,
    Workshop,
    World,
    pose_lanes_along,
    pose_lanes_of,
    take_rates,
)
from mafsil.kernels.loops.entry import Held, open_held
from mafsil.kernels.loops.lanes import WIDTH, get, lane_bits, lanes, put, seen, where
from mafsil.kernels.loops.loop import compiled, inlined

if TYPE_CHECKING:
    from mafsil.kernels.loops.lanes import Lanes

FREE, COLLIDING, TOUCHING, OPEN = range(4)
"""Proved free; some state is within the clearance; too near to be called free; neither, where blocks were counted."""
TOUCH = 1e-6
"""Gap beyond the clearance [m] below which a motion is no longer divided."""
HOT = 2
"""Items that are asked first, at the middles alone."""
UNCOUNTED = 1 << 40
"""Blocks that no proof needs."""


@inlined
def _claim(bench: Bench, waiting: int, used: int) -> None:
    """Bits of the lanes that ask for each item: lane l holds interval waiting - 1 - l."""
    lane = 0
    while lane < used:
        first, bits = int(bench.intervals[waiting - 1 - lane, 2]), 0
        count = int(bench.intervals[waiting - 1 - lane, 3])
        while lane < used and bench.intervals[waiting - 1 - lane, 2] == first:
            bits |= 1 << lane
            lane += 1
        for i in range(first, first + count):
            bench.asked[bench.items[i]] |= bits


@inlined
def _ask(shop: Held[Workshop], world: World, k: int, h: Lanes, wanted: int, bench: Bench) -> int:
    """Bits of `meets_around` or `meets_itself` for item k; its bounds go to the third lanes of `bench.t` (step 2)."""
    arm, motion, speeds, s, places = world.arm, world.motion, bench.speeds, bench.s, seen(bench.t)
    bodies = len(arm.bodies)
    if k < bodies:
        way = way_of_body(arm, motion, speeds, k, -1, h, s) + ROUNDING
        places[2] = way
        return meets_around(shop, world, k, way, wanted, h, True, bench)
    p, q, since = arm.pairs[k - bodies, 0], arm.pairs[k - bodies, 1], motion.common[k - bodies]
    steady = speeds.steady[since + 1, p] + speeds.steady[since + 1, q]
    wanted &= bodies_near(world, k - bodies, h * float(steady) + ROUNDING, bench)
    if wanted == 0:
        return 0
    way = way_of_body(arm, motion, speeds, p, since, h, s) + way_of_body(arm, motion, speeds, q, since, h, s) + ROUNDING
    places[2] = way
    wanted &= bodies_near(world, k - bodies, way, bench)
    if wanted == 0:
        return 0
    return meets_itself(shop, world, k - bodies, way, wanted, h, True, bench)


@compiled
def _hot_meets(shop: Held[Workshop]) -> int:
    """Bits of the lanes in which an item that met something lately does so again; most collisions show here."""
    world, bench = open_held(shop)
    bodies, none = len(world.arm.bodies), lanes(0.0)
    for r in range(min(HOT, len(bench.order))):
        k = bench.order[r]
        wanted, found = int(bench.asked[k]), 0
        if wanted == 0:
            continue
        if k < bodies:
            found = meets_around(shop, world, k, none, wanted, none, False, bench)
        else:
            near = bodies_near(world, k - bodies, none, bench) & wanted
            if near != 0:
                found = meets_itself(shop, world, k - bodies, none, near, none, False, bench)
        if found != 0:
            return found >> WIDTH
    return 0


@inlined
def _to_front(order: NDArray[np.int64], r: int) -> None:
    """What stands at place r comes first."""
    k = order[r]
    for i in range(r, 0, -1):
        order[i] = order[i - 1]
    order[0] = k


@inlined
def _divide(bench: Bench, used: int, waiting: int, open: int) -> int:
    """The parts of the intervals in which something is left, with it (step 4); how many wait then, -1 for no room.

    Args:
        used, waiting: how many intervals were looked at, how many wait.
        open: bits of the lanes in which something is left.
    """
    asked, items, intervals, total = bench.asked, bench.items, bench.intervals, len(bench.asked)
    top = int(intervals[waiting - 1, 2] + intervals[waiting - 1, 3]) if waiting > 0 else 0
    lanes_open = 0
    for lane in range(used):
        lanes_open += (open >> lane) & 1
    ways = max(2, WIDTH // lanes_open)
    if waiting + ways * lanes_open > len(intervals) or top + total * lanes_open > len(items):
        return -1
    places = seen(bench.t)
    for lane in range(used - 1, -1, -1):
        if (open >> lane) & 1 == 0:
            continue
        first = top
        for k in range(total):
            if (asked[k] >> lane) & 1:
                items[top] = k
                top += 1
        middle, half = get(places, 0, lane), get(places, 1, lane)
        for part_of in range(ways - 1, -1, -1):
            intervals[waiting, 0] = middle + half * ((2.0 * part_of + 1.0) / ways - 1.0)
            intervals[waiting, 1] = half / ways
            intervals[waiting, 2], intervals[waiting, 3] = first, top - first
            waiting += 1
    return waiting


@inlined
def _take_all(world: World, bench: Bench) -> int:
    """The whole motion as eight intervals, in which everything is to be proved."""
    places = seen(bench.t)
    for lane in range(WIDTH):
        put(places, 0, lane, (lane + 0.5) / WIDTH)
    places[1] = lanes(0.5 / WIDTH)
    for k in range(len(bench.asked)):
        bench.asked[k] = world.everything[k]
    return WIDTH


@inlined
def _take_block(bench: Bench, waiting: int) -> int:
    """The intervals on top, and what is to be proved in them; how many they are (step 1)."""
    intervals, places, used = bench.intervals, seen(bench.t), min(WIDTH, waiting)
    for lane in range(WIDTH):
        row = waiting - 1 - min(lane, used - 1)
        put(places, 0, lane, intervals[row, 0])
        put(places, 1, lane, intervals[row, 1])
    _claim(bench, waiting, used)
    return used


@inlined
def _pose_block(world: World, a: Floats, b: Floats, bench: Bench) -> None:
    """Poses at the middles of the intervals."""
    pose_lanes_along(world.kinematics, a, b, seen(bench.t)[0])
    without_pieces(bench.s)
    place_cells(world.known, world.kinematics.q_lanes, bench.cells)


@inlined
def _ask_all(shop: Held[Workshop], world: World, bench: Bench) -> tuple[int, int, bool]:
    """Each item in the lanes that ask for it (step 2); `asked` becomes what is left.

    Returns:
        Bits of the lanes in which something is left, bits of those in which something meets, and whether what is left
        is too narrow to be divided.
    """
    open, widest, places = 0, lanes(0.0), seen(bench.t)
    for r in range(len(bench.order)):
        k = bench.order[r]
        if bench.asked[k] == 0:
            continue
        found = _ask(shop, world, k, places[1], int(bench.asked[k]), bench)
        bench.asked[k] = found & ALL
        open |= found & ALL
        if found >> WIDTH:
            _to_front(bench.order, r)
            return open, found >> WIDTH, False
        if found != 0:
            widest = where(places[2] > widest, places[2], widest)
    return open, 0, lane_bits(widest < TOUCH) & open != 0


@compiled
def prove(shop: Held[Workshop], a: Floats, b: Floats, blocks: int) -> tuple[int, float, int]:
    """Whether the straight motion from a to b is free: code, where that shows (0..1), states looked at.

    Args:
        blocks: after which it ends with OPEN if it has not ended before.
    """
    world, bench = open_held(shop)
    code, place, waiting, states = FREE, 1.0, WIDTH, 0
    take_rates(world, a, b, bench.speeds)
    while waiting > 0 and code == FREE:
        if states == WIDTH * blocks:
            code, place = OPEN, 0.0
            break
        used = _take_all(world, bench) if states == 0 else _take_block(bench, waiting)  # 1
        waiting -= used
        _pose_block(world, a, b, bench)
        meeting = _hot_meets(shop) if states == 0 else 0
        if states == 0 and meeting == 0:
            take_motion(world.motion, a, b, bench.speeds)
        states += WIDTH
        open, narrow = meeting, False
        if meeting == 0:
            open, meeting, narrow = _ask_all(shop, world, bench)  # 2
        if meeting != 0:  # 3
            code, place = COLLIDING, _first_place(bench.t, meeting)
        elif open != 0:
            waiting = -1 if narrow else _divide(bench, used, waiting, open)  # 4
            if waiting < 0:
                code, place = TOUCHING, _first_place(bench.t, open)
        if open != 0:
            bench.asked[:] = 0
    return code, place, states


@compiled
def colliding_rows(shop: Held[Workshop], q: Floats, count: int, bits: NDArray[np.int64]) -> None:
    """Which of some configurations bring the arm within the clearance of its surroundings or of itself.

    Args:
        q: (m, n).
        count: of the first of them.
        bits: out, of row 8 k + l bit l of number k.
    """
    world, bench = open_held(shop)
    for first in range(0, count, WIDTH):
        pose_lanes_of(world.kinematics, q[:count], first)
        wanted = first_lanes(count - first)
        bits[first // WIDTH] = colliding_lanes(shop, world, wanted, bench) & wanted


@inlined
def first_lanes(count: int) -> int:
    """Bits of so many lanes, of all where there are more."""
    return ALL if count >= WIDTH else (1 << count) - 1


@compiled
def collides_at(shop: Held[Workshop], q: Floats) -> int:
    """Whether one configuration (n,) brings the arm within the clearance, 0 or 1; -1 if a number is none.

    It is for callers who ask for one state after the other: nothing is allocated.
    """
    for c in range(len(q)):
        if not abs(q[c]) < np.inf:
            return -1
    world, bench = open_held(shop)
    pose_lanes_of(world.kinematics, q.reshape(1, len(q)), 0)
    return colliding_lanes(shop, world, 1, bench) & 1


@compiled
def _first_place(t: Floats, bits: int) -> float:
    """The middle of the first interval of some."""
    lane = 0
    while (bits >> lane) & 1 == 0:
        lane += 1
    return t[lane]


@compiled
def prove_segments(
    shop: Held[Workshop], extra: float, A: Floats, B: Floats, code: NDArray[np.int64], t: Floats,
    evaluations: NDArray[np.int64],
) -> None:  # fmt: skip
    """Whether straight motions of the joints keep more than the clearance.

    Args:
        shop: what is free.
        extra: clearance on top of the clearance [m].
        A, B: (m, n) where they begin and end.
        code: (m,) out: FREE, COLLIDING or TOUCHING.
        t: (m,) out: where along the motion that shows, 0..1.
        evaluations: (m,) out: states that were looked at.
    """
    clearance = open_held(shop).world.clearance
    kept = clearance.copy()
    clearance += extra
    _prove_each(shop, A, B, code, t, evaluations)
    clearance[:] = kept


@compiled
def _prove_each(
    shop: Held[Workshop], A: Floats, B: Floats, code: NDArray[np.int64], t: Floats, evaluations: NDArray[np.int64]
) -> None:  # fmt: skip
    for r in range(len(A)):
        code[r], t[r], evaluations[r] = prove(shop, A[r], B[r], UNCOUNTED)


@compiled
def free_at(shop: Held[Workshop], q: Floats) -> bool:
    """Whether one configuration keeps more than the clearance."""
    return prove(shop, q, q, 1)[0] == FREE


@compiled
def collide(shop: Held[Workshop], q: Floats, out: NDArray[np.bool_]) -> None:
    """Whether each of (m, n) configurations brings the arm within the clearance of its surroundings or of itself."""
    bits = np.empty((len(q) + WIDTH - 1) // WIDTH, np.int64)
    colliding_rows(shop, q, len(q), bits)
    for r in range(len(q)):
        out[r] = (bits[r // WIDTH] >> (r % WIDTH)) & 1 != 0
