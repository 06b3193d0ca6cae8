"""What the compiled search works on: its records, the columns of its tables, and the sizes of its memory.

A `Plan` is made once for a frame and a task, a `Search` for every block of poses, a `Batch` where the poses are also
cleaned before and checked after. Poses have a row of `attempts` each; a lane is where one of them is worked on.
"""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector

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
