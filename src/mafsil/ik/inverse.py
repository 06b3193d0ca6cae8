"""Inverse kinematics with all solutions: one call for one pose or for whole batches."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import PoseMatrix, gate, positive, single
from mafsil.errors import InputError
from mafsil.ik.analysis import Task
from mafsil.ik.answers.batch import SolutionBatch, solved_batch
from mafsil.ik.answers.question import FOLD, Question
from mafsil.ik.answers.redundant_single import redundant_single
from mafsil.ik.answers.setting import BENT, CLEAR, MASKS, Setting, setting
from mafsil.ik.answers.solution_set import SolutionSet
from mafsil.ik.problem import ORTHOGONALITY, clean_poses
from mafsil.ik.redundant.fixed import answered, with_parameter
from mafsil.ik.redundant.parametric_form import has_redundant_joints
from mafsil.ik.refine import distinct
from mafsil.model.loading import RobotLike
from mafsil.robot import Robot, as_robot

APART = 1e-4
"""Marks above which branches are distinct and isolated."""


def inverse_kinematics(
    robot: RobotLike,
    T_sd: ArrayLike,
    *,
    frame: str | None = None,
    task: Task = "pose",
    near: ArrayLike | None = None,
    free: float | Mapping[str, float] | None = None,
    tolerance: float = 1e-9,
) -> SolutionSet | SolutionBatch:
    """All joint vectors that bring the tip to a pose, or to each pose of a batch.

    Joints that do not move the frame, such as those of a gripper, are no unknowns.

    Args:
        robot: any arm, a Mechanism, a name of the library or a file.
        T_sd: (4, 4) wanted pose in {s}, or (*batch, 4, 4).
        frame: name of a link; the tip if None.
        task: `pose`, `position` only, or `axis`: position and direction of the tip's z axis.
        near: (n,) values that free joints, held joints of redundant arms and joints that do not move the frame take;
            the middle of their limits if None.
        free: of arms with seven coordinates and one pose: value of their free parameter, or {name: value} of the
            `arm angle` or of a joint; see `redundancy`.
        tolerance: largest residual [m | rad] of a solution. Arms with fewer joints than the task has equations meet a
            rounded pose in the sense of least squares; other arms the nearest posture where there is no exact one.

    Returns:
        For one pose a `SolutionSet`: solutions with branches, families and reasons; where `complete` is set there are
        no others. A redundant arm (more joints than the task needs) gets the solutions with the held joints at `near`,
        each the member of a family. For a batch a `SolutionBatch`: padded arrays, and a `SolutionSet` by index.

    Raises:
        InputError: a wrong shape, no pose, an unknown task, a tolerance that is not positive.
        ModelError: an unknown frame.
    """
    known = type(task) is str and task in MASKS
    if type(T_sd) is np.ndarray and T_sd.shape == (4, 4) and known and type(robot) is Robot:
        asked = setting(robot, frame, task)
        if near is None and T_sd.dtype == np.float64 and type(tolerance) is float and CLEAR <= tolerance < np.inf:
            if free is not None:
                return with_parameter(asked, T_sd, free, tolerance)
            if asked.kernel is not None:
                return _quick(asked, T_sd, tolerance)
            if has_redundant_joints(asked):
                return redundant_single(asked, T_sd, asked.middle, tolerance)
    robot = as_robot(robot)
    if not known:
        raise InputError("input.choice", name="task", value=task, known=", ".join(MASKS))
    tolerance = positive("tolerance", tolerance)
    wanted = gate("T_sd", T_sd, (4, 4))
    asked = setting(robot, frame, task)
    others = asked.part.middle if near is None else single("near", near, (robot.n,))
    start = asked.part.own(others)
    if wanted.ndim > 2:
        if free is not None:
            raise InputError("redundant.one_pose", shape=wanted.shape)
        return solved_batch(asked, wanted, others, tolerance)
    if free is None and has_redundant_joints(asked):
        return redundant_single(asked, wanted, start, tolerance, others)
    if free is not None:
        return with_parameter(asked, wanted, free, tolerance)
    clean, valid = clean_poses(wanted[None])
    if not valid[0]:
        raise _no_pose()
    return answered(Question(asked, clean[0], start, tolerance, others))


def _no_pose() -> InputError:
    return InputError("ik.no_pose", name="T_sd", limit=ORTHOGONALITY)


def _quick(asked: Setting, T: PoseMatrix, tolerance: float) -> SolutionSet:
    """The rows of the closed form as they are, where all solutions are distinct, isolated and exact; else with care."""
    kernel = asked.kernel
    assert kernel is not None
    q, facts, defect = kernel.call(T, asked.middle, asked.middle_turns, *asked.bounds)
    if not defect <= ORTHOGONALITY:
        raise _no_pose()
    residual = facts[:, 0]
    good = residual <= CLEAR
    chosen = facts[good]
    clear = len(chosen) and asked.plain and not ((residual <= asked.candidate) & ~good).any()
    clear = clear and not (asked.quartic and facts[:, 4].min() <= FOLD)
    least = chosen[:, 4].min() if clear else 0.0
    if clear and asked.quartic:
        # Where the equation is of lower degree the table repeats roots.
        clear = len(distinct(q[good], asked.turning)) == len(chosen)
        least = least if clear else 0.0
    if least < APART or chosen[:, 2].any() or (least < BENT and asked.folded(facts).any()):
        clean, valid = clean_poses(T[None])
        if not valid[0]:
            raise _no_pose()
        return Question(asked, clean[0], asked.middle, tolerance).answer()
    return SolutionSet(
        Question(asked, T, asked.middle, tolerance),
        q[good],
        chosen[:, 0],
        chosen[:, 5] <= 1e-12,
        good.nonzero()[0],
        chosen[:, 3].astype(np.int64),
        np.zeros(len(chosen), dtype=np.int64),
        method="closed form",
        complete=True,
        isolated=True,
    )
