"""The search of numerical inverse kinematics, compiled: lanes of damped least squares, refilled as they end.

Every lane carries one pose from attempt to attempt until it is solved or has used all it may; the result of a pose
does not depend on the others. All lanes step together, by one call of the kernel.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector
from mafsil.solvers.kernel_loops import call_kernel
from mafsil.solvers.loops import compiled

Whole = NDArray[np.int64]
Singles = NDArray[np.float32]

RANKED = 8
"""Attempts of a pose that begin at the samples nearest to it, in this order; later ones begin anywhere."""

STARTED, ALLOWED, WINNER, STEPS, CANDIDATES = 0, 1, 2, 3, 4
"""Columns of the records of poses: attempts begun, attempts allowed, the one that solved it or -1, steps of the one
that solved it or came nearest, and the samples of the ranked attempts."""
RECORD = CANDIDATES + RANKED

POSE, STEP = 0, 1
"""Columns of the records of lanes."""

QUEUE, ACTIVE = 0, 1
"""Places of the cursor: first pose that nobody has begun, lanes at work."""

TURN_LIMIT, SHIFT_LIMIT, TURNING, SHIFTING, ONE_AXIS, TRUST, LARGEST, PATIENT = 0, 1, 2, 3, 4, 5, 6, 7
"""Places of the numbers: squares of the tolerances, factors of the features, whether the task turns one axis only,
the scaled error from which the last step is trusted, the size of the largest cell, and whether attempts are given up
only at their end."""

SCATTER = 0x9E3779B1
"""Spreads later attempts over the samples."""

QUICK_STEPS, PATIENT_STEPS, NEAREST_STEPS = 16, 40, 80
"""Most steps of a ranked attempt, of a later one, and towards the nearest miss. Of the attempts that succeed, nine of
ten need less than ten."""

EARLY_BAR, MIDDLE_BAR, LATE_BAR, PATIENT_BAR = 0.1, 0.02, 0.001, 0.3
"""Scaled errors above which ranked attempts are given up at steps 6, 8 and 12, and later ones at step 16. Measured on
four arms: one of thirty of those given up would have succeeded."""

FARTHEST = 1e100
"""As `ik.problem.FARTHEST`; written here since the seal of compiled loops covers the numbers of these files only."""

NEWTON = 1e-7
"""Scaled error from which one more step is trusted to end within rounding, for arms up to a metre; the check of every
answer judges."""


@compiled
def advance(
    entry: int,
    rounds: int,
    numbers: Floats,
    task: Floats,
    T_sd: Floats,
    first: JointVector,
    samples: JointVector,
    features: Singles,
    centres: Singles,
    begins: Whole,
    real: Floats,
    whole: Whole,
    best: Floats,
    records: Whole,
    cursor: Whole,
) -> int:
    """Work on all poses for so many rounds, each one step of every lane.

    Args:
        entry: address of the step kernel: (q, T_sd, task) to (q_next, e).
        rounds: most rounds.
        numbers: see TURN_LIMIT to LARGEST.
        task: weights (6), axis (3), lower bounds (n), upper bounds (n).
        T_sd: (k, 16) wanted poses.
        first: (k, n) starts of the user, or (0, n).
        samples: (m, n) configurations for starts, sorted by cell.
        features: (12 m) of their poses, (12, size) of every cell.
        centres: (12 c) features of the cells' centres, (12, c).
        begins: (c + 1) first sample of every cell.
        real: (lanes, 2 n + 6) work: q, then the kernel's q_next and e.
        whole: (lanes, 2) work.
        best: (k, n + 1) solution or nearest miss of every pose, and its error, zero if solved.
        records: (k, RECORD).
        cursor: (2).

    Returns:
        Number of lanes still at work.
    """
    n = samples.shape[1]
    targets = np.empty((whole.shape[0], 16))
    addresses = np.empty(4, np.uintp)
    addresses[0] = real.ctypes.data
    addresses[1] = targets.ctypes.data
    addresses[2] = task.ctypes.data
    addresses[3] = real.ctypes.data + np.uintp(8 * n)
    width = 8 * real.shape[1]
    strides = np.array([width, 128, 0, width, 8, 32, 8, 8, 8], np.int64)
    dimensions = np.empty(1, np.int64)
    for lane in range(cursor[ACTIVE]):
        _aim(lane, whole[lane, POSE], T_sd, targets)
    for _ in range(rounds):
        while cursor[ACTIVE] < whole.shape[0] and cursor[QUEUE] < records.shape[0]:
            pose = cursor[QUEUE]
            cursor[QUEUE] += 1
            if records[pose, ALLOWED] > 0:
                lane = cursor[ACTIVE]
                cursor[ACTIVE] += 1
                whole[lane, POSE] = pose
                _aim(lane, pose, T_sd, targets)
                _begin(lane, numbers, task, T_sd, first, samples, features, centres, begins, real, whole, records)
        if cursor[ACTIVE] == 0:
            break
        dimensions[0] = cursor[ACTIVE]
        call_kernel(entry, addresses.ctypes.data, dimensions.ctypes.data, strides.ctypes.data)
        lane = 0
        while lane < cursor[ACTIVE]:
            pose = whole[lane, POSE]
            if not _ended(lane, pose, n, numbers, task, real, whole, best, records):
                lane += 1
            elif records[pose, WINNER] < 0 and records[pose, STARTED] < records[pose, ALLOWED]:
                _begin(lane, numbers, task, T_sd, first, samples, features, centres, begins, real, whole, records)
                lane += 1
            else:
                last = cursor[ACTIVE] - 1
                cursor[ACTIVE] = last
                for i in range(real.shape[1]):
                    real[lane, i] = real[last, i]
                for i in range(16):
                    targets[lane, i] = targets[last, i]
                whole[lane, POSE] = whole[last, POSE]
                whole[lane, STEP] = whole[last, STEP]
    return cursor[ACTIVE]


@compiled
def _aim(lane: int, pose: int, T_sd: Floats, targets: Floats) -> None:
    """Give a lane its wanted pose."""
    for i in range(16):
        targets[lane, i] = T_sd[pose, i]


@compiled
def _begin(
    lane: int,
    numbers: Floats,
    task: Floats,
    T_sd: Floats,
    first: JointVector,
    samples: JointVector,
    features: Singles,
    centres: Singles,
    begins: Whole,
    real: Floats,
    whole: Whole,
    records: Whole,
) -> None:
    """Start the next attempt of the lane's pose."""
    n = samples.shape[1]
    pose = whole[lane, POSE]
    rank = records[pose, STARTED]
    records[pose, STARTED] += 1
    whole[lane, STEP] = 0
    if first.shape[0] > 0:
        rank -= 1
    if rank < 0:
        for i in range(n):
            real[lane, i] = min(max(first[pose, i], task[9 + i]), task[9 + n + i])
        return
    if rank == 0:
        _nearest(pose, T_sd, numbers, task, features, centres, begins, records)
    chosen = -1
    if rank < RANKED:
        chosen = records[pose, CANDIDATES + rank]
    if chosen < 0:
        chosen = (rank * SCATTER) % samples.shape[0]
    for i in range(n):
        real[lane, i] = samples[chosen, i]


@compiled
def _nearest(
    pose: int,
    T_sd: Floats,
    numbers: Floats,
    task: Floats,
    features: Singles,
    centres: Singles,
    begins: Whole,
    records: Whole,
) -> None:
    """Record the samples nearest to a pose, nearest first, from the two nearest cells; -1 where there are fewer."""
    wanted = np.empty(12)
    _features(pose, T_sd, numbers, task, wanted)
    squares = np.empty(int(numbers[LARGEST]), np.float32)
    sizes = np.empty(RANKED)
    for i in range(RANKED):
        sizes[i] = np.inf
        records[pose, CANDIDATES + i] = -1
    cells = begins.shape[0] - 1
    _squares(wanted, centres, 0, cells, squares)
    nearest, second = 0, -1
    for j in range(1, cells):
        if squares[j] < squares[nearest]:
            nearest, second = j, nearest
        elif second < 0 or squares[j] < squares[second]:
            second = j
    for cell in (nearest, second):
        if cell < 0:
            break
        begin, end = begins[cell], begins[cell + 1]
        _squares(wanted, features, begin, end, squares)
        for j in range(end - begin):
            if squares[j] < sizes[RANKED - 1]:
                place = RANKED - 1
                while place > 0 and squares[j] < sizes[place - 1]:
                    sizes[place] = sizes[place - 1]
                    records[pose, CANDIDATES + place] = records[pose, CANDIDATES + place - 1]
                    place -= 1
                sizes[place] = squares[j]
                records[pose, CANDIDATES + place] = begin + j


@compiled
def _features(pose: int, T_sd: Floats, numbers: Floats, task: Floats, out: Floats) -> None:
    """12 numbers of a pose whose Euclidean distances measure how far poses lie apart for the task."""
    for i in range(12):
        out[i] = 0.0
    for i in range(3):
        for j in range(3):
            turned = numbers[TURNING] * T_sd[pose, 4 * i + j]
            if numbers[ONE_AXIS] > 0.0:
                out[i] += turned * task[6 + j]
            else:
                out[3 * i + j] = turned
        out[9 + i] = numbers[SHIFTING] * T_sd[pose, 4 * i + 3]


@compiled
def _squares(wanted: Floats, table: Singles, begin: int, end: int, out: Singles) -> None:
    """Squared distances of the samples begin to end: one cell of a table, which holds cell by cell (12, size)."""
    count = end - begin
    for j in range(count):
        out[j] = 0.0
    for i in range(12):
        row = table[12 * begin + i * count : 12 * begin + (i + 1) * count]
        middle = np.float32(wanted[i])
        for j in range(count):
            gap = row[j] - middle
            out[j] += gap * gap


@compiled
def _ended(
    lane: int,
    pose: int,
    n: int,
    numbers: Floats,
    task: Floats,
    real: Floats,
    whole: Whole,
    best: Floats,
    records: Whole,
) -> bool:
    """Whether the step just made ends the lane's attempt, solved or given up; else the lane moves on."""
    turn = shift = size = 0.0
    for i in range(6):
        if task[i] > 0.0:
            e = real[lane, 2 * n + i]
            size += (e * task[i]) ** 2
            if i < 3:
                turn += e * e
            else:
                shift += e * e
    size = np.sqrt(size)
    step = whole[lane, STEP]
    solved = turn <= numbers[TURN_LIMIT] and shift <= numbers[SHIFT_LIMIT]
    trusted = size <= numbers[TRUST]
    if solved or trusted:
        begin = 0 if solved else n
        for i in range(n):
            best[pose, i] = real[lane, begin + i]
        best[pose, n] = 0.0
        records[pose, WINNER] = records[pose, STARTED] - 1
        records[pose, STEPS] = step if solved else step + 1
        return True
    if size < best[pose, n]:
        for i in range(n):
            best[pose, i] = real[lane, i]
        best[pose, n] = size
        records[pose, STEPS] = step
    if not size <= _bar(step, records[pose, STARTED] <= RANKED, numbers[PATIENT] > 0.0):
        return True
    for i in range(n):
        real[lane, i] = real[lane, n + i]
    whole[lane, STEP] = step + 1
    return False


@compiled
def _bar(step: int, quick: bool, patient: bool) -> float:
    """The scaled error above which an attempt is given up at a step; negative where it ends anyway."""
    bar = np.inf
    if patient:
        if step >= NEAREST_STEPS:
            bar = -1.0
    elif not quick:
        if step == 16:
            bar = PATIENT_BAR
        elif step >= PATIENT_STEPS:
            bar = -1.0
    elif step == 6:
        bar = EARLY_BAR
    elif step == 8:
        bar = MIDDLE_BAR
    elif step == 12:
        bar = LATE_BAR
    elif step >= QUICK_STEPS:
        bar = -1.0
    return bar


@compiled
def clean(T: Floats, limit: float, centre: Floats, out: Floats, valid: Whole, distance: Floats) -> None:
    """Poses with their rotations brought to working precision; identity where a row is no pose.

    Args:
        T: (k, 16).
        limit: largest element of R'R - I, and of the last row's difference, that is repaired.
        centre: (3) of the reach.
        out: (k, 16) out.
        valid: (k) 1 for poses, 0 for others, out.
        distance: (k) of the origin from the centre, out.
    """
    R, S = np.empty((3, 3)), np.empty((3, 3))
    for row in range(T.shape[0]):
        good = True
        for i in range(16):
            good = good and abs(T[row, i]) < FARTHEST
            if i >= 12:
                good = good and abs(T[row, i] - (1.0 if i == 15 else 0.0)) <= limit
        for i in range(3):
            for j in range(3):
                R[i, j] = T[row, 4 * i + j]
        good = good and _defect(R, S) <= limit and _determinant(R) > 0.0
        valid[row] = 1 if good else 0
        for i in range(16):
            out[row, i] = 1.0 if i % 5 == 0 else 0.0
        if good:
            # Newton's iteration for the polar factor: the defect is squared each time.
            for _ in range(2):
                _defect(R, S)
                for i in range(3):
                    a, b, c = R[i, 0], R[i, 1], R[i, 2]
                    for j in range(3):
                        R[i, j] -= 0.5 * (a * S[0, j] + b * S[1, j] + c * S[2, j])
            for i in range(3):
                out[row, 4 * i + 3] = T[row, 4 * i + 3]
                for j in range(3):
                    out[row, 4 * i + j] = R[i, j]
        square = 0.0
        for i in range(3):
            square += (out[row, 4 * i + 3] - centre[i]) ** 2
        distance[row] = np.sqrt(square)


@compiled
def _defect(R: Floats, S: Floats) -> float:
    """Largest element of S = R'R - I."""
    worst = 0.0
    for i in range(3):
        for j in range(3):
            S[i, j] = R[0, i] * R[0, j] + R[1, i] * R[1, j] + R[2, i] * R[2, j] - (1.0 if i == j else 0.0)
            worst = max(worst, abs(S[i, j]))
    return worst


@compiled
def _determinant(R: Floats) -> float:
    return (
        R[0, 0] * (R[1, 1] * R[2, 2] - R[1, 2] * R[2, 1])
        - R[0, 1] * (R[1, 0] * R[2, 2] - R[1, 2] * R[2, 0])
        + R[0, 2] * (R[1, 0] * R[2, 1] - R[1, 1] * R[2, 0])
    )


@compiled
def wind(best: Floats, near: JointVector, turning: Whole, task: Floats) -> None:
    """Turning joints moved by whole turns as close to `near` as their bounds allow.

    Args:
        best: (k, n + 1) configurations, changed.
        near: (k, n), or (1, n) for all.
        turning: (n) 1 for joints that turn.
        task: as for `advance`.
    """
    n = near.shape[1]
    for row in range(best.shape[0]):
        for i in range(n):
            if turning[i] == 1:
                wish = near[row if near.shape[0] > 1 else 0, i]
                moved = best[row, i] - 2.0 * np.pi * np.round((best[row, i] - wish) / (2.0 * np.pi))
                if moved >= task[9 + i] and moved <= task[9 + n + i]:
                    best[row, i] = moved


@compiled
def judge(
    checked: Floats, best: Floats, numbers: Floats, task: Floats, rotation: Floats, position: Floats, good: Whole
) -> int:
    """What the check of every configuration says.

    Args:
        checked: (k, 22) pose and twist that is left, by the check kernel.
        best: (k, n + 1) configurations.
        numbers, task: as for `advance`.
        rotation, position: (k) errors of what counts [rad, m], out.
        good: (k) 1 where tolerances and bounds are met, out.

    Returns:
        Number of good rows.
    """
    n = best.shape[1] - 1
    count = 0
    for row in range(best.shape[0]):
        turn = shift = 0.0
        for i in range(3):
            if task[i] > 0.0:
                turn += checked[row, 16 + i] ** 2
            if task[3 + i] > 0.0:
                shift += checked[row, 19 + i] ** 2
        rotation[row], position[row] = np.sqrt(turn), np.sqrt(shift)
        # The search aims at half the tolerances, whose squares the numbers hold.
        met = turn <= 4.0 * numbers[TURN_LIMIT] and shift <= 4.0 * numbers[SHIFT_LIMIT]
        for i in range(n):
            met = met and best[row, i] >= task[9 + i] and best[row, i] <= task[9 + n + i]
        good[row] = 1 if met else 0
        count += good[row]
    return count
