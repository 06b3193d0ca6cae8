"""Batches for arms without closed form or elimination: one solution for every pose, sought for all of them at once."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.ik.answers.branch import UNNAMED
from mafsil.ik.answers.question import SELF_MOTION, Question
from mafsil.ik.answers.redundant_batch import BatchRows, finite_poses
from mafsil.ik.answers.search import RESTARTS, SEARCHES
from mafsil.ik.answers.setting import Setting
from mafsil.ik.refine import pose_errors, refine_rows, residuals, wound_near
from mafsil.ik.result import IKStatus, clean_poses
from mafsil.lazy_module import lazily

if TYPE_CHECKING:
    import mafsil.ik.numerical as numerical
else:
    numerical = lazily("mafsil.ik.numerical")

SAMPLES = 16
"""Random configurations from which the rank of the Jacobian at regular ones is read."""

CHUNK = 4096
"""Poses that are worked on at once."""


def is_search_only(setting: Setting) -> bool:
    """Whether nothing better than a search is known of the arm: no closed form, no elimination of all joints or six."""
    arm = setting.arm
    eliminated = setting.task == "pose" and arm.chain is not None and len(arm.chain) == 7
    return arm.chain is not None and arm.form is None and arm.general is None and not eliminated


def search_batch(setting: Setting, T: PoseMatrix, q0: JointVector, tolerance: float) -> tuple[NDArray[Any], ...]:
    """For every pose a solution within the limits, if one is found; the other poses are answered one by one.

    For each chunk of poses:

    1. A solution within the limits is sought by the search with which the single answer begins.
    2. It is brought to working precision where that leaves no limit.
    3. Where the Jacobian has the rank of regular configurations, less than the number of joints, the solution is the
       member of a continuum (constant rank theorem); with as many joints it is isolated.
    4. Other poses are answered one by one: not found so, or at a singular configuration.

    Args:
        setting: an arm without closed form and without elimination.
        T: (k, 4, 4) poses; rows that are no poses get `NOT_A_POSE`.
        q0: (n,) values to which angles are wound.
        tolerance: largest residual of a solution.

    Returns:
        As `redundant_batch`, one row for every pose where no careful answer has more.
    """
    clean, valid = clean_poses(finite_poses(T))
    n = setting.robot.n
    verdict = IKStatus.CONTINUUM if regular_rank(setting) < n else IKStatus.SOLVED
    q, residual, sure = np.full((len(T), n), np.nan), np.full(len(T), np.nan), np.zeros(len(T), dtype=np.bool_)
    for begin in range(0, len(T), CHUNK):
        part = begin + np.flatnonzero(valid[begin : begin + CHUNK])
        # 1. and 2.
        found, residual[part] = sought_within_limits(setting, clean[part], tolerance)
        q[part] = wound_near(found, q0, setting.lower, setting.upper, setting.revolute)
        # 3.
        solved = (residual[part] <= tolerance) & setting.within_limits(q[part])
        sure[part[solved]] = regular(setting, q[part[solved]])
    # 4.
    careful = {int(i): Question(setting, clean[i], q0, tolerance).answer() for i in np.flatnonzero(valid & ~sure)}
    out = BatchRows(len(T), max([int(sure.any()), *map(len, careful.values())]), n)
    out.codes[:] = UNNAMED
    if sure.any():
        out.q[sure, 0], out.residual[sure, 0] = q[sure], residual[sure]
        out.valid[sure, 0] = out.within[sure, 0] = True
        out.set_status(sure, verdict)
    for i, answer in careful.items():
        out.write(i, answer)
    return out.columns


def sought_within_limits(setting: Setting, T: PoseMatrix, tolerance: float) -> tuple[JointVector, Floats]:
    """Solutions within the limits as `Search.within_limits` finds them for one pose.

    Args:
        setting: any arm.
        T: (k, 4, 4) poses.
        tolerance: largest residual of a solution.

    Returns:
        (k, n) coordinates and (k,) residuals, NaN where none is found.
    """
    robot, mask = setting.robot, setting.mask
    q, residual = np.full((len(T), robot.n), np.nan), np.full(len(T), np.nan)
    for seed in range(SEARCHES // 2):
        rows = np.flatnonzero(np.isnan(residual))
        if not len(rows):
            break
        found = numerical.solve_ik(robot, T[rows], task=setting.task, tolerance=tolerance, restarts=RESTARTS, seed=seed)
        start, rows = found.nearest[found.solved], rows[found.solved]
        before = residuals(pose_errors(robot, start, T[rows], mask))
        better, after = refine_rows(robot, start, T[rows], mask)
        kept = setting.within_limits(better) & (after <= before)
        q[rows], residual[rows] = np.where(kept[:, None], better, start), np.where(kept, after, before)
    return q, residual


def regular(setting: Setting, q: JointVector) -> NDArray[np.bool_]:
    """(k,) at which configurations (k, n) the Jacobian of the task has the rank that it has at random ones."""
    if not len(q):
        return np.zeros(0, dtype=np.bool_)
    return _ranks(setting, q) == regular_rank(setting)


@lru_cache(maxsize=128)
def regular_rank(setting: Setting) -> int:
    """The largest rank that the Jacobian of the task has at random configurations."""
    return int(_ranks(setting, np.random.default_rng(0).uniform(-np.pi, np.pi, (SAMPLES, setting.robot.n))).max())


def _ranks(setting: Setting, q: JointVector) -> NDArray[np.int64]:
    values = np.linalg.svd(setting.scaled_jacobians(q), compute_uv=False)
    return (values > SELF_MOTION * values[:, :1]).sum(axis=1)
