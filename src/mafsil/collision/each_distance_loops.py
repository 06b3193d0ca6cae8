"""The distance of every body of an arm to what is around it, and of every pair that is checked, compiled."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.collision.arm_loops import Arm, gap_around, gap_between, place_bodies, scratch_for
from mafsil.collision.pair_loops import separation
from mafsil.collision.support_loops import product
from mafsil.collision.tree_loops import Surroundings
from mafsil.kernels.loops.loop import compiled

SLACK = 1e-8
"""How much the bounds of a distance may be apart at most [m]."""


@compiled
def each_distance(
    arm: Arm, poses: Floats, around: Surroundings, cutoff: float, out: Floats, who: NDArray[np.int64]
) -> None:  # fmt: skip
    """Separations of bodies from the surroundings, then of pairs of bodies, at m states.

    1. The pieces that are nearest, if they are nearer than the cutoff.
    2. Points and normal between them.

    Args:
        poses: (m, L, 4, 4).
        cutoff: distances beyond it do not matter.
        out: (m, bodies + pairs, ROW) out; distance infinite beyond the cutoff.
        who: (m, bodies + pairs, 2) out: a body and 0, or two bodies of which the second is written as -1 - body.
    """
    s, A, B, bodies = scratch_for(arm), arm.pieces, around.pieces, len(arm.bodies)
    P, Q = s.W[24:27], s.W[28:31]
    for r in range(len(poses)):
        place_bodies(arm, poses[r], s)
        for k in range(bodies + len(arm.pairs)):
            row, a, b = out[r, k], k, -1
            row[:], row[0] = 0.0, np.inf
            if k < bodies:  # 1
                gap = gap_around(arm, a, poses[r], around, cutoff, -np.inf, s)
            else:
                a, b = arm.pairs[k - bodies, 0], arm.pairs[k - bodies, 1]
                gap = gap_between(arm, a, b, poses[r], cutoff, -np.inf, s)
            who[r, k, 0], who[r, k, 1] = a, -1 - b if b >= 0 else 0
            if not gap < cutoff:
                continue
            i, j = s.nearest[0], s.nearest[1]
            product(poses[r, int(arm.bodies[a, 0])], A.T[i], P)  # 2
            if b < 0:
                separation(A, i, P, B, j, B.T[j], gap + SLACK, True, s.W, row)
            else:
                product(poses[r, int(arm.bodies[b, 0])], A.T[j], Q)
                separation(A, i, P, A, j, Q, gap + SLACK, True, s.W, row)
