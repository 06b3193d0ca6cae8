"""One solution, the nearest to a configuration: from the complete list where there is one, else by descent."""

from __future__ import annotations

from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import JointVector, as_batch
from mafsil.ik.answers.setting import require_task, setting
from mafsil.ik.answers.solution_set import SolutionSet
from mafsil.ik.inverse import inverse_kinematics
from mafsil.ik.numerical import solve_ik
from mafsil.ik.result import IKResult
from mafsil.ik.structure.analysis import Task
from mafsil.model.loading import RobotLike
from mafsil.robot import Robot, as_robot


def nearest_solution(
    robot: RobotLike,
    T_sd: ArrayLike,
    q0: ArrayLike | None = None,
    *,
    frame: str | None = None,
    task: Task = "pose",
) -> IKResult:
    """The solution nearest to `q0` for each pose, checked by forward kinematics.

    1. Of an arm without redundant joints all solutions are found; the start is the nearest within the limits, wound.
    2. Of a redundant arm the start is `q0`, which is also the preferred configuration of its self-motion.
    3. Damped least squares confirm the start, or go on from it.

    Args:
        robot: a Robot, a Mechanism, a name of the library or a file.
        T_sd: (*batch, 4, 4) desired poses in {s}.
        q0: (n,) or (*batch, n) configuration [rad | m]; the middle of the limits if None.
        frame: name of a link; the tip if None.
        task: `pose`, `position` or `axis`.

    Raises:
        InputError: a wrong shape, no pose, an unknown task.
        ModelError: an unknown frame, a robot with loops.
    """
    arm = as_robot(robot)
    require_task(task)
    known = setting(arm, frame, task)
    if known.arm.locked:
        return solve_ik(arm, T_sd, q0, frame=frame, task=task, q_preferred=q0)
    start = known.part.middle if q0 is None else as_batch("q0", q0, (arm.n,), finite=True)
    return solve_ik(arm, T_sd, _nearest_of_all(arm, T_sd, start, frame, task), frame=frame, task=task)


def _nearest_of_all(arm: Robot, T_sd: ArrayLike, q0: JointVector, frame: str | None, task: Task) -> JointVector:
    """(*batch, n) the nearest of all solutions, free joints at `q0`; `q0` itself where there is none."""
    answer = inverse_kinematics(arm, T_sd, frame=frame, task=task)
    if isinstance(answer, SolutionSet):
        if answer.free.any():
            answer = cast("SolutionSet", inverse_kinematics(arm, T_sd, frame=frame, task=task, q0=q0))
        return answer.nearest(q0) if len(answer) else q0
    nearest = answer.nearest(q0)
    nearest = np.where(np.isnan(nearest), q0, nearest)
    poses, starts = np.asarray(T_sd, dtype=np.float64), np.broadcast_to(q0, nearest.shape)
    for row in map(tuple, np.argwhere((answer.free != 0).any(axis=-1)).tolist()):
        nearest[row] = _nearest_of_all(arm, poses[row], starts[row], frame, task)
    return nearest
