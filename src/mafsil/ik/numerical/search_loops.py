"""The search of numerical inverse kinematics, compiled: lanes of damped least squares, refilled as they end.

Every lane carries one pose from attempt to attempt until it is solved or has used all it may; the result of a pose
does not depend on the others. All lanes step together, by one call of the kernel.
"""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats, JointVector
from mafsil.ik.numerical.start_loops import (
    CANDIDATES,
    CELLS,
    JOINTS,
    LANE,
    LAST,
    NEAREST,
    POSE,
    SAMPLES,
    SHIFT_LIMIT,
    STEP,
    TASK,
    TRUST,
    TURN_LIMIT,
    next_sample,
)
from mafsil.kernels.loop_compiler import Singles, Whole, address, run_kernel

STARTED, ALLOWED, WINNER, STEPS = 0, 1, 2, 3
"""Columns of the records of poses: attempts begun, attempts allowed, the one that solved it or -1, steps of the one
that solved it or came nearest."""
RECORD = 4

QUEUE, ACTIVE, SIDE = 0, 1, 2
"""Places of the cursor: first pose that nobody has begun, lanes at work, the half of the work that holds the joints."""

TRUSTED, PATIENT = 1, 2
"""Bits of the mode: a last step from a small error is taken without a look; attempts are given up only at their end."""

GROUP = 8
"""Lanes are handed to the kernel by whole vectors of any processor; what lies in lanes at rest is of no account."""

SCATTER = 0x9E3779B1
"""Spreads later attempts over the samples."""

QUICK_STEPS, PATIENT_STEPS, NEAREST_STEPS = 16, 40, 80
"""Most steps of a ranked attempt, of a later one, and towards the nearest miss. Of the attempts that succeed, nine of
ten need less than ten."""

EARLY_BAR, MIDDLE_BAR, LATE_BAR, PATIENT_BAR = 0.1, 0.02, 0.001, 0.3
"""Scaled errors above which ranked attempts are given up at steps 6, 8 and 12, and later ones at step 16. Measured on
four arms: one of thirty of those given up would have succeeded."""

CONTINUES, FAILED, SOLVED = 0, 1, 2
"""How a step left an attempt."""


def advance(
    plan: Floats,
    features: Singles,
    step: int,
    rounds: int,
    mode: int,
    T_sd: Floats,
    seeds: JointVector,
    seeded: int,
    poses: int,
    lanes: int,
    work: Floats,
    places: Whole,
    best: Floats,
    records: Whole,
    cursor: Whole,
) -> int:
    """Work on all poses for so many rounds, each one step of every lane.

    1. Idle lanes take the next poses that may be tried.
    2. The kernel steps all lanes: from the joints in one half of the work to joints and errors in the other.
    3. Each lane is judged: it goes on, begins the next attempt of its pose, or is done. The last lane at work takes the
       place of one that is done.
    4. The halves change their parts.

    Args:
        plan: see `start_loops`.
        features: as for `nearest_cells`.
        step: address of the kernel: (q, T_sd, task) to (q_next, e).
        rounds: most rounds.
        mode: TRUSTED, PATIENT.
        T_sd: (poses, 16) wanted poses.
        seeds: (poses, n) starts of the user.
        seeded: 1 if there are any.
        poses: how many.
        lanes: how many; a multiple of GROUP, or one.
        work: (16 lanes + 2 (n + 6) lanes) wanted poses, then two halves of joints and errors.
        places: (lanes, LANE).
        best: (poses, n + 1) solution or nearest miss of every pose, and its error, zero if solved.
        records: (poses, RECORD).
        cursor: (3).

    Returns:
        Number of lanes still at work.
    """
    n = int(plan[JOINTS])
    width = n + 6
    arguments, strides, rows = np.empty(4, np.int64), np.empty(9, np.int64), np.empty(1, np.int64)
    arguments[1], arguments[2] = address(work), address(plan[TASK:])
    strides[0], strides[1], strides[2], strides[3] = 8 * width, 128, 0, 8 * width
    strides[4], strides[5], strides[6], strides[7], strides[8] = 8, 32, 8, 8, 8
    for _ in range(rounds):
        old = 16 * lanes + cursor[SIDE] * width * lanes
        new = 16 * lanes + (1 - cursor[SIDE]) * width * lanes
        # 1.
        while cursor[ACTIVE] < lanes and cursor[QUEUE] < poses:
            pose = cursor[QUEUE]
            cursor[QUEUE] = pose + 1
            if records[RECORD * pose + ALLOWED] > 0:
                lane = cursor[ACTIVE]
                cursor[ACTIVE] = lane + 1
                places[LANE * lane + POSE] = pose
                for i in range(16):
                    work[16 * lane + i] = T_sd[16 * pose + i]
                begin(
                    plan,
                    features,
                    work[16 * lane :],
                    seeds[n * pose * seeded :],
                    seeded,
                    places[LANE * lane :],
                    records[RECORD * pose :],
                    work[old + width * lane :],
                )
        if cursor[ACTIVE] == 0:
            break
        # 2.
        rows[0] = cursor[ACTIVE] if lanes == 1 else (cursor[ACTIVE] + GROUP - 1) // GROUP * GROUP
        arguments[0], arguments[3] = address(work[old:]), address(work[new:])
        run_kernel(step, arguments, rows, strides)
        # 3.
        lane = 0
        while lane < cursor[ACTIVE]:
            pose = places[LANE * lane + POSE]
            record, joints = records[RECORD * pose :], work[new + width * lane :]
            state = judged(
                plan, mode, places[LANE * lane :], work[old + width * lane :], joints, record, best[(n + 1) * pose :]
            )
            if state == CONTINUES:
                lane += 1
            elif state == FAILED and record[STARTED] < record[ALLOWED]:
                begin(
                    plan,
                    features,
                    work[16 * lane :],
                    seeds[n * pose * seeded :],
                    seeded,
                    places[LANE * lane :],
                    record,
                    joints,
                )
                lane += 1
            else:
                last = cursor[ACTIVE] - 1
                cursor[ACTIVE] = last
                if last > lane:
                    copied(work[16 * last :], work[16 * lane :], 16)
                    copied(work[old + width * last :], work[old + width * lane :], n)
                    copied(work[new + width * last :], joints, width)
                    for i in range(LANE):
                        places[LANE * lane + i] = places[LANE * last + i]
        # 4.
        cursor[SIDE] = 1 - cursor[SIDE]
    return cursor[ACTIVE]


def copied(source: Floats, out: Floats, count: int) -> None:
    """So many numbers from one place to another.

    Args:
        source: where they are.
        out: where they go.
        count: how many.
    """
    for i in range(count):
        out[i] = source[i]


def begin(
    plan: Floats,
    features: Singles,
    T: Floats,
    seed: JointVector,
    seeded: int,
    lane: Whole,
    record: Whole,
    joints: JointVector,
) -> None:
    """Start the next attempt of a lane's pose: the user's start, then the nearest samples, then samples anywhere.

    Args:
        plan, features: as for `nearest_cells`.
        T: (16) wanted pose.
        seed: (n) start of the user.
        seeded: 1 if there is one.
        lane: (LANE).
        record: (RECORD).
        joints: (n) where the attempt begins, out.
    """
    n = int(plan[JOINTS])
    rank = record[STARTED] - seeded
    record[STARTED] += 1
    lane[STEP] = 0
    if rank < 0:
        for i in range(n):
            joints[i] = min(max(seed[i], plan[TASK + 9 + i]), plan[TASK + 9 + n + i])
        return
    if rank == 0:
        lane[NEAREST] = -1
    chosen = -1
    if rank < CANDIDATES and (rank == 0 or lane[LAST] >= 0):
        chosen = next_sample(plan, features, T, lane)
    if chosen < 0:
        chosen = (rank * SCATTER) % int(plan[SAMPLES])
    copied(plan[TASK + 11 + 3 * n + 2 * int(plan[CELLS]) + chosen * n :], joints, n)


def judged(plan: Floats, mode: int, lane: Whole, before: Floats, after: Floats, record: Whole, best: Floats) -> int:
    """How the step just made leaves a lane's attempt.

    1. Errors of what counts, in true and in scaled size.
    2. Solved where the joints before the step meet the tolerances, or those after it are trusted to.
    3. Else the nearest miss is kept, and an attempt that comes down too slowly is given up.

    Args:
        plan: see `start_loops`.
        mode: TRUSTED, PATIENT.
        lane: (LANE).
        before: (n) joints before the step.
        after: (n + 6) joints after it, and the errors before it.
        record: (RECORD).
        best: (n + 1) as for `advance`.
    """
    n, step = int(plan[JOINTS]), lane[STEP]
    # 1.
    turn = shift = size = 0.0
    for i in range(6):
        if plan[TASK + i] > 0.0:
            e = after[n + i]
            size += (e * plan[TASK + i]) ** 2
            if i < 3:
                turn += e * e
            else:
                shift += e * e
    size = np.sqrt(size)
    # 2.
    solved = turn <= plan[TURN_LIMIT] and shift <= plan[SHIFT_LIMIT]
    if solved or (mode & TRUSTED > 0 and size <= plan[TRUST]):
        copied(before if solved else after, best, n)
        best[n] = 0.0
        record[WINNER] = record[STARTED] - 1
        record[STEPS] = step if solved else step + 1
        return SOLVED
    # 3.
    if size < best[n]:
        copied(before, best, n)
        best[n] = size
        record[STEPS] = step
    if not size <= bar(step, mode, record[STARTED] <= CANDIDATES):
        return FAILED
    lane[STEP] = step + 1
    return CONTINUES


def bar(step: int, mode: int, ranked: bool) -> float:
    """The scaled error above which an attempt is given up; negative where it ends anyway.

    Args:
        step: how many were made before.
        mode: TRUSTED, PATIENT.
        ranked: whether the attempt began at the user's start or at one of the nearest samples.
    """
    height = np.inf
    if mode & PATIENT > 0:
        if step >= NEAREST_STEPS:
            height = -1.0
    elif not ranked:
        if step == 16:
            height = PATIENT_BAR
        elif step >= PATIENT_STEPS:
            height = -1.0
    elif step == 6:
        height = EARLY_BAR
    elif step == 8:
        height = MIDDLE_BAR
    elif step == 12:
        height = LATE_BAR
    elif step >= QUICK_STEPS:
        height = -1.0
    return height
