"""The balls of an arm in eight states side by side, compiled: of its bodies at once, of their pieces when asked for."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.collision.arm_loops import FEW, Arm, Scratch, scratch_for
from mafsil.collision.support_loops import BALL
from mafsil.collision.tree_loops import DEPTH
from mafsil.kernels.loops.lanes import WIDTH, part, seen
from mafsil.kernels.loops.loop import compiled, inlined

if TYPE_CHECKING:
    from mafsil.kernels.loops.lanes import Buffer

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
