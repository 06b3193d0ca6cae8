"""All solutions of many poses of a general arm at once, where elimination proves the lists."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Booleans, Floats, JointVector, PoseMatrix
from mafsil.ik.answers.branch import UNNAMED
from mafsil.ik.answers.pose_question import PoseQuestion
from mafsil.ik.answers.setting import CLEAR, Setting
from mafsil.ik.answers.solution_set import SolutionSet
from mafsil.lazy_module import lazily

if TYPE_CHECKING:
    import mafsil.ik.general.judging_loops as judging_loops
    from mafsil.ik.general import GeneralSix, GeneralSolutions
else:
    judging_loops = lazily("mafsil.ik.general.judging_loops")

ROWS = 4096
"""Solutions whose poses are kept at once."""


class Eliminated(NamedTuple):
    """Lists of solutions.

    Attributes:
        sure: (k,) whether a list is proven and needs no second look; the others hold nothing.
        q: (k, most, n) solutions in front, then NaN.
        residual: (k, most) their errors, the larger of distance and angle.
        codes: (k, most) their branches as numbers; None where they have no names.
        found: what elimination found, also of lists that are not proven; None where it was not asked for all poses.
    """

    sure: NDArray[np.bool_]
    q: JointVector
    residual: Floats
    codes: NDArray[np.int64] | None = None
    found: GeneralSolutions | None = None


def eliminate_poses(setting: Setting, general: GeneralSix, T: PoseMatrix, q0: JointVector) -> Eliminated:
    """What elimination proves of many poses.

    Args:
        setting: the arm.
        general: its elimination.
        T: (k, 4, 4) poses; rows that are none are not sure.
        q0: (n,) values to which angles are wound.
    """
    found = general.solve_all(T)
    listed: Booleans = np.asarray(np.arange(found.q.shape[1]) < found.count[:, None], dtype=np.bool_)
    row, place = np.nonzero(listed)
    q, residual = np.full(found.q.shape, np.nan), np.full(found.q.shape[:2], np.nan)
    sure = found.complete & (found.count > 0)
    for begin in range(0, len(row), ROWS):
        rows, places = row[begin : begin + ROWS], place[begin : begin + ROWS]
        solutions = found.q[rows, places]
        q[rows, places], residual[rows, places], _ = _judged(setting, solutions, T, rows, q0)
    sure &= ~(residual > CLEAR).any(axis=1)
    q[~sure], residual[~sure] = np.nan, np.nan
    return Eliminated(sure, q, residual, None, found)


def proven_set(question: PoseQuestion, found: GeneralSolutions) -> SolutionSet | None:
    """The complete list of one pose; None where it is not proven, or empty.

    Args:
        question: to an arm without a closed form.
        found: what elimination found.
    """
    count = int(found.count)
    if not found.complete or not count:
        return None
    T, none = question.T[None], np.zeros(count, dtype=np.int64)
    q, residual, within = _judged(question.setting, found.q[:count].copy(), T, none, question.q0)
    if residual.max() > CLEAR:
        return None
    rest = within, none - 1, none + UNNAMED, none
    return SolutionSet(question, q, residual, *rest, method="elimination", complete=True, isolated=False)


def _judged(
    setting: Setting, q: JointVector, T: PoseMatrix, rows: NDArray[np.int64], q0: JointVector
) -> tuple[JointVector, Floats, NDArray[np.bool_]]:
    """Solutions (m, n) wound in place, their errors (m,) by forward kinematics, and which are within the limits (m,).

    Args:
        setting: the arm.
        q: (m, n) solutions; changed.
        T: (k, 4, 4) poses.
        rows: (m,) which of them each solution belongs to.
        q0: (n,) values to which angles are wound.
    """
    residual, within = np.empty(len(q)), np.empty(len(q), dtype=np.bool_)
    reached = setting.robot.forward_kinematics(q)
    judging_loops.judge_solutions(
        reached, T, rows, q0, setting.lower, setting.upper, setting.revolute, q, residual, within
    )
    return q, residual, within
