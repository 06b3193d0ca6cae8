"""The balls of an arm in eight states side by side, compiled, and how far its bodies can move in a while.

While the joints go along a straight line from t - h to t + h (t in 0..1, rates dq per unit of t), no point x of a body
is further from where it is at t than

    M = h |x'(t)| + h^2 / 2 A

1. x'(t) follows from the body's twist at t: |x'| <= |v| + |omega| r for a ball of radius r whose centre has speed v.
   Joints whose motions cancel count as little as they move the body.
2. A bounds |x''|: d^2 x / dq_j dq_k = omega_j x (dx / dq_k) for j before k in the chain, so with L_k >= |dx / dq_k|

       A = sum_j |dq_j| (L_j |dq_j| + 2 sum_(k behind j) L_k |dq_k|)   over the joints j that turn.

   The sums are taken from the body down its chain: up to joint c they are those of the motion relative to the link that
   c carries, which is what two bodies that c carries both see of each other.
3. L_k needs no state: the furthest the body gets from axis k at any configuration, or 1 for a sliding joint.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.collision.arm_loops import FEW, Arm, Scratch, scratch_for
from mafsil.collision.piece_loops import BALL, DEPTH
from mafsil.kernels.loops.lanes import WIDTH, in_lanes, lanes, part, seen, square_root, where
from mafsil.kernels.loops.loop import compiled, inlined

if TYPE_CHECKING:
    from mafsil.kernels.loops.lanes import Buffer, Lanes


ALL = (1 << WIDTH) - 1
"""Bits of all lanes."""


class LaneScratch(NamedTuple):
    """Arrays to work in, for one thread.

    Attributes:
        poses: (12 l) lanes: three rows of the pose in {s} of each link that carries a body.
        row_of_link: (L,) which of them is that of a link.
        balls: (3 (bodies + pieces)) lanes: centres of balls of bodies, then of pieces, in {s}.
        placed: (bodies,) whether the balls of its pieces are placed.
        near: (2, DEPTH + FEW or more) nodes that wait; pieces found, and the bits of their lanes.
        walk: (3,) where a walk through the tree goes on.
        one: for what is looked at lane by lane.
        T: (l, 3, 4) poses of one lane.
    """

    poses: Floats
    row_of_link: NDArray[np.int64]
    balls: Floats
    placed: NDArray[np.int64]
    near: NDArray[np.int64]
    walk: NDArray[np.int64]
    one: Scratch
    T: Floats


@compiled
def lane_scratch_for(arm: Arm, poses: Floats, balls: Floats, row_of_link: NDArray[np.int64]) -> LaneScratch:
    """Arrays for one thread; the kernel writes poses and balls of bodies."""
    near = np.zeros((2, DEPTH + max(FEW, len(arm.pieces.rows))), np.int64)
    placed = np.zeros(len(arm.bodies), np.int64)
    walk = np.zeros(3, np.int64)
    T = np.zeros((len(poses) // (12 * WIDTH), 3, 4))
    return LaneScratch(poses, row_of_link, balls, placed, near, walk, scratch_for(arm), T)


@inlined
def pose_in_lanes(s: LaneScratch, link: int) -> Buffer:
    """Three rows of the pose of a link that carries a body."""
    return part(seen(s.poses), 12 * s.row_of_link[link])


@inlined
def without_pieces(s: LaneScratch) -> None:
    """The balls of the bodies are placed; those of the pieces follow when they are needed."""
    for b in range(len(s.placed)):
        s.placed[b] = 0


@inlined
def place_pieces_in_lanes(arm: Arm, b: int, s: LaneScratch) -> None:
    """Balls of the pieces of body b in {s}, unless they are there."""
    if s.placed[b] == 0:
        body, T = arm.bodies[b], pose_in_lanes(s, int(arm.bodies[b, 0]))
        balls = part(seen(s.balls), 3 * len(arm.bodies))
        for i in range(int(body[1]), int(body[2])):
            row, ball = arm.pieces.rows[i], part(balls, 3 * i)
            for r in range(3):
                x, y, z = T[4 * r] * row[BALL], T[4 * r + 1] * row[BALL + 1], T[4 * r + 2] * row[BALL + 2]
                ball[r] = x + y + z + T[4 * r + 3]
        s.placed[b] = 1


ROUNDING = 1e-12
"""Slack [m] for the rounding of poses and bounds."""


class Motion(NamedTuple):
    """How joints move bodies.

    Attributes:
        joints: (j, 11) link, column, factor, 1 if it turns, pitch [m/rad], axis in the frame of the link, direction in
            which it slides; each stands before those that it carries.
        moves: (j, b) whether it moves a body.
        reach: (j, b) furthest a body gets from the joint's axis [m], sliding joints between at zero.
        stretch: (j, b, n) what that grows by per coordinate of a sliding joint between.
        slides: coordinates by which something grows.
        last: (b,) the joint that carries each body; -1 for none.
        common: (pairs,) the last joint that carries both bodies of a pair; -1 for none.
    """

    joints: Floats
    moves: NDArray[np.bool_]
    reach: Floats
    stretch: Floats
    slides: NDArray[np.int64]
    last: NDArray[np.int64]
    common: NDArray[np.int64]


class Speeds(NamedTuple):
    """What one motion makes of it, for B bodies and what fills up the last eight of them.

    Attributes:
        rates: (j,) rate of each joint [rad | m].
        levers: (j, B) L_j of each body that a joint moves; 0 for the others.
        steady: (j + 1, B) sum of L_k |dq_k| over the joints behind joint c that carry a body, in row c + 1: a bound of
            its speed relative to the link of c.
        curved: (j + 1, B) A of that relative motion.
        twists: (6 (j + 1)) lanes: (omega, v about the origin of {s}) of what joint c carries, at c + 1.
    """

    rates: Floats
    levers: Floats
    steady: Floats
    curved: Floats
    twists: Floats


@compiled
def speeds_for(motion: Motion, twists: Floats) -> Speeds:
    """Arrays for one thread; a kernel writes the twists."""
    joints, groups = len(motion.joints), (len(motion.last) + WIDTH - 1) // WIDTH
    B = groups * WIDTH
    rates, levers = np.zeros(joints), in_lanes(joints * groups)[: joints * B].reshape(joints, B)
    steady = in_lanes((joints + 1) * groups)[: (joints + 1) * B].reshape(joints + 1, B)
    curved = in_lanes((joints + 1) * groups)[: (joints + 1) * B].reshape(joints + 1, B)
    resting = np.zeros(motion.stretch.shape[2], np.float64)
    place_levers(motion, resting, resting, levers)
    return Speeds(rates, levers, steady, curved, twists)


@compiled
def place_levers(motion: Motion, first: Floats, second: Floats, levers: Floats) -> None:
    """L_j of each body along a motion between two configurations (step 3)."""
    levers[:] = 0.0
    for j in range(len(motion.joints)):
        for b in range(len(motion.last)):
            if motion.moves[j, b]:
                levers[j, b] = _lever(motion, j, b, first, second)


@inlined
def _lever(motion: Motion, j: int, b: int, first: Floats, second: Floats) -> float:
    if motion.joints[j, 3] == 0.0:
        return 1.0
    reach = motion.reach[j, b] + motion.joints[j, 4]
    for c in motion.slides:
        reach += motion.stretch[j, b, c] * max(abs(first[c]), abs(second[c]))
    return max(reach, ROUNDING)


@inlined
def take_motion(motion: Motion, first: Floats, second: Floats, speeds: Speeds) -> None:
    """Bounds of the motion from the first configuration to the second, whose rates are known (step 2)."""
    if len(motion.slides) > 0:
        place_levers(motion, first, second, speeds.levers)
    levers, steady, curved = seen(speeds.levers), seen(speeds.steady), seen(speeds.curved)
    groups = speeds.steady.shape[1] // WIDTH
    for g in range(groups):
        behind, bent = lanes(0.0), lanes(0.0)
        for j in range(len(motion.joints) - 1, -1, -1):
            steady[(j + 1) * groups + g], curved[(j + 1) * groups + g] = behind, bent
            rate, lever = abs(speeds.rates[j]), levers[j * groups + g]
            way = lever * rate
            if motion.joints[j, 3] != 0.0:
                bent = where(lever > 0.0, bent + (way + behind + behind) * rate, bent)
            behind = behind + way
        steady[g], curved[g] = behind, bent


@inlined
def _speed(moving: Buffer, still: Buffer, ball: Buffer, radius: float) -> Lanes:
    """Largest speed of a point of a ball that moves with one twist, seen by what moves with another."""
    wx, wy, wz = moving[0] - still[0], moving[1] - still[1], moving[2] - still[2]
    vx = moving[3] - still[3] + wy * ball[2] - wz * ball[1]
    vy = moving[4] - still[4] + wz * ball[0] - wx * ball[2]
    vz = moving[5] - still[5] + wx * ball[1] - wy * ball[0]
    return square_root(vx * vx + vy * vy + vz * vz) + radius * square_root(wx * wx + wy * wy + wz * wz)


@inlined
def way_of_ball(motion: Motion, speeds: Speeds, b: int, since: int, h: Lanes, ball: Buffer, radius: float) -> Lanes:
    """M of what of a body lies in a ball, relative to the link that joint `since` carries; -1: to {s}."""
    last = motion.last[b]
    if last == since:
        return h * 0.0
    twists = seen(speeds.twists)
    speed = _speed(part(twists, 6 * (last + 1)), part(twists, 6 * (since + 1)), ball, radius)
    return h * speed + h * h * (0.5 * speeds.curved[since + 1, b])


@inlined
def way_of_body(arm: Arm, motion: Motion, speeds: Speeds, b: int, since: int, h: Lanes, s: LaneScratch) -> Lanes:
    """M of a whole body, relative to the link that joint `since` carries; -1: to {s}."""
    return way_of_ball(motion, speeds, b, since, h, part(seen(s.balls), 3 * b), arm.bodies[b, 7])
