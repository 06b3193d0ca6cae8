"""What the compiled search works on: its records, the columns of its tables, and its starts.

A `Plan` is made once for a frame and a task, a `Search` for every block of poses, a `Batch` where the poses are also
cleaned before and checked after. Poses have a row of `attempts` each; a lane is where one of them is worked on. Starts
are the samples whose poses are nearest to a pose.
"""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector
from mafsil.kernels.loops import compiled

GROUP = 8
"""Lanes are handed to the kernel by whole vectors of any processor; what lies in lanes at rest is of no account."""

MOST_SAMPLES, MOST_CELLS, FEATURE_GROUP = 2048, 64, 16
"""Most samples and cells of a plan; features stand in groups of so many samples, which one vector instruction takes."""

FEATURES = 12
"""Numbers of a pose whose Euclidean distances measure how far poses lie apart."""

DISTANCES = 2112
"""Most distances of two cells, each filled up to whole groups, or of the centres."""

LEFT = 6
"""Numbers of a twist: what is left of rotation and position."""

ROTATION_ERROR, POSITION_ERROR, DISTANCE, REACHED, TWIST, CONFIGURATION = 0, 1, 2, 3, 19, 25
"""Columns of the report: errors [rad, m], distance of the origin from the centre of the reach [m]; what the check
kernel gives: pose (16) and twist left (6); then joints (n)."""

BEGUN, ALLOWED, WINNER, STEPS = range(4)
"""Columns of a pose's attempts: how many were begun and may be; the one that solved it, or -1; steps of the one that
solved it or came nearest."""

POSE, STEP, NEAREST, SECOND, LAST = range(5)
"""Columns of a lane: its pose; the step of its present attempt; cells nearest to the pose, -1 if not known, or none;
the sample chosen last, or -1."""

NEXT, ACTIVE, HALF = range(3)
"""How far a search is: the first pose that nobody has begun, lanes at work, the half of the states with the joints."""

Whole: TypeAlias = NDArray[np.int64]
Singles: TypeAlias = NDArray[np.float32]


class Plan(NamedTuple):
    """What a search knows before any pose.

    Attributes:
        rotation_limit, position_limit: squares of half the tolerances [rad^2, m^2].
        rotation_factor, position_factor: of the features of rotations and positions.
        one_axis: whether the task turns one axis only.
        trust: scaled error from which a last step is trusted.
        radius: of the reach [m]; infinite where positions do not count.
        defect: largest defect of a rotation that is repaired.
        centre: (3) of the reach [m].
        task: (9 + 2 n) weights, axis, lower and upper bounds: the kernels' third port.
        weights, axis, lower, upper: parts of it.
        revolute: (n) 1 for revolute joints.
        first_sample, first_group: (cells + 1) of every cell.
        configurations: (samples, n) cell by cell.
        features: (groups, FEATURES, FEATURE_GROUP) of the cells' centres, then of every cell's samples, filled up with
            far ones.
    """

    rotation_limit: float
    position_limit: float
    rotation_factor: float
    position_factor: float
    one_axis: bool
    trust: float
    radius: float
    defect: float
    centre: Floats
    task: Floats
    weights: Floats
    axis: Floats
    lower: JointVector
    upper: JointVector
    revolute: Whole
    first_sample: Whole
    first_group: Whole
    configurations: JointVector
    features: Singles


class Search(NamedTuple):
    """The search for some poses.

    Attributes:
        step: address of the step kernel: (q, T_sd, task) to (q_next, e).
        desired: (poses, 16) clean poses.
        q0: (poses, n) initial guesses, or (0, n) if there are none.
        q: (poses, n + 1) solution or nearest configuration of every pose, and its scaled error, zero if solved.
        attempts: (poses, 4) of every pose.
        lanes: (lanes, 5) a multiple of GROUP, or one.
        lane_desired: (lanes, 16) poses of the lanes.
        states: (2, lanes, n + LEFT) joints and errors of all lanes; the halves take turns as the kernel's input and
            output.
        progress: (3) how far it is.
    """

    step: int
    desired: Floats
    q0: JointVector
    q: Floats
    attempts: Whole
    lanes: Whole
    lane_desired: Floats
    states: Floats
    progress: Whole


class Batch(NamedTuple):
    """Poses as a user gives them, to a report.

    Attributes:
        plan: of the search.
        search: with memory for the poses.
        check: address of the check kernel: (q, T_sd, task) to (T_sf, e).
        given: (poses, 16).
        zeros: (n) of them.
        report: (poses, CONFIGURATION + n) out.
    """

    plan: Plan
    search: Search
    check: int
    given: Floats
    zeros: JointVector
    report: Floats


@compiled
def features_of(plan: Plan, T: Floats, out: Floats) -> None:
    """Numbers of a pose whose Euclidean distances measure how far poses lie apart for the task.

    Args:
        plan: of the search.
        T: (16) pose.
        out: (FEATURES) rotation's elements, or the axis in {s} and zeros; position.
    """
    for i in range(FEATURES):
        out[i] = 0.0
    for i in range(3):
        for j in range(3):
            rotated = plan.rotation_factor * T[4 * i + j]
            if plan.one_axis:
                out[i] += rotated * plan.axis[j]
            else:
                out[3 * i + j] = rotated
        out[9 + i] = plan.position_factor * T[4 * i + 3]


@compiled
def squared_distances(features: Singles, groups: Singles, beyond: float, out: Singles) -> float:
    """Squared distances of samples from a pose, and the least of them.

    1. The squared distance from every sample, a group of samples side by side.
    2. The least of each column that is beyond.
    3. The least of the columns.

    Args:
        features: (FEATURES) of the pose.
        groups: (groups, FEATURES, FEATURE_GROUP) features of the samples.
        beyond: only distances that are larger count as the least.
        out: (groups FEATURE_GROUP).

    Returns:
        The least that is larger, infinity if there is none.
    """
    a, b, c, d, e, f = features[0], features[1], features[2], features[3], features[4], features[5]
    g, h, u, v, w, x = features[6], features[7], features[8], features[9], features[10], features[11]
    passed, nothing = np.float32(beyond), np.float32(np.inf)
    least = np.empty(FEATURE_GROUP, np.float32)
    for k in range(FEATURE_GROUP):
        least[k] = nothing
    # 1.
    for group in range(len(groups)):
        at, row = groups[group], out[FEATURE_GROUP * group :]
        for k in range(FEATURE_GROUP):
            size = (at[0, k] - a) ** 2 + (at[1, k] - b) ** 2 + (at[2, k] - c) ** 2
            size = size + (at[3, k] - d) ** 2 + (at[4, k] - e) ** 2 + (at[5, k] - f) ** 2
            size = size + (at[6, k] - g) ** 2 + (at[7, k] - h) ** 2 + (at[8, k] - u) ** 2
            size = size + (at[9, k] - v) ** 2 + (at[10, k] - w) ** 2 + (at[11, k] - x) ** 2
            row[k] = size
            # 2.
            larger = size if size > passed else nothing
            least[k] = larger if larger < least[k] else least[k]
    # 3.
    for k in range(1, FEATURE_GROUP):
        least[0] = least[k] if least[k] < least[0] else least[0]
    return float(least[0])


@compiled
def place_of(number: float, row: Singles, count: int) -> int:
    """Where a number stands, -1 if nowhere.

    Args:
        number: which.
        row: (count).
        count: how many.
    """
    for j in range(count):
        if row[j] == number:
            return j
    return -1


@compiled
def nearest_cells(plan: Plan, features: Singles, lane: Whole) -> None:
    """Write the two cells whose centres are nearest to a pose into its lane; the second is -1 if there is only one.

    Args:
        plan: of the search.
        features: (FEATURES) of the pose.
        lane: of the pose.
    """
    cells = len(plan.first_sample) - 1
    centres = plan.features[: plan.first_group[0]]
    row = np.empty(DISTANCES, np.float32)
    least = squared_distances(features, centres, -1.0, row)
    lane[NEAREST] = place_of(least, row, cells)
    lane[SECOND] = place_of(squared_distances(features, centres, least, row), row, cells)
    lane[LAST] = -1


@compiled
def _cell(plan: Plan, cell: int) -> tuple[int, int, int, int]:
    """Where samples and groups of features of a cell begin, and how many it has of each; none of cell -1."""
    if cell < 0:
        return 0, 0, 0, 0
    first, group = int(plan.first_sample[cell]), int(plan.first_group[cell])
    return first, int(plan.first_sample[cell + 1]) - first, group, int(plan.first_group[cell + 1]) - group


@compiled
def next_sample(plan: Plan, T: Floats, lane: Whole) -> int:
    """The sample that comes next in order of distance from a pose, among those of its two nearest cells.

    1. Features of the pose, and at its first attempt its cells: where their samples and groups of features begin.
    2. The distance of the sample chosen last.
    3. The least distance that is larger, and whose it is.

    Args:
        plan: of the search.
        T: (16) pose.
        lane: of the pose, whose last choice is read and written; its nearest cell is -1 at the first attempt.

    Returns:
        Its number, -1 if there are no more.
    """
    exact, features = np.empty(FEATURES), np.empty(FEATURES, np.float32)
    row = np.empty(DISTANCES, np.float32)
    # 1.
    features_of(plan, T, exact)
    for i in range(FEATURES):
        features[i] = np.float32(exact[i])
    if lane[NEAREST] < 0:
        nearest_cells(plan, features, lane)
    first, count, first_group, groups = _cell(plan, lane[NEAREST])
    other, other_count, other_group, other_groups = _cell(plan, lane[SECOND])
    # 2.
    beyond = -1.0
    last = int(lane[LAST])
    if last >= 0:
        place = last - first if first <= last < first + count else last - other
        group = (first_group if first <= last < first + count else other_group) + place // FEATURE_GROUP
        squared_distances(features, plan.features[group : group + 1], -1.0, row)
        beyond = float(row[place % FEATURE_GROUP])
    # 3.
    other_row = row[FEATURE_GROUP * groups :]
    least = squared_distances(features, plan.features[first_group : first_group + groups], beyond, row)
    groups_of_other = plan.features[other_group : other_group + other_groups]
    other_least = squared_distances(features, groups_of_other, beyond, other_row)
    chosen = -1
    if least <= other_least:
        place = place_of(least, row, count)
        chosen = first + place if place >= 0 else -1
    else:
        place = place_of(other_least, other_row, other_count)
        chosen = other + place if place >= 0 else -1
    lane[LAST] = chosen
    return chosen
