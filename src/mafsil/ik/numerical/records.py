"""What the compiled search works on: all its records, the columns of its report, and the sizes of its memory.

A `Plan` is made once for a frame and a task, a `Search` for every block of poses, a `Batch` where the poses are also
cleaned before and checked after. Poses have a `PoseRecord` each; a `Lane` is where one of them is worked on.
"""

from __future__ import annotations

from mafsil.arrays import Floats, JointVector
from mafsil.kernels.loop_compiler import Record, Rows, Singles, Whole

GROUP = 8
"""Lanes are handed to the kernel by whole vectors of any processor; what lies in lanes at rest is of no account."""

MOST_SAMPLES, MOST_CELLS, FEATURE_GROUP = 2048, 64, 16
"""Most samples and cells of a plan; features stand in groups of so many samples, which one vector instruction takes."""

FEATURES = 12
"""Numbers of a pose whose Euclidean distances measure how far poses lie apart."""

DISTANCES = 2112
"""Most distances of two cells, each filled up to whole groups, or of the centres."""

TASK = 9
"""Numbers of a task before the bounds: weights (6), axis (3)."""

LEFT = 6
"""Numbers of a twist: what is left of rotation and position."""

ROTATION_ERROR, POSITION_ERROR, DISTANCE, REACHED, TWIST, CONFIGURATION = 0, 1, 2, 3, 19, 25
"""Columns of the report: errors [rad, m], distance of the origin from the centre of the reach [m]; what the check
kernel gives: pose (16) and twist left (6); then joints (n)."""


class Plan(Record):
    """What a search knows before any pose.

    Attributes:
        joints, samples, cells: how many.
        rotation_limit, position_limit: squares of half the tolerances [rad^2, m^2].
        rotation_factor, position_factor: of the features of rotations and positions.
        one_axis: 1 if the task turns one axis only.
        trust: scaled error from which a last step is trusted.
        radius: of the reach [m]; infinite where positions do not count.
        defect: largest defect of a rotation that is repaired.
        centre: (3) of the reach [m].
        task: (TASK + 2 n) weights, axis, lower and upper bounds: the kernels' third port.
        weights, axis, lower, upper: parts of it.
        revolute: (n) 1 for revolute joints.
        first_sample, first_group: (cells + 1) of every cell.
        configurations: (samples, n) cell by cell.
        features: groups (FEATURES, FEATURE_GROUP) of the cells' centres, then of every cell's samples, filled up with
            far ones.
    """

    joints: int
    samples: int
    cells: int
    rotation_limit: float
    position_limit: float
    rotation_factor: float
    position_factor: float
    one_axis: int
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


class PoseRecord(Record):
    """How the search for a pose went.

    Attributes:
        begun, allowed: attempts.
        winner: the attempt that solved it, or -1.
        steps: of the attempt that solved it or came nearest.
    """

    begun: int
    allowed: int
    winner: int
    steps: int


class Lane(Record):
    """Where one pose is worked on.

    Attributes:
        pose: its place.
        step: of its present attempt.
        nearest, second: cells nearest to the pose; -1 if not known, or none.
        last: sample chosen last, or -1.
    """

    pose: int
    step: int
    nearest: int
    second: int
    last: int


class Search(Record):
    """The search for some poses.

    Attributes:
        plan: of the search.
        step: address of the step kernel: (q, T_sd, task) to (q_next, e).
        rounds: most steps of all lanes in one call.
        mode: bits TRUSTED, PATIENT.
        poses, lanes: how many; lanes are a multiple of GROUP, or one.
        desired: (poses, 16) clean poses.
        guessed: 1 if there are initial guesses.
        q0: (poses, n) them.
        q: (poses, n + 1) solution or nearest configuration of every pose, and its scaled error, zero if solved.
        record: of every pose.
        lane: of every lane.
        lane_desired: (lanes, 16) poses of the lanes.
        lane_states: (2, lanes, n + LEFT) joints and errors of all lanes; the halves take turns as the kernel's input
            and output.
        next_pose: first pose that nobody has begun.
        active: lanes at work.
        half: which half of the states holds the joints.
    """

    plan: Plan
    step: int
    rounds: int
    mode: int
    poses: int
    lanes: int
    desired: Floats
    guessed: int
    q0: JointVector
    q: Floats
    record: Rows[PoseRecord]
    lane: Rows[Lane]
    lane_desired: Floats
    lane_states: Floats
    next_pose: int
    active: int
    half: int


class Batch(Record):
    """Poses as a user gives them, to a report.

    Attributes:
        search: with memory for the poses.
        check: address of the check kernel: (q, T_sd, task) to (T_sf, e).
        given: (poses, 16).
        allowed: attempts of each.
        zeros: (n) of them.
        report: (poses, CONFIGURATION + n) out.
    """

    search: Search
    check: int
    given: Floats
    allowed: int
    zeros: JointVector
    report: Floats
