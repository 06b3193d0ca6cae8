"""Inverse kinematics with all solutions: one call for one pose or for whole batches."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, cast

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import LARGEST, SMALLEST, JointVector, as_batch, positive, single
from mafsil.errors import InputError
from mafsil.ik.answers.one_pose import POSE, clear_set, judged_pose, one_pose, pose_near
from mafsil.ik.answers.question import Question
from mafsil.ik.answers.setting import MASKS, Quick, require_task, setting
from mafsil.ik.answers.solution_set import SolutionSet
from mafsil.ik.redundant.parametric_form import has_redundant_joints
from mafsil.ik.structure.analysis import Task
from mafsil.lazy_module import lazily
from mafsil.model.loading import RobotLike
from mafsil.robot import Robot, as_robot
from mafsil.robot.degrees import DegreesView, remark_on_degrees, takes_degrees

if TYPE_CHECKING:
    import mafsil.geometry.membership as membership
    import mafsil.ik.answers.many_poses as many_poses
    import mafsil.ik.answers.redundant_single as redundant_single
    import mafsil.ik.redundant.at_parameter as at_parameter
else:
    membership = lazily("mafsil.geometry.membership")
    at_parameter = lazily("mafsil.ik.redundant.at_parameter")
    redundant_single = lazily("mafsil.ik.answers.redundant_single")
    many_poses = lazily("mafsil.ik.answers.many_poses")

if TYPE_CHECKING:
    from mafsil.ik.answers.batch import SolutionBatch

_POSE: Task = "pose"
_KEPT, _UNKNOWN = "closed form of the tip", object()
"""Where a robot keeps the compiled closed form of its tip: no name that an attribute could have."""


@takes_degrees("q0")
def inverse_kinematics(
    robot: RobotLike,
    T_sd: ArrayLike,
    *,
    frame: str | None = None,
    task: Task = _POSE,
    q0: ArrayLike | None = None,
    free: float | Mapping[str, float] | None = None,
    tolerance: float = 1e-9,
    degrees: bool = False,
) -> SolutionSet | SolutionBatch:
    """All joint vectors that bring the tip to a pose, or to each pose of a batch.

    Joints that do not move the frame, such as those of a gripper, are no unknowns.

    Args:
        robot: any arm, a Mechanism, a name of the library or a file.
        T_sd: (4, 4) requested pose in {s}, or (*batch, 4, 4).
        frame: name of a link; the tip if None.
        task: `pose`, `position` only, or `axis`: position and direction of the tip's z axis.
        q0: (n,) values that free joints, locked joints of redundant arms and joints that do not move the frame take;
            the middle of their limits if None.
        free: of arms with seven coordinates and one pose: value of their free parameter, or {name: value} of the
            `arm angle` or of a joint; see `redundancy`.
        tolerance: largest residual [m | rad] of a solution. Arms with fewer joints than the task has equations meet a
            rounded pose in the sense of least squares; other arms the nearest configuration where there is no exact
            one.
        degrees: the angles in q0 and in the answer's solutions, sentences and tables are in degrees.

    Returns:
        For one pose a `SolutionSet`: solutions with branches, families and reasons; where `complete` is set there are
        no others. A redundant arm (more joints than the task needs) gets the solutions with the locked joints at `q0`,
        each the member of a family. For a batch a `SolutionBatch`: padded arrays, and a `SolutionSet` by index.

    Raises:
        InputError: a wrong shape, no pose, an unknown task, a tolerance that is not positive.
        ModelError: an unknown frame.
    """
    if type(T_sd) is np.ndarray and T_sd.shape == POSE and type(robot) is Robot and not degrees and _ready(robot, q0):
        plain = type(tolerance) is float and SMALLEST <= tolerance <= LARGEST and T_sd.dtype == np.float64
        # One pose as programs give it: the compiled closed form decides, and most often its rows are the answer.
        quick = _quick(robot, frame, task) if free is None else None
        if quick is not None and plain:
            if q0 is not None:
                return pose_near(quick, T_sd, cast("JointVector", q0), tolerance)
            q, details, decision = quick.call(T_sd, *quick.preferences, tolerance)
            if decision > 0.0:
                chosen = quick.rows(decision)
                return clear_set(quick.setting, q[chosen], details, chosen)
            question = Question(quick.setting, T_sd.copy(), quick.setting.middle, tolerance)
            return judged_pose(question, (q, details, decision))
        if plain and q0 is None and type(task) is str and task in MASKS:
            arm = setting(robot, frame, task)
            if free is not None:
                return at_parameter.with_parameter(arm, T_sd, free, tolerance)
            if has_redundant_joints(arm):
                return redundant_single.redundant_single(arm, T_sd, arm.middle, tolerance)
    answer = _answer(as_robot(robot), T_sd, frame, task, q0, free, tolerance)
    return cast("SolutionSet", DegreesView(answer, as_robot(robot))) if degrees else answer


def _ready(robot: Robot, q0: ArrayLike | None) -> bool:
    """Whether preferred values are as programs give them: nothing has to be converted, and all are finite."""
    if q0 is None:
        return True
    # A NaN is not less than anything.
    return type(q0) is np.ndarray and q0.dtype == np.float64 and q0.shape == (robot.n,) and q0.dot(q0) < LARGEST


def _answer(
    robot: Robot,
    T_sd: ArrayLike,
    frame: str | None,
    task: Task,
    q0: ArrayLike | None,
    free: float | Mapping[str, float] | None,
    tolerance: float,
) -> SolutionSet | SolutionBatch:
    """The answer to whatever is arm for, all arguments checked."""
    require_task(task)
    tolerance = positive("tolerance", tolerance)
    requested = as_batch("T_sd", T_sd, POSE)
    arm = setting(robot, frame, task)
    others = arm.part.middle if q0 is None else single("q0", q0, (robot.n,))
    remark_on_degrees(robot, "q0", q0)
    if requested.ndim > 2:
        if free is not None:
            raise InputError("redundant.one_pose", shape=requested.shape)
        return many_poses.solved_batch(arm, membership.snap_to_kind("pose", "T_sd", requested), others, tolerance)
    if free is None:
        start = arm.middle if q0 is None else arm.part.own(others)
        return one_pose(arm, requested, start, tolerance, others)
    return at_parameter.with_parameter(arm, requested, free, tolerance)


def _quick(robot: Robot, frame: str | None, task: Task) -> Quick | None:
    """The compiled closed form of a robot's tip or of a frame; None where there is none, or no such task."""
    if frame is None and task is _POSE:
        known = vars(robot).get(_KEPT, _UNKNOWN)
        if known is _UNKNOWN:
            vars(robot)[_KEPT] = known = setting(robot, None, _POSE).quick
        return known
    return setting(robot, frame, task).quick if type(task) is str and task in MASKS else None
