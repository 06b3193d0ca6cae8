"""How far the bodies of an arm can move in a while, compiled, in eight states at once.

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
from mafsil.collision.arm_loops import Arm
from mafsil.collision.placing_loops import LaneScratch
from mafsil.solvers.lane_loops import in_lanes, part, seen, square_root
from mafsil.solvers.loops import compiled, inlined

if TYPE_CHECKING:
    from mafsil.solvers.lane_loops import Buffer, Lanes


ROUNDING = 1e-12
"""Slack [m] for the rounding of poses and bounds."""


class Motion(NamedTuple):
    """How joints move bodies.

    Attributes:
        joints: (j, 11) link, column, factor, 1 if it turns, pitch [m/rad], axis in the frame of the link, direction in
            which it slides.
        moves: (j, b) whether it moves a body.
        reach: (j, b) furthest a body gets from the joint's axis [m], sliding joints between at zero.
        stretch: (j, b, n) what that grows by per coordinate of a sliding joint between.
        slides: coordinates by which something grows.
        before: (j,) the joint that carries each; -1 for none.
        last: (b,) the joint that carries each body; -1 for none.
        common: (pairs,) the last joint that carries both bodies of a pair; -1 for none.
    """

    joints: Floats
    moves: NDArray[np.bool_]
    reach: Floats
    stretch: Floats
    slides: NDArray[np.int64]
    before: NDArray[np.int64]
    last: NDArray[np.int64]
    common: NDArray[np.int64]


class Speeds(NamedTuple):
    """What one motion makes of it.

    Attributes:
        rates: (j,) rate of each joint [rad | m].
        steady: (b, j + 1) sum of L_k |dq_k| over the joints behind joint c that carry a body, at c + 1: a bound of its
            speed relative to the link of c.
        curved: (b, j + 1) A of that relative motion.
        twists: (6 (j + 1)) lanes: (omega, v about the origin of {s}) of what joint c carries, at c + 1.
    """

    rates: Floats
    steady: Floats
    curved: Floats
    twists: Floats


@compiled
def speeds_for(motion: Motion) -> Speeds:
    """Arrays for one thread."""
    j, b = len(motion.joints), len(motion.last)
    twists = in_lanes(6 * (j + 1))
    twists[:] = 0.0
    return Speeds(np.zeros(j), np.zeros((b, j + 1)), np.zeros((b, j + 1)), twists)


@inlined
def reach_of(motion: Motion, j: int, b: int, first: Floats, second: Floats) -> float:
    """L_j of a body along a motion between two configurations (step 3)."""
    if motion.joints[j, 3] == 0.0:
        return 1.0
    reach = motion.reach[j, b] + motion.joints[j, 4]
    for c in motion.slides:
        reach += motion.stretch[j, b, c] * max(abs(first[c]), abs(second[c]))
    return reach


@inlined
def take_motion(motion: Motion, first: Floats, second: Floats, speeds: Speeds) -> None:
    """Rates and bounds of the motion from the first configuration to the second."""
    for j in range(len(motion.joints)):
        column = int(motion.joints[j, 1])
        speeds.rates[j] = motion.joints[j, 2] * (second[column] - first[column])
    for b in range(len(motion.last)):
        j, behind, curved = int(motion.last[b]), 0.0, 0.0
        speeds.steady[b, j + 1], speeds.curved[b, j + 1] = 0.0, 0.0
        while j >= 0:
            rate = abs(speeds.rates[j])
            way = rate * reach_of(motion, j, b, first, second)
            if motion.joints[j, 3] != 0.0:
                curved += rate * (way + 2.0 * behind)
            behind += way
            j = int(motion.before[j])
            speeds.steady[b, j + 1], speeds.curved[b, j + 1] = behind, curved


@inlined
def place_twists(motion: Motion, speeds: Speeds, s: LaneScratch) -> None:
    """Twists of all joints' links, from the base on (step 1)."""
    twists, poses = seen(speeds.twists), seen(s.poses)
    for j in range(len(motion.joints)):
        row, T = motion.joints[j], part(poses, 16 * int(motion.joints[j, 0]))
        base, out, rate = part(twists, 6 * (motion.before[j] + 1)), part(twists, 6 * (j + 1)), speeds.rates[j]
        x, y, z = row[5] * rate, row[6] * rate, row[7] * rate
        wx, wy, wz = T[0] * x + T[1] * y + T[2] * z, T[4] * x + T[5] * y + T[6] * z, T[8] * x + T[9] * y + T[10] * z
        px, py, pz = T[3], T[7], T[11]
        out[0], out[1], out[2] = base[0] + wx, base[1] + wy, base[2] + wz
        vx, vy, vz = py * wz - pz * wy, pz * wx - px * wz, px * wy - py * wx
        if row[3] == 0.0 or row[4] != 0.0:
            x, y, z = row[8] * rate, row[9] * rate, row[10] * rate
            vx = vx + T[0] * x + T[1] * y + T[2] * z
            vy = vy + T[4] * x + T[5] * y + T[6] * z
            vz = vz + T[8] * x + T[9] * y + T[10] * z
        out[3], out[4], out[5] = base[3] + vx, base[4] + vy, base[5] + vz


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
    return h * speed + h * h * (0.5 * speeds.curved[b, since + 1])


@inlined
def way_of_body(arm: Arm, motion: Motion, speeds: Speeds, b: int, since: int, h: Lanes, s: LaneScratch) -> Lanes:
    """M of a whole body, relative to the link that joint `since` carries; -1: to {s}."""
    return way_of_ball(motion, speeds, b, since, h, part(seen(s.balls), 3 * b), arm.bodies[b, 7])
