"""Starts of the search, compiled: a plan's record, and the samples whose poses are nearest to a pose."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats
from mafsil.kernels.loop_compiler import Singles, Whole

JOINTS, SAMPLES, CELLS, TURN_LIMIT, SHIFT_LIMIT, TURN_FACTOR, SHIFT_FACTOR, ONE_AXIS, TRUST = 0, 1, 2, 3, 4, 5, 6, 7, 8
"""Places of a plan: numbers of joints, samples and cells; squares of half the tolerances; factors of the features of
rotations and positions; whether the task turns one axis only; the scaled error from which a last step is trusted."""
RADIUS, DEFECT, CENTRE = 9, 10, 11
"""Radius of the reach, infinite where positions do not count; largest defect of a rotation that is repaired; centre."""
TASK = 16
"""Then weights (6), axis (3), lower bounds (n), upper bounds (n): the kernels' third port. Then (n) 1 for joints that
turn, (c + 1) first sample and (c + 1) first group of features of every cell, and (m, n) the samples, cell by cell."""

CANDIDATES = 8
"""Attempts of a pose that begin at the samples nearest to it, in this order; later ones begin anywhere."""
MOST_SAMPLES, MOST_CELLS, GROUP = 2048, 64, 16
"""Most samples and cells of a plan; features stand in groups of so many samples, which one vector instruction takes."""
ROW = 2112
"""Room for the distances of two cells, each filled up to whole groups, or of the centres."""

POSE, STEP, NEAREST, SECOND, LAST = 0, 1, 2, 3, 4
"""Places of a lane: its pose, the step of its attempt, the cells nearest to the pose, the sample last chosen or -1."""
LANE = 5


def features_of(plan: Floats, T: Floats, out: Floats) -> None:
    """12 numbers of a pose whose Euclidean distances measure how far poses lie apart for the task.

    Args:
        plan: see JOINTS to TASK.
        T: (16) pose.
        out: (12) rotation's elements, or the axis in {s} and zeros; position.
    """
    for i in range(12):
        out[i] = 0.0
    for i in range(3):
        for j in range(3):
            turned = plan[TURN_FACTOR] * T[4 * i + j]
            if plan[ONE_AXIS] > 0.0:
                out[i] += turned * plan[TASK + 6 + j]
            else:
                out[3 * i + j] = turned
        out[9 + i] = plan[SHIFT_FACTOR] * T[4 * i + 3]


def squared_distances(wanted: Singles, groups: Singles, count: int, beyond: float, out: Singles) -> float:
    """Squared distances of samples from a pose, and the least of them.

    Args:
        wanted: (12) features of the pose.
        groups: (count, 12, GROUP) features of the samples.
        count: how many groups.
        beyond: only distances that are larger count as the least.
        out: (count GROUP).

    Returns:
        The least that is larger, infinity if there is none.
    """
    a, b, c, d, e, f = wanted[0], wanted[1], wanted[2], wanted[3], wanted[4], wanted[5]
    g, h, u, v, w, x = wanted[6], wanted[7], wanted[8], wanted[9], wanted[10], wanted[11]
    passed, nothing = np.float32(beyond), np.float32(np.inf)
    least = np.empty(GROUP, np.float32)
    for k in range(GROUP):
        least[k] = nothing
    for group in range(count):
        at, row = groups[12 * GROUP * group :], out[GROUP * group :]
        for k in range(GROUP):
            size = (at[k] - a) ** 2 + (at[GROUP + k] - b) ** 2 + (at[2 * GROUP + k] - c) ** 2
            size = size + (at[3 * GROUP + k] - d) ** 2 + (at[4 * GROUP + k] - e) ** 2 + (at[5 * GROUP + k] - f) ** 2
            size = size + (at[6 * GROUP + k] - g) ** 2 + (at[7 * GROUP + k] - h) ** 2 + (at[8 * GROUP + k] - u) ** 2
            size = size + (at[9 * GROUP + k] - v) ** 2 + (at[10 * GROUP + k] - w) ** 2 + (at[11 * GROUP + k] - x) ** 2
            row[k] = size
            larger = size if size > passed else nothing
            least[k] = larger if larger < least[k] else least[k]
    for half in range(1, GROUP):
        least[0] = least[half] if least[half] < least[0] else least[0]
    return float(least[0])


def place_of(wanted: float, row: Singles, count: int) -> int:
    """Where a number stands, -1 if nowhere.

    Args:
        wanted: the number.
        row: (count).
        count: how many.
    """
    for j in range(count):
        if row[j] == wanted:
            return j
    return -1


def nearest_cells(plan: Floats, features: Singles, wanted: Singles, lane: Whole) -> None:
    """Write the two cells whose centres are nearest to a pose into its lane; the second is -1 if there is only one.

    Args:
        plan: see JOINTS to TASK.
        features: groups (12, GROUP) of the cells' centres, then of every cell's samples, filled up with far ones.
        wanted: (12) features of the pose.
        lane: (LANE).
    """
    cells = int(plan[CELLS])
    groups = (cells + GROUP - 1) // GROUP
    row = np.empty(ROW, np.float32)
    least = squared_distances(wanted, features, groups, -1.0, row)
    lane[NEAREST] = place_of(least, row, cells)
    lane[SECOND] = place_of(squared_distances(wanted, features, groups, least, row), row, cells)
    lane[LAST] = -1


def next_sample(plan: Floats, features: Singles, T: Floats, lane: Whole) -> int:
    """The sample that comes next in order of distance from a pose, among those of its two nearest cells.

    1. Features of the pose, and at its first attempt its cells.
    2. The distance of the sample chosen last.
    3. The least distance that is larger, and whose it is.

    Args:
        plan, features: as for `nearest_cells`.
        T: (16) pose.
        lane: (LANE) whose last choice is read and written; its NEAREST is -1 at the first attempt.

    Returns:
        Its number, -1 if there are no more.
    """
    n, cells = int(plan[JOINTS]), int(plan[CELLS])
    begins = plan[TASK + 9 + 3 * n :]
    exact, wanted, row = np.empty(12), np.empty(12, np.float32), np.empty(ROW, np.float32)
    # 1.
    features_of(plan, T, exact)
    for i in range(12):
        wanted[i] = np.float32(exact[i])
    if lane[NEAREST] < 0:
        nearest_cells(plan, features, wanted, lane)
    near, second = lane[NEAREST], lane[SECOND]
    first, first_group = int(begins[near]), int(begins[cells + 1 + near])
    count, groups = int(begins[near + 1]) - first, int(begins[cells + 2 + near]) - first_group
    other, other_group, more, more_groups = 0, 0, 0, 0
    if second >= 0:
        other, other_group = int(begins[second]), int(begins[cells + 1 + second])
        more, more_groups = int(begins[second + 1]) - other, int(begins[cells + 2 + second]) - other_group
    # 2.
    beyond = -1.0
    last = lane[LAST]
    if last >= 0:
        place = last - first if first <= last < first + count else last - other
        from_group = (first_group if first <= last < first + count else other_group) + place // GROUP
        beyond = squared_distances(wanted, features[12 * GROUP * from_group :], 1, -1.0, row)
        beyond = float(row[place % GROUP])
    # 3.
    least = squared_distances(wanted, features[12 * GROUP * first_group :], groups, beyond, row)
    second_least = squared_distances(
        wanted, features[12 * GROUP * other_group :], more_groups, beyond, row[GROUP * groups :]
    )
    chosen = -1
    if least <= second_least:
        place = place_of(least, row, count)
        chosen = first + place if place >= 0 else -1
    else:
        place = place_of(second_least, row[GROUP * groups :], more)
        chosen = other + place if place >= 0 else -1
    lane[LAST] = chosen
    return chosen
