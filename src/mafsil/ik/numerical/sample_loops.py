"""Starts of the search, compiled: the samples whose poses are nearest to a pose."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats
from mafsil.ik.numerical.records import DISTANCES, FEATURE_GROUP, FEATURES, Lane, Plan
from mafsil.kernels.loop_compiler import Singles


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
            if plan.one_axis > 0:
                out[i] += rotated * plan.axis[j]
            else:
                out[3 * i + j] = rotated
        out[9 + i] = plan.position_factor * T[4 * i + 3]


def squared_distances(features: Singles, groups: Singles, count: int, beyond: float, out: Singles) -> float:
    """Squared distances of samples from a pose, and the least of them.

    1. The squared distance from every sample, a group of samples side by side.
    2. The least of each column that is beyond.
    3. The least of the columns.

    Args:
        features: (FEATURES) of the pose.
        groups: (count, FEATURES, FEATURE_GROUP) features of the samples.
        count: how many groups.
        beyond: only distances that are larger count as the least.
        out: (count FEATURE_GROUP).

    Returns:
        The least that is larger, infinity if there is none.
    """
    a, b, c, d, e, f = features[0], features[1], features[2], features[3], features[4], features[5]
    g, h, u, v, w, x = features[6], features[7], features[8], features[9], features[10], features[11]
    passed, nothing, n = np.float32(beyond), np.float32(np.inf), FEATURE_GROUP
    least = np.empty(FEATURE_GROUP, np.float32)
    for k in range(n):
        least[k] = nothing
    # 1.
    for group in range(count):
        at, row = groups[FEATURES * n * group :], out[n * group :]
        for k in range(n):
            size = (at[k] - a) ** 2 + (at[n + k] - b) ** 2 + (at[2 * n + k] - c) ** 2
            size = size + (at[3 * n + k] - d) ** 2 + (at[4 * n + k] - e) ** 2 + (at[5 * n + k] - f) ** 2
            size = size + (at[6 * n + k] - g) ** 2 + (at[7 * n + k] - h) ** 2 + (at[8 * n + k] - u) ** 2
            size = size + (at[9 * n + k] - v) ** 2 + (at[10 * n + k] - w) ** 2 + (at[11 * n + k] - x) ** 2
            row[k] = size
            # 2.
            larger = size if size > passed else nothing
            least[k] = larger if larger < least[k] else least[k]
    # 3.
    for k in range(1, n):
        least[0] = least[k] if least[k] < least[0] else least[0]
    return float(least[0])


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


def nearest_cells(plan: Plan, features: Singles, lane: Lane) -> None:
    """Write the two cells whose centres are nearest to a pose into its lane; the second is -1 if there is only one.

    Args:
        plan: of the search.
        features: (FEATURES) of the pose.
        lane: of the pose.
    """
    groups = (plan.cells + FEATURE_GROUP - 1) // FEATURE_GROUP
    row = np.empty(DISTANCES, np.float32)
    least = squared_distances(features, plan.features, groups, -1.0, row)
    lane.nearest = place_of(least, row, plan.cells)
    lane.second = place_of(squared_distances(features, plan.features, groups, least, row), row, plan.cells)
    lane.last = -1


def next_sample(plan: Plan, T: Floats, lane: Lane) -> int:
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
    if lane.nearest < 0:
        nearest_cells(plan, features, lane)
    cell, second = lane.nearest, lane.second
    first, first_group = plan.first_sample[cell], plan.first_group[cell]
    count, groups = plan.first_sample[cell + 1] - first, plan.first_group[cell + 1] - first_group
    other, other_group, other_count, other_groups = 0, 0, 0, 0
    if second >= 0:
        other, other_group = plan.first_sample[second], plan.first_group[second]
        other_count = plan.first_sample[second + 1] - other
        other_groups = plan.first_group[second + 1] - other_group
    # 2.
    beyond = -1.0
    last = lane.last
    if last >= 0:
        place = last - first if first <= last < first + count else last - other
        group = (first_group if first <= last < first + count else other_group) + place // FEATURE_GROUP
        squared_distances(features, plan.features[FEATURES * FEATURE_GROUP * group :], 1, -1.0, row)
        beyond = float(row[place % FEATURE_GROUP])
    # 3.
    groups_of_cell = plan.features[FEATURES * FEATURE_GROUP * first_group :]
    groups_of_other = plan.features[FEATURES * FEATURE_GROUP * other_group :]
    other_row = row[FEATURE_GROUP * groups :]
    least = squared_distances(features, groups_of_cell, groups, beyond, row)
    other_least = squared_distances(features, groups_of_other, other_groups, beyond, other_row)
    chosen = -1
    if least <= other_least:
        place = place_of(least, row, count)
        chosen = first + place if place >= 0 else -1
    else:
        place = place_of(other_least, other_row, other_count)
        chosen = other + place if place >= 0 else -1
    lane.last = chosen
    return chosen
