"""The coordination diagram of two arms on their paths, compiled: cells proved free or full, the quickest way through.

A cell is a piece of one path times a piece of the other. At its middle every pair of bodies of different arms is asked
how near it is; over the whole cell that changes by no more than M (`bound`), which holds wherever each coordinate stays
within its own half range, not on the diagonal alone:

1. further apart than the clearance and M: the pair is proved free for the whole cell; most pairs are by the balls
   around them and the longest ways that they can go in the cell;
2. nearer than the clearance by more than M: the cell is full, the arms meet wherever they are in it; the pair that
   filled the last full cell is asked first;
3. else the cell is cut into four, DEEPEST times, until all are proved or a middle is within the clearance.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.collision.arm_loops import Arm, Scratch, gap_between, just_above, place_bodies, scratch_for
from mafsil.collision.placing_loops import ROUNDING, Motion
from mafsil.collision.workshop_loops import FROM_ITSELF, World
from mafsil.kernels.loops.lanes import call_kernel
from mafsil.kernels.loops.loop import compiled

FREE, NEAR, MEETING, FULL = range(4)
"""Proved free; neither proved; some state within the clearance; every state within it."""
DEEPEST = 4
UNSURE = 1e-3
"""Share of the smaller body by which a depth may be less than what is computed."""
START, BOTH, FIRST, SECOND = range(4)
"""How the quickest way comes to a corner of the grid."""


@compiled
def _state(world: World, A: Floats, i: int, s: float, B: Floats, j: int, t: float) -> None:
    """The kernel's poses at share s of piece i of the first path and share t of piece j of the second."""
    kinematics = world.kinematics
    for c in range(A.shape[1]):
        first, second = A[i, c] + s * (A[i + 1, c] - A[i, c]), B[j, c] + t * (B[j + 1, c] - B[j, c])
        kinematics.q[0, c] = first + second
    kinematics.rows[0] = 1
    call_kernel(kinematics.entry, kinematics.arguments, kinematics.number, kinematics.strides)


@compiled
def bound(
    arm: Arm, motion: Motion, b: int, other: int, rates: Floats, R: Floats, poses: Floats, h: float, s: Scratch
) -> float:  # fmt: skip
    """M of body b by the joints that do not move the other one (-1: by all), each within its own half range.

    M = h sum_j |dq_j| min(R_j, rho_j + h D_j): rho_j is how far the ball around the body reaches from axis j at the
    middle, D_j the speed that joints behind j give it, R_j its reach from the axis at any configuration; a sliding
    joint adds |dq_j| itself.

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


@compiled
def _is_full(world: World, k: int, M: float, s: Scratch) -> bool:
    """Whether a pair is nearer than the clearance by more than M: by its depth, less what that may be too large by."""
    arm, clearance = world.arm, world.clearance[FROM_ITSELF + k]
    p, q = arm.pairs[k, 0], arm.pairs[k, 1]
    gap = gap_between(arm, p, q, world.kinematics.poses[0], just_above(clearance), -np.inf, s)
    return gap + M + UNSURE * min(arm.bodies[p, 7], arm.bodies[q, 7]) <= clearance


@compiled
def classify_cells(world: World, A: Floats, B: Floats, R: Floats, codes: NDArray[np.int8]) -> int:
    """What each cell is; how many states were looked at.

    Args:
        world: whose pairs are those of different arms.
        A, B: (k + 1, n), (m + 1, n) ends of the pieces, zero in the columns of the other arm.
        R: (j, b) reaches of bodies from axes that hold on both paths.
        codes: (k, m) out.
    """
    arm, motion = world.arm, world.motion
    s, rates, states, last = scratch_for(arm), np.empty(len(motion.joints)), 0, -1
    pairs, poses = len(arm.pairs), world.kinematics.poses[0]
    ways = np.empty(len(arm.bodies))
    waiting, depth = np.empty((4 * DEEPEST + 4, 2)), np.empty(4 * DEEPEST + 4, np.int64)
    for i in range(len(A) - 1):
        for j in range(len(B) - 1):
            for r in range(len(rates)):
                column = int(motion.joints[r, 1])
                change = (A[i + 1, column] - A[i, column]) + (B[j + 1, column] - B[j, column])
                rates[r] = abs(motion.joints[r, 2] * change)
            for b in range(len(ways)):
                ways[b] = ROUNDING
                for r in range(len(rates)):
                    if motion.moves[r, b]:
                        ways[b] += rates[r] * (R[r, b] + motion.joints[r, 4] if motion.joints[r, 3] != 0.0 else 1.0)
            waiting[0, 0], waiting[0, 1], depth[0], left = 0.5, 0.5, 0, 1
            code = FREE
            while left > 0 and code < MEETING:
                left -= 1
                x, y, level = waiting[left, 0], waiting[left, 1], depth[left]
                h, open_pairs = 0.5 ** (level + 1), 0
                _state(world, A, i, x, B, j, y)
                states += 1
                place_bodies(arm, poses, s)
                if level == 0 and last >= 0:
                    p, q = arm.pairs[last, 0], arm.pairs[last, 1]
                    M = bound(arm, motion, p, q, rates, R, poses, h, s) + ROUNDING
                    M += bound(arm, motion, q, p, rates, R, poses, h, s)
                    if _is_full(world, last, M, s):  # 2
                        code = FULL
                        continue
                for k in range(pairs):
                    p, q, clearance = arm.pairs[k, 0], arm.pairs[k, 1], world.clearance[FROM_ITSELF + k]
                    away = clearance + h * (ways[p] + ways[q]) + s.balls[p, 3] + s.balls[q, 3]
                    x_pq, y_pq, z_pq = (
                        s.balls[p, 0] - s.balls[q, 0], s.balls[p, 1] - s.balls[q, 1], s.balls[p, 2] - s.balls[q, 2],
                    )  # fmt: skip
                    if x_pq * x_pq + y_pq * y_pq + z_pq * z_pq >= away * away:
                        continue
                    M = bound(arm, motion, p, q, rates, R, poses, h, s) + ROUNDING
                    M += bound(arm, motion, q, p, rates, R, poses, h, s)
                    gap = gap_between(arm, p, q, poses, clearance + M, clearance, s)
                    if gap >= clearance + M:  # 1
                        continue
                    open_pairs += 1
                    if gap > clearance:
                        continue
                    code = MEETING
                    if level == 0 and _is_full(world, k, M, s):  # 2
                        code, last = FULL, k
                        break
                if code >= MEETING or open_pairs == 0:
                    continue
                if level == DEEPEST:
                    code = NEAR
                    continue
                for side in range(4):  # 3
                    waiting[left, 0] = x + (h / 2.0 if side & 1 else -h / 2.0)
                    waiting[left, 1] = y + (h / 2.0 if side & 2 else -h / 2.0)
                    depth[left] = level + 1
                    left += 1
            codes[i, j] = code
    return states


@compiled
def quickest(
    codes: NDArray[np.int8], most: int, first: Floats, second: Floats, cost: Floats, before: NDArray[np.int8]
) -> None:
    """The quickest ways from the first corner of the grid to every other, where neither arm ever goes back.

    Args:
        codes: (k, m) of the cells.
        most: largest code that may be passed: FREE; MEETING leaves only what is proved full.
        first, second: (k,), (m,) times of the pieces at full speed [s].
        cost: (k + 1, m + 1) out: earliest arrival; infinite where no way leads.
        before: (k + 1, m + 1) out: by which move.
    """
    rows, columns = codes.shape
    cost[:] = np.inf
    cost[0, 0], before[0, 0] = 0.0, START
    for i in range(rows + 1):
        for j in range(columns + 1):
            if i > 0 and j > 0 and codes[i - 1, j - 1] <= most:
                arrival = cost[i - 1, j - 1] + max(first[i - 1], second[j - 1])
                if arrival < cost[i, j]:
                    cost[i, j], before[i, j] = arrival, BOTH
            if i > 0 and cost[i - 1, j] + first[i - 1] < cost[i, j]:
                if (j > 0 and codes[i - 1, j - 1] <= most) or (j < columns and codes[i - 1, j] <= most):
                    cost[i, j], before[i, j] = cost[i - 1, j] + first[i - 1], FIRST
            if j > 0 and cost[i, j - 1] + second[j - 1] < cost[i, j]:
                if (i > 0 and codes[i - 1, j - 1] <= most) or (i < rows and codes[i, j - 1] <= most):
                    cost[i, j], before[i, j] = cost[i, j - 1] + second[j - 1], SECOND
