"""Starts that leave nothing to chance: the solutions of an arm's closed form, asked before a search gives up."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats, JointVector
from mafsil.ik.numerical.problem import PoseProblem
from mafsil.ik.numerical.task import PoseTask
from mafsil.ik.structure.analysis import analysis
from mafsil.ik.tolerances import NEARLY_REACHED

TURN = 2.0 * np.pi


def exact_starts(problem: PoseProblem, task: PoseTask, T_sd: Floats, near: JointVector) -> JointVector | None:
    """Solutions of the arm's own closed form within the limits, the nearest first.

    Args:
        problem: the frame and its bounds.
        task: what counts.
        T_sd: (k, 16) clean poses.
        near: (k, n) or (1, n) what they are to be near to.

    Returns:
        (k, branches, n), NaN where there are fewer; None where the arm has no closed form for this task.
    """
    whole_pose = task.kind == "pose" and task.dimension == 6
    if problem.frame is not None or not whole_pose or problem.robot.mechanism.loops:
        return None
    arm = analysis(problem.robot.mechanism)
    if arm.form is None or not arm.exact or arm.locked:
        return None
    branches = arm.form.solve(T_sd.reshape(-1, 4, 4))
    q, revolute = branches.q, problem.revolute == 1
    # Angles come within half a turn of zero: first near to the given, then up or down into the bounds.
    q = q - np.where(revolute, TURN * np.round((q - near[:, None]) / TURN), 0.0)
    q = q + np.where(revolute & (q < problem.lower), TURN * np.ceil((problem.lower - q) / TURN - NEARLY_REACHED), 0.0)
    q = q - np.where(revolute & (q > problem.upper), TURN * np.ceil((q - problem.upper) / TURN - NEARLY_REACHED), 0.0)
    fits = (q >= problem.lower - NEARLY_REACHED) & (q <= problem.upper + NEARLY_REACHED)
    good = fits.all(axis=-1) & (branches.residual <= NEARLY_REACHED)
    far = np.where(good, np.abs(q - near[:, None]).max(axis=-1), np.inf)
    order = np.argsort(far, axis=1, kind="stable")
    q[~good] = np.nan
    return np.take_along_axis(q, order[..., None], axis=1)
