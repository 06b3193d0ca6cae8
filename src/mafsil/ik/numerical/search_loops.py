"""The search of numerical inverse kinematics, compiled: lanes of damped least squares, refilled as they end.

Every lane carries one pose from attempt to attempt until it is solved or has used all it may; the result of a pose
does not depend on the others. All lanes step together, by one call of the kernel.
"""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats, JointVector
from mafsil.ik.numerical.records import GROUP, LEFT, Lane, Plan, PoseRecord, Search
from mafsil.ik.numerical.sample_loops import next_sample
from mafsil.kernels.loop_compiler import Whole, address, run_kernel

TRUSTED, PATIENT = 1, 2
"""Bits of the mode: a last step from a small error is taken without a look; attempts are given up only at their end."""

RANKED = 8
"""Attempts of a pose that begin at the samples nearest to it, in this order; later ones begin anywhere."""

SCATTER = 0x9E3779B1
"""Spreads later attempts over the samples."""

RANKED_STEPS, LATER_STEPS, PATIENT_STEPS = 16, 40, 80
"""Most steps of a ranked attempt, of a later one, and towards the nearest configuration. Of the attempts that succeed,
nine of ten need less than ten."""

BOUND_6, BOUND_8, BOUND_12, LATER_BOUND = 0.1, 0.02, 0.001, 0.3
"""Scaled errors above which ranked attempts are given up at steps 6, 8 and 12, and later ones at step 16. Measured on
four arms: one of thirty of those given up would have succeeded."""

CONTINUES, FAILED, SOLVED = 0, 1, 2
"""How a step left an attempt."""


def advance(search: Search) -> int:
    """Work on all poses for so many rounds, each one step of every lane.

    1. Idle lanes take the next poses that may be tried.
    2. The kernel steps all lanes: from the joints in one half of the states to joints and errors in the other.
    3. Each lane is judged: it goes on, begins the next attempt of its pose, or is done. The last lane at work takes the
       place of one that is done.
    4. The halves change their parts.

    Args:
        search: of the poses.

    Returns:
        Number of lanes still at work.
    """
    plan, lanes = search.plan, search.lanes
    width = plan.joints + LEFT
    arguments, strides, rows = np.empty(4, np.int64), np.empty(9, np.int64), np.empty(1, np.int64)
    ports(search.lane_desired, plan.task, 8 * width, 8 * width, arguments, strides)
    for _ in range(search.rounds):
        before = search.lane_states[search.half * width * lanes :]
        after = search.lane_states[(1 - search.half) * width * lanes :]
        # 1.
        take(search, before)
        if search.active == 0:
            break
        # 2.
        rows[0] = search.active if lanes == 1 else (search.active + GROUP - 1) // GROUP * GROUP
        arguments[0], arguments[3] = address(before), address(after)
        run_kernel(search.step, arguments, rows, strides)
        # 3.
        judge(search, before, after)
        # 4.
        search.half = 1 - search.half
    return search.active


def ports(T: Floats, task: Floats, q_stride: int, out_stride: int, arguments: Whole, strides: Whole) -> None:
    """Addresses and strides of a kernel of (q, T_sd, task) to one row of numbers; those of q and of the result follow.

    Args:
        T: (rows, 16) poses.
        task: of the plan, the same for all rows.
        q_stride, out_stride: bytes from row to row.
        arguments: (4) out; places 0 and 3 are left.
        strides: (9) of rows, then of the cores, out.
    """
    arguments[1], arguments[2] = address(T), address(task)
    strides[0], strides[1], strides[2], strides[3] = q_stride, 128, 0, out_stride
    strides[4], strides[5], strides[6], strides[7], strides[8] = 8, 32, 8, 8, 8


def take(search: Search, states: Floats) -> None:
    """Give idle lanes the next poses that may be tried.

    Args:
        search: of the poses.
        states: (lanes, n + LEFT) where attempts begin.
    """
    width = search.plan.joints + LEFT
    while search.active < search.lanes and search.next_pose < search.poses:
        pose = search.next_pose
        search.next_pose = pose + 1
        if search.record[pose].allowed > 0:
            place = search.active
            search.active = place + 1
            search.lane[place].pose = pose
            copy(search.desired[16 * pose :], search.lane_desired[16 * place :], 16)
            begin(search, place, states[width * place :])


def judge(search: Search, before: Floats, after: Floats) -> None:
    """Judge the step just made of every lane, and begin or end attempts.

    1. How the step leaves the attempt.
    2. An attempt that goes on leaves its lane as it is; one that failed gives it to the pose's next attempt, if it has
       one.
    3. Else the lane is done, and the last lane at work takes its place.

    Args:
        search: of the poses.
        before, after: (lanes, n + LEFT) states.
    """
    plan, mode = search.plan, search.mode
    n = plan.joints
    width, place = n + LEFT, 0
    while place < search.active:
        # 1.
        lane = search.lane[place]
        pose = lane.pose
        record, state = search.record[pose], after[width * place :]
        found = judged(plan, mode, lane, record, before[width * place :], state, search.q[(n + 1) * pose :])
        # 2.
        if found == CONTINUES:
            place += 1
        elif found == FAILED and record.begun < record.allowed:
            begin(search, place, state)
            place += 1
        # 3.
        else:
            last = search.active - 1
            search.active = last
            if last > place:
                copy(search.lane_desired[16 * last :], search.lane_desired[16 * place :], 16)
                copy(before[width * last :], before[width * place :], n)
                copy(after[width * last :], state, width)
                move(search.lane[last], lane)


def copy(source: Floats, out: Floats, count: int) -> None:
    """So many numbers from one place to another.

    Args:
        source: where they are.
        out: where they go.
        count: how many.
    """
    for i in range(count):
        out[i] = source[i]


def move(source: Lane, out: Lane) -> None:
    """The pose of one lane to another.

    Args:
        source: whose it is.
        out: which takes it.
    """
    out.pose, out.step, out.nearest, out.second, out.last = (
        source.pose,
        source.step,
        source.nearest,
        source.second,
        source.last,
    )


def begin(search: Search, place: int, q: JointVector) -> None:
    """Begin the next attempt of a lane's pose: at the initial guess, then the nearest samples, then samples anywhere.

    1. At the initial guess, moved into the bounds.
    2. At the next of the samples nearest to the pose.
    3. Where these have run out, at a sample spread by the number of the attempt.

    Args:
        search: of the poses.
        place: of the lane.
        q: (n) where the attempt begins, out.
    """
    plan, lane = search.plan, search.lane[place]
    n, record = plan.joints, search.record[lane.pose]
    rank = record.begun - search.guessed
    record.begun += 1
    lane.step = 0
    # 1.
    if rank < 0:
        q0 = search.q0[n * lane.pose :]
        for i in range(n):
            q[i] = min(max(q0[i], plan.lower[i]), plan.upper[i])
        return
    # 2.
    if rank == 0:
        lane.nearest = -1
    chosen = -1
    if rank < RANKED and (rank == 0 or lane.last >= 0):
        chosen = next_sample(plan, search.lane_desired[16 * place :], lane)
    # 3.
    if chosen < 0:
        chosen = (rank * SCATTER) % plan.samples
    copy(plan.configurations[chosen * n :], q, n)


def judged(plan: Plan, mode: int, lane: Lane, record: PoseRecord, before: Floats, after: Floats, best: Floats) -> int:
    """How the step just made leaves a lane's attempt.

    1. Errors of what counts, in true and in scaled size.
    2. Solved where the joints before the step meet the tolerances, or those after it are trusted to.
    3. Else the nearest configuration is kept, and an attempt that comes down too slowly is given up.

    Args:
        plan: of the search.
        mode: TRUSTED, PATIENT.
        lane: whose step it was.
        record: of its pose.
        before: (n) joints before the step.
        after: (n + LEFT) joints after it, and the errors before it.
        best: (n + 1) solution or nearest configuration, and its scaled error.
    """
    n, step = plan.joints, lane.step
    # 1.
    rotation = position = size = 0.0
    for i in range(6):
        if plan.weights[i] > 0.0:
            e = after[n + i]
            size += (e * plan.weights[i]) ** 2
            if i < 3:
                rotation += e * e
            else:
                position += e * e
    size = np.sqrt(size)
    # 2.
    solved = rotation <= plan.rotation_limit and position <= plan.position_limit
    if solved or (mode & TRUSTED > 0 and size <= plan.trust):
        copy(before if solved else after, best, n)
        best[n] = 0.0
        record.winner = record.begun - 1
        record.steps = step if solved else step + 1
        return SOLVED
    # 3.
    if size < best[n]:
        copy(before, best, n)
        best[n] = size
        record.steps = step
    if not size <= error_bound(step, mode, record.begun <= RANKED):
        return FAILED
    lane.step = step + 1
    return CONTINUES


def error_bound(step: int, mode: int, ranked: bool) -> float:
    """The scaled error above which an attempt is given up; negative where it ends anyway.

    Args:
        step: how many were made before.
        mode: TRUSTED, PATIENT.
        ranked: whether the attempt began at the initial guess or at one of the nearest samples.
    """
    bound = np.inf
    if mode & PATIENT > 0:
        if step >= PATIENT_STEPS:
            bound = -1.0
    elif not ranked:
        if step == 16:
            bound = LATER_BOUND
        elif step >= LATER_STEPS:
            bound = -1.0
    elif step == 6:
        bound = BOUND_6
    elif step == 8:
        bound = BOUND_8
    elif step == 12:
        bound = BOUND_12
    elif step >= RANKED_STEPS:
        bound = -1.0
    return bound
