"""What decides whether a motion of an arm is free, and the arrays that one thread works in, for compiled loops.

They are some 600 numbers and addresses: loops that are called hand on a `Held[Workshop]`, where they lie, and open it;
loops that become part of their callers take the opened ones.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.collision.arm_loops import Arm
from mafsil.collision.clearance_loops import Clearances
from mafsil.collision.piece_loops import Surroundings
from mafsil.collision.placing_loops import ALL, ROUNDING, LaneScratch, Motion, Speeds, lane_scratch_for, speeds_for
from mafsil.kernels.loops.lanes import WIDTH, call_lanes, in_lanes, lanes, put, seen
from mafsil.kernels.loops.loop import compiled, inlined

if TYPE_CHECKING:
    from mafsil.kernels.loops.lanes import Lanes

STATES = 8
"""Rows of the kernel's plain arrays."""
AT_ONCE = 24
"""Pieces of the surroundings up to which looking at each is quicker than a tree."""
LEVELS = 32
"""How often intervals are divided at most: halves of any motion's are shorter than what a proof divides before."""


class Kinematics(NamedTuple):
    """The kernel of link poses with what it is called with.

    Attributes:
        entry: address of its batch entry.
        arguments, number, strides: addresses of its arguments' addresses, the number of rows, the strides.
        rows: (1,) the number of rows.
        q: (STATES, n) in.
        poses: (STATES, L, 4, 4) out.
        at_rest, in_motion: addresses of the entries for rows in lanes of `joints`.
        q_address, rest_address, motion_address: of what they read, and of what each writes.
        q_lanes: (n + j,) lanes in, rates of the joints behind the configuration.
        twists: (6 (j + 1)) lanes out: of {s}, and of what each joint carries.
        pose_lanes: (12 l,) lanes out: three rows of the pose of each link that carries a body.
        balls: (3 (bodies + pieces)) lanes out: centres of bodies; room for those of pieces.
        row_of_link: (L,) which of these poses is that of a link; -1 for none.
    """

    entry: int
    arguments: int
    number: int
    strides: int
    rows: NDArray[np.int64]
    q: Floats
    poses: Floats
    at_rest: int
    in_motion: int
    q_address: int
    rest_address: int
    motion_address: int
    q_lanes: Floats
    twists: Floats
    pose_lanes: Floats
    balls: Floats
    row_of_link: NDArray[np.int64]


FROM_SURROUNDINGS, FROM_ITSELF = range(2)
"""Places in `World.clearance`; pair k of bodies has FROM_ITSELF + k."""
EVERY, AROUND, BALLS = range(3)
"""Columns of `Groups.members`."""


class Groups(NamedTuple):
    """The balls around the pieces of each body, eight side by side; apart from the arm, which is handed on more often.

    Attributes:
        balls: (4 g,) lanes: centres and radii.
        members: (g, 3) bits: what is a piece, what the surroundings matter to, what is a ball itself.
        first: (b + 1,) of each body, and how many there are.
    """

    balls: Floats
    members: NDArray[np.int64]
    first: NDArray[np.int64]


class FewAround(NamedTuple):
    """The pieces of the surroundings as each body sees them; no columns where there are more than AT_ONCE.

    Attributes:
        apart: (bodies, k) how far the body stays from a piece at any configuration.
        walls: (bodies, k, 6) the box around it, along the axes, wider by the radius of the body's ball: lowest and
            highest coordinates of the ball's centre.
    """

    apart: Floats
    walls: Floats


class World(NamedTuple):
    """What decides whether a motion is free.

    Attributes:
        arm, around: what may not meet.
        groups: of the arm's pieces.
        few: pieces of the surroundings as each body sees them, where they are few.
        known: how near bodies of the arm come to each other at some coordinates.
        kinematics, motion: how the joints move it.
        everything: (bodies + pairs) ALL for each that is to be proved, else 0.
        clearance: (1 + pairs,) clearance to keep from the surroundings, and between the bodies of each pair [m]; a
            proof that is to keep more raises all for a while.
    """

    arm: Arm
    around: Surroundings
    groups: Groups
    few: FewAround
    known: Clearances
    kinematics: Kinematics
    motion: Motion
    everything: NDArray[np.int64]
    clearance: Floats


class Bench(NamedTuple):
    """Arrays that proofs work in, for one thread; `bench_for` makes them.

    Attributes:
        s, speeds: for the steps of a block.
        items: what is left to prove in the intervals that wait.
        intervals: (8 LEVELS, 4) middle, half length, where its items begin, how many.
        asked: (bodies + pairs) bits of the lanes in which each item is to be proved.
        order: of the items, those that met something last first.
        t: three lanes: middles and half lengths of the intervals of a block, bounds M of an item.
        cells: (t,) lanes for the tables of `World.known`.
    """

    s: LaneScratch
    speeds: Speeds
    items: NDArray[np.int64]
    intervals: Floats
    asked: NDArray[np.int64]
    order: NDArray[np.int64]
    t: Floats
    cells: Floats


class Workshop(NamedTuple):
    """What one thread asks of one world.

    Attributes:
        world, bench: as above.
    """

    world: World
    bench: Bench


@inlined
def piece_count(arm: Arm, b: int) -> int:
    """How many pieces a body has."""
    return int(arm.bodies[b, 2] - arm.bodies[b, 1])


@inlined
def group_count(pieces: int) -> int:
    """How many groups so many pieces of a body fill."""
    return (pieces + WIDTH - 1) // WIDTH


@compiled
def bench_for(world: World) -> Bench:
    """Arrays for one thread."""
    bodies, total = len(world.arm.bodies), len(world.arm.bodies) + len(world.arm.pairs)
    order = np.arange(total)
    order[:bodies] = order[:bodies][::-1].copy()  # What is far from the base meets more.
    made = world.kinematics
    return Bench(
        lane_scratch_for(world.arm, made.pose_lanes, made.balls, made.row_of_link),
        speeds_for(world.motion, made.twists),
        np.empty(total * WIDTH * LEVELS, np.int64), np.empty((WIDTH * LEVELS, 4)), np.zeros(total, np.int64),
        order, in_lanes(3), in_lanes(len(world.known.axes)),
    )  # fmt: skip


@compiled
def few_around(regions: Floats, arm: Arm, around: Surroundings) -> FewAround:
    """What each body sees of few pieces around; `clearance_tables` (b, 4) are balls that the bodies never leave."""
    bodies, count = len(regions), len(around.boxes)
    if count > AT_ONCE:
        count = 0
    apart, walls = np.empty((bodies, count)), np.empty((bodies, count, 6))
    for b in range(bodies):
        ball, radius = regions[b], arm.bodies[b, 7] + ROUNDING
        for k in range(count):
            box, squared, height = around.boxes[k], 0.0, 0.0
            for c in range(3):
                away = max(abs(ball[c] - box[c]) - box[3 + c], 0.0)
                squared += away * away
                height += (ball[c] - around.pieces.T[k, c, 3]) * around.pieces.T[k, c, 2]
                walls[b, k, c], walls[b, k, 3 + c] = box[c] - (box[3 + c] + radius), box[c] + (box[3 + c] + radius)
            apart[b, k] = (height if k < around.planes else np.sqrt(squared)) - ball[3]
    return FewAround(apart, walls)


@compiled
def whole_agenda(arm: Arm, around: Surroundings) -> NDArray[np.int64]:
    """What a proof asks about: bodies that the surroundings matter to, and pairs; see `World`."""
    bodies, pairs = len(arm.bodies), len(arm.pairs)
    agenda = np.empty(bodies + pairs, np.int64)
    for i in range(bodies + pairs):
        asked = i >= bodies or (arm.bodies[i, 3] > arm.bodies[i, 1] and len(around.boxes) > 0)
        agenda[i] = ALL if asked else 0
    return agenda


@compiled
def state_along(kinematics: Kinematics, a: Floats, b: Floats, t: float, row: int) -> None:
    """A row of the kernel's input: the configuration at share t of the motion from a to b."""
    for c in range(len(a)):
        kinematics.q[row, c] = a[c] + t * (b[c] - a[c])


@inlined
def pose_lanes_of(kinematics: Kinematics, q: Floats, first: int) -> None:
    """Link poses and centres of bodies in lanes of eight configurations (m, n) from a row on.

    Where there are fewer, the last one stands in several lanes.
    """
    lanes_in = seen(kinematics.q_lanes)
    for lane in range(WIDTH):
        row = min(first + lane, len(q) - 1)
        for c in range(q.shape[1]):
            put(lanes_in, c, lane, q[row, c])
    call_lanes(kinematics.at_rest, kinematics.q_address, kinematics.rest_address)


@inlined
def take_rates(world: World, a: Floats, b: Floats, speeds: Speeds) -> None:
    """Rates of the joints in the motion from a to b, also where the kernel reads them."""
    motion, q = world.motion, seen(world.kinematics.q_lanes)
    for j in range(len(motion.joints)):
        column = int(motion.joints[j, 1])
        speeds.rates[j] = motion.joints[j, 2] * (b[column] - a[column])
        q[len(a) + j] = lanes(speeds.rates[j])


@inlined
def pose_lanes_along(kinematics: Kinematics, a: Floats, b: Floats, t: Lanes) -> None:
    """Link poses, centres of bodies and twists in lanes at shares t of the motion from a to b; after `take_rates`."""
    q = seen(kinematics.q_lanes)
    for c in range(len(a)):
        q[c] = a[c] + t * (b[c] - a[c])
    call_lanes(kinematics.in_motion, kinematics.q_address, kinematics.motion_address)
