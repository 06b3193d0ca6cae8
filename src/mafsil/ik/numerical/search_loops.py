"""The search of numerical inverse kinematics, compiled: lanes of damped least squares, refilled as they end.

Every lane carries one pose from attempt to attempt until it is solved or has used all it may; the result of a pose
does not depend on the others. All lanes step together, by one call of the kernel.
"""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats, JointVector
from mafsil.ik.numerical.records import (
    ACTIVE,
    ALLOWED,
    BEGUN,
    GROUP,
    HALF,
    LAST,
    NEAREST,
    NEXT,
    POSE,
    STEP,
    STEPS,
    WINNER,
    Plan,
    Search,
    Whole,
    next_sample,
)
from mafsil.kernels.loops import compiled
from mafsil.kernels.loops.lanes import address, call_kernel

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


@compiled
def advance(plan: Plan, search: Search, rounds: int, mode: int) -> int:
    """Work on all poses for so many rounds, each one step of every lane.

    1. Idle lanes take the next poses that may be tried.
    2. The kernel steps all lanes: from the joints in one half of the states to joints and errors in the other.
    3. Each lane is judged: it goes on, begins the next attempt of its pose, or is done. The last lane at work takes the
       place of one that is done.
    4. The halves change their parts.

    Args:
        plan: of the search.
        search: of the poses.
        rounds: most steps of all lanes.
        mode: bits TRUSTED, PATIENT.

    Returns:
        Number of lanes still at work.
    """
    lanes, progress = len(search.lanes), search.progress
    row = 8 * search.states.shape[2]
    arguments, strides, rows = np.empty(4, np.int64), np.empty(9, np.int64), np.empty(1, np.int64)
    ports(search.lane_desired, plan.task, row, row, arguments, strides)
    for _ in range(rounds):
        before, after = search.states[progress[HALF]], search.states[1 - progress[HALF]]
        # 1.
        take(plan, search, before)
        active = progress[ACTIVE]
        if active == 0:
            break
        # 2.
        rows[0] = active if lanes == 1 else (active + GROUP - 1) // GROUP * GROUP
        arguments[0], arguments[3] = address(before), address(after)
        call_kernel(search.step, address(arguments), address(rows), address(strides))
        # 3.
        judge(plan, search, mode, before, after)
        # 4.
        progress[HALF] = 1 - progress[HALF]
    return progress[ACTIVE]


@compiled
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


@compiled
def take(plan: Plan, search: Search, states: Floats) -> None:
    """Give idle lanes the next poses that may be tried.

    Args:
        plan: of the search.
        search: of the poses.
        states: (lanes, n + LEFT) where attempts begin.
    """
    progress = search.progress
    while progress[ACTIVE] < len(search.lanes) and progress[NEXT] < len(search.desired):
        pose = progress[NEXT]
        progress[NEXT] = pose + 1
        if search.attempts[pose, ALLOWED] > 0:
            place = progress[ACTIVE]
            progress[ACTIVE] = place + 1
            search.lanes[place, POSE] = pose
            search.lane_desired[place, :] = search.desired[pose]
            begin(plan, search, place, states[place])


@compiled
def judge(plan: Plan, search: Search, mode: int, before: Floats, after: Floats) -> None:
    """Judge the step just made of every lane, and begin or end attempts.

    1. How the step leaves the attempt.
    2. An attempt that goes on leaves its lane as it is; one that failed gives it to the pose's next attempt, if it has
       one.
    3. Else the lane is done, and the last lane at work takes its place.

    Args:
        plan: of the search.
        search: of the poses.
        mode: TRUSTED, PATIENT.
        before, after: (lanes, n + LEFT) states.
    """
    progress, lanes, place = search.progress, search.lanes, 0
    while place < progress[ACTIVE]:
        # 1.
        pose = lanes[place, POSE]
        attempts = search.attempts[pose]
        found = judge_step(plan, mode, lanes[place], attempts, before[place], after[place], search.q[pose])
        # 2.
        if found == CONTINUES:
            place += 1
        elif found == FAILED and attempts[BEGUN] < attempts[ALLOWED]:
            begin(plan, search, place, after[place])
            place += 1
        # 3.
        else:
            last = progress[ACTIVE] - 1
            progress[ACTIVE] = last
            if last > place:
                search.lane_desired[place, :] = search.lane_desired[last]
                before[place, :] = before[last]
                after[place, :] = after[last]
                lanes[place, :] = lanes[last]


@compiled
def begin(plan: Plan, search: Search, place: int, q: JointVector) -> None:
    """Begin the next attempt of a lane's pose: at the initial guess, then the nearest samples, then samples anywhere.

    1. At the initial guess, moved into the bounds.
    2. At the next of the samples nearest to the pose.
    3. Where these have run out, at a sample spread by the number of the attempt.

    Args:
        plan: of the search.
        search: of the poses.
        place: of the lane.
        q: (n) where the attempt begins, out.
    """
    lane = search.lanes[place]
    pose, n = lane[POSE], len(plan.lower)
    guessed = len(search.q0) > 0
    rank = search.attempts[pose, BEGUN] - (1 if guessed else 0)
    search.attempts[pose, BEGUN] += 1
    lane[STEP] = 0
    # 1.
    if rank < 0:
        for i in range(n):
            q[i] = min(max(search.q0[pose, i], plan.lower[i]), plan.upper[i])
        return
    # 2.
    if rank == 0:
        lane[NEAREST] = -1
    chosen = -1
    if rank < RANKED and (rank == 0 or lane[LAST] >= 0):
        chosen = next_sample(plan, search.lane_desired[place], lane)
    # 3.
    if chosen < 0:
        chosen = (rank * SCATTER) % len(plan.configurations)
    for i in range(n):
        q[i] = plan.configurations[chosen, i]


@compiled
def judge_step(plan: Plan, mode: int, lane: Whole, attempts: Whole, before: Floats, after: Floats, best: Floats) -> int:
    """How the step just made leaves a lane's attempt.

    1. Errors of what counts, in true and in scaled size.
    2. Solved where the joints before the step meet the tolerances, or those after it are trusted to.
    3. Else the nearest configuration is kept, and an attempt that comes down too slowly is given up.

    Args:
        plan: of the search.
        mode: TRUSTED, PATIENT.
        lane: whose step it was.
        attempts: of its pose.
        before: (n) joints before the step.
        after: (n + LEFT) joints after it, and the errors before it.
        best: (n + 1) solution or nearest configuration, and its scaled error.
    """
    n, step = len(plan.lower), lane[STEP]
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
        for i in range(n):
            best[i] = before[i] if solved else after[i]
        best[n] = 0.0
        attempts[WINNER] = attempts[BEGUN] - 1
        attempts[STEPS] = step if solved else step + 1
        return SOLVED
    # 3.
    if size < best[n]:
        for i in range(n):
            best[i] = before[i]
        best[n] = size
        attempts[STEPS] = step
    if not size <= error_bound(step, mode, attempts[BEGUN] <= RANKED):
        return FAILED
    lane[STEP] = step + 1
    return CONTINUES


@compiled
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
