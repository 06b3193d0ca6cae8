"""The balls of an arm in eight states side by side, compiled: of its bodies at once, of their pieces when asked for."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.collision.arm_loops import FEW, Arm, Scratch, scratch_for
from mafsil.collision.support_loops import BALL
from mafsil.collision.tree_loops import DEPTH
from mafsil.solvers.lane_loops import WIDTH, in_lanes, part, seen
from mafsil.solvers.loops import compiled, inlined

if TYPE_CHECKING:
    from mafsil.solvers.lane_loops import Buffer

ALL = (1 << WIDTH) - 1
"""Bits of all lanes."""


class LaneScratch(NamedTuple):
    """Arrays to work in, for one thread.

    Attributes:
        poses: (16 L) lanes: of the links in {s}, element by element.
        balls: (3 (bodies + pieces)) lanes: centres of balls of bodies, then of pieces, in {s}.
        placed: (bodies,) whether the balls of its pieces are placed.
        near: (2, DEPTH + FEW or more) nodes that wait; pieces found, and the bits of their lanes.
        walk: (3,) where a walk through the tree goes on.
        one: for what is looked at lane by lane.
        T: (L, 4, 4) poses of one lane.
    """

    poses: Floats
    balls: Floats
    placed: NDArray[np.int64]
    near: NDArray[np.int64]
    walk: NDArray[np.int64]
    one: Scratch
    T: Floats


@compiled
def lane_scratch_for(arm: Arm, poses: Floats) -> LaneScratch:
    """Arrays for one thread; `poses` is what the kernel writes to."""
    rows = len(arm.bodies) + len(arm.pieces.rows)
    links = len(poses) // (16 * WIDTH)
    near = np.zeros((2, DEPTH + max(FEW, len(arm.pieces.rows))), np.int64)
    placed = np.zeros(len(arm.bodies), np.int64)
    walk = np.zeros(3, np.int64)
    return LaneScratch(poses, in_lanes(3 * rows), placed, near, walk, scratch_for(arm), np.zeros((links, 4, 4)))


@inlined
def _place(poses: Buffer, link: int, x: float, y: float, z: float, out: Buffer) -> None:
    """A point of a link in {s}, in every lane."""
    T = part(poses, 16 * link)
    for r in range(3):
        out[r] = T[4 * r] * x + T[4 * r + 1] * y + T[4 * r + 2] * z + T[4 * r + 3]


@inlined
def place_bodies_in_lanes(arm: Arm, s: LaneScratch) -> None:
    """Balls of the bodies in {s}; those of the pieces follow when they are needed."""
    poses, balls = seen(s.poses), seen(s.balls)
    for b in range(len(arm.bodies)):
        body = arm.bodies[b]
        _place(poses, int(body[0]), body[4], body[5], body[6], part(balls, 3 * b))
        s.placed[b] = 0


@inlined
def place_pieces_in_lanes(arm: Arm, b: int, s: LaneScratch) -> None:
    """Balls of the pieces of body b in {s}, unless they are there."""
    if s.placed[b] == 0:
        body, poses = arm.bodies[b], seen(s.poses)
        balls = part(seen(s.balls), 3 * len(arm.bodies))
        for i in range(int(body[1]), int(body[2])):
            row = arm.pieces.rows[i]
            _place(poses, int(body[0]), row[BALL], row[BALL + 1], row[BALL + 2], part(balls, 3 * i))
        s.placed[b] = 1
