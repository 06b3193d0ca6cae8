"""A straight motion of the joints proved free or shown to collide, compiled.

A point of a body moves, while the motion runs from t - h to t + h (t in 0..1), by no more than

    M(h) = h sum_j |dq_j| min(R_j, rho_j + h D_j)

over the joints j that move the body: rho_j is how far the ball around the body reaches from axis j at t, D_j the speed
that joints behind j give it, R_j its reach from the axis at any configuration; a sliding joint adds |dq_j| itself. Two
bodies of the arm move against each other by the joints that move one of them alone.

1. The ends, and up to six states between: most collisions show here.
2. Intervals, halved: at the middle of one, every body and pair that is not yet proved there is asked whether anything
   is within M(h) and the margin. If nothing is, it is proved for the whole interval, and its halves need not ask again.
3. A state within the margin ends it; so does a gap that is open by less than TOUCH: what is that near is not called
   free.

No step is longer than its proof, so nothing thin is stepped over. Memory: (bodies + pairs) times LEVELS numbers.

Reference:
    F. Schwarzer, M. Saha, J.-C. Latombe, Adaptive dynamic collision checking for single and multiple articulated robots
    in complex environments, IEEE Trans. Robotics 21(3), 2005.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.collision.arm_loops import Arm, Scratch, collides, gap_around, gap_between, place_bodies, scratch_for
from mafsil.collision.tree_loops import Surroundings
from mafsil.solvers.kernel_loops import call_kernel
from mafsil.solvers.loops import compiled, uncounted

FREE, COLLIDING, TOUCHING = range(3)
TOUCH = 1e-6
"""Gap beyond the margin [m] below which a motion is no longer divided."""
ROUNDING = 1e-12
"""Slack [m] for the rounding of poses and bounds."""
LEVELS = 64
STATES = 8
"""States along a motion that are looked at first, at most."""
FIRST_STEP = 0.3
"""Way of a body [m] from which on one more state is looked at first."""
WIDE = 0.02
"""M(h) [m] from which on it is enough to know that something is within it, not how near."""


class Kinematics(NamedTuple):
    """The kernel of link poses with what it is called with.

    Attributes:
        entry: address of its batch entry.
        arguments, number, strides: addresses of its arguments' addresses, the number of rows, the strides.
        rows: (1,) the number of rows.
        q: (STATES, n) in.
        poses: (STATES, L, 4, 4) out.
    """

    entry: int
    arguments: int
    number: int
    strides: int
    rows: NDArray[np.int64]
    q: Floats
    poses: Floats


class Motion(NamedTuple):
    """How joints move bodies.

    Attributes:
        joints: (j, 8) link, column, factor, 1 if it turns, pitch [m/rad], axis in the frame of the link.
        moves: (j, b) whether it moves a body.
        reach: (j, b) furthest a body gets from the joint's axis [m], sliding joints between at zero.
        stretch: (j, b, n) what that grows by per coordinate of a sliding joint between.
    """

    joints: Floats
    moves: NDArray[np.bool_]
    reach: Floats
    stretch: Floats


class World(NamedTuple):
    """What decides whether a motion is free.

    Attributes:
        arm, around, kinematics, motion: as above.
        margin: clearance to keep [m].
    """

    arm: Arm
    around: Surroundings
    kinematics: Kinematics
    motion: Motion
    margin: float


@uncounted
def bound(
    arm: Arm, motion: Motion, b: int, other: int, rates: Floats, R: Floats, poses: Floats, h: float, s: Scratch
) -> float:  # fmt: skip
    """M(h) of body b by the joints that do not move the other one (-1: by all).

    Args:
        rates: (j,) |dq| of each joint.
        R: (j, b) reaches for this motion.
        poses: of the links at the middle.
    """
    ball, behind, total = s.balls[b], 0.0, 0.0
    for j in range(len(motion.joints) - 1, -1, -1):
        rate = rates[j]
        if rate == 0.0 or not motion.moves[j, b] or (other >= 0 and motion.moves[j, other]):
            continue
        row = motion.joints[j]
        if row[3] == 0.0:
            speed = rate
            furthest = rate
        else:
            T = poses[int(row[0])]
            ux = T[0, 0] * row[5] + T[0, 1] * row[6] + T[0, 2] * row[7]
            uy = T[1, 0] * row[5] + T[1, 1] * row[6] + T[1, 2] * row[7]
            uz = T[2, 0] * row[5] + T[2, 1] * row[6] + T[2, 2] * row[7]
            dx, dy, dz = ball[0] - T[0, 3], ball[1] - T[1, 3], ball[2] - T[2, 3]
            cx, cy, cz = uy * dz - uz * dy, uz * dx - ux * dz, ux * dy - uy * dx
            rho = np.sqrt(cx * cx + cy * cy + cz * cz) + ball[3]
            speed = rate * (min(R[j, b], rho + h * behind) + row[4])
            furthest = rate * (R[j, b] + row[4])
        total += speed
        behind += furthest
    return h * total


@uncounted
def _first_places(r: int) -> float:
    """Where along the motion state r of the first ones is."""
    return 0.0 if r == 0 else 1.0 if r == 1 else (0.5, 0.25, 0.75, 0.125, 0.625, 0.375)[r - 2]


@uncounted
def state_along(kinematics: Kinematics, a: Floats, b: Floats, t: float, row: int) -> None:
    """A row of the kernel's input: the configuration at share t of the motion from a to b."""
    for c in range(len(a)):
        kinematics.q[row, c] = a[c] + t * (b[c] - a[c])


@uncounted
def prove(
    arm: Arm, around: Surroundings, kinematics: Kinematics, motion: Motion, a: Floats, b: Floats, margin: float,
    s: Scratch, rates: Floats, R: Floats, items: NDArray[np.int64], intervals: Floats,
) -> tuple[int, float, int]:  # fmt: skip
    """One motion of `prove_segments`, with arrays to work in.

    Args:
        items: ((bodies + pairs) (LEVELS + 2),) what is left to prove in the intervals that wait.
        intervals: (2 LEVELS, 4) middle, half length, where its items begin, how many.
    """
    bodies, pairs = len(arm.bodies), len(arm.pairs)
    for j in range(len(motion.joints)):
        row = motion.joints[j]
        rates[j] = abs(row[2] * (b[int(row[1])] - a[int(row[1])]))
        for k in range(bodies):
            R[j, k] = motion.reach[j, k]
            for c in range(len(a)):
                R[j, k] += motion.stretch[j, k, c] * max(abs(a[c]), abs(b[c]))
    longest = 0.0
    for k in range(bodies):
        way = 0.0
        for j in range(len(motion.joints)):
            if motion.moves[j, k]:
                way += rates[j] * (R[j, k] + motion.joints[j, 4] if motion.joints[j, 3] != 0.0 else 1.0)
        longest = max(longest, way)
    states = min(STATES, 2 + int(min(longest, 100.0) / FIRST_STEP))
    for r in range(states):  # 1
        state_along(kinematics, a, b, _first_places(r), r)
    kinematics.rows[0] = states
    call_kernel(kinematics.entry, kinematics.arguments, kinematics.number, kinematics.strides)
    for r in range(states):
        if collides(arm, kinematics.poses[r], around, margin, s):
            return COLLIDING, _first_places(r), r + 1
    count = 0
    for k in range(bodies + pairs):
        if k >= bodies or (len(around.pieces.rows) > 0 and arm.bodies[k, 3] > arm.bodies[k, 1]):
            items[count] = k
            count += 1
    intervals[0, 0], intervals[0, 1], intervals[0, 2], intervals[0, 3] = 0.5, 0.5, 0.0, count
    waiting, evaluations = 1 if count else 0, states
    kinematics.rows[0] = 1
    while waiting > 0:  # 2
        waiting -= 1
        t, h = intervals[waiting, 0], intervals[waiting, 1]
        start, count = int(intervals[waiting, 2]), int(intervals[waiting, 3])
        state_along(kinematics, a, b, t, 0)
        call_kernel(kinematics.entry, kinematics.arguments, kinematics.number, kinematics.strides)
        evaluations += 1
        poses = kinematics.poses[0]
        place_bodies(arm, poses, s)
        left, widest = 0, 0.0
        for i in range(start, start + count):
            k = items[i]
            if k < bodies:
                M = bound(arm, motion, k, -1, rates, R, poses, h, s) + ROUNDING
                enough = margin if M < WIDE else np.inf
                gap = gap_around(arm, k, poses, around, margin + M, enough, s)
            else:
                p, q = arm.pairs[k - bodies, 0], arm.pairs[k - bodies, 1]
                M = bound(arm, motion, p, q, rates, R, poses, h, s) + ROUNDING
                M += bound(arm, motion, q, p, rates, R, poses, h, s)
                enough = margin if M < WIDE else np.inf
                gap = gap_between(arm, p, q, poses, margin + M, enough, s)
            if gap >= margin + M:
                continue
            if gap <= margin:  # 3
                return COLLIDING, t, evaluations
            items[start + count + left] = k
            left += 1
            widest = max(widest, M)
        if left == 0:
            continue
        if widest < TOUCH or waiting + 2 > LEVELS:
            return TOUCHING, t, evaluations
        for side in (1.0, -1.0):
            intervals[waiting, 0], intervals[waiting, 1] = t + side * h / 2.0, h / 2.0
            intervals[waiting, 2], intervals[waiting, 3] = start + count, left
            waiting += 1
    return FREE, 1.0, evaluations


@compiled
def prove_segments(
    arm: Arm, around: Surroundings, kinematics: Kinematics, motion: Motion, A: Floats, B: Floats, margin: float,
    code: NDArray[np.int64], t: Floats, evaluations: NDArray[np.int64],
) -> None:  # fmt: skip
    """Whether straight motions of the joints keep more than a margin.

    Args:
        A, B: (m, n) where they begin and end.
        margin: [m].
        code: (m,) out: FREE, COLLIDING or TOUCHING.
        t: (m,) out: where along the motion that shows, 0..1.
        evaluations: (m,) out: states that were looked at.
    """
    s, total = scratch_for(arm), len(arm.bodies) + len(arm.pairs)
    rates, R = np.empty(len(motion.joints)), np.empty(motion.reach.shape)
    items, intervals = np.empty(total * (LEVELS + 2), np.int64), np.empty((2 * LEVELS, 4))
    for r in range(len(A)):
        code[r], t[r], evaluations[r] = prove(
            arm, around, kinematics, motion, A[r], B[r], margin, s, rates, R, items, intervals
        )
