"""All solutions of many poses of a general arm at once, where elimination proves the lists."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.geometry import pose
from mafsil.ik.answers.setting import CLEAR, Setting
from mafsil.ik.answers.solution_set import wound_near
from mafsil.ik.general import GeneralSix

ROWS = 4096
"""Poses whose errors are held at once."""


class Eliminated(NamedTuple):
    """Lists of solutions.

    Attributes:
        sure: (k,) whether a list is proven and needs no second look; the others hold nothing.
        q: (k, most, n) solutions in front, then NaN.
        residual: (k, most) their errors, the larger of distance and angle.
        codes: (k, most) their branches as numbers; None where they have no names.
    """

    sure: NDArray[np.bool_]
    q: JointVector
    residual: Floats
    codes: NDArray[np.int64] | None = None


def eliminated(setting: Setting, general: GeneralSix, T: PoseMatrix, near: JointVector) -> Eliminated:
    """What elimination proves of many poses.

    Args:
        setting: the arm.
        general: its elimination.
        T: (k, 4, 4) poses; rows that are none are not sure.
        near: (n,) values to which angles are wound.
    """
    found = general.solve_all(T)
    listed = np.arange(found.q.shape[1]) < found.count[:, None]
    residual = np.full(listed.shape, np.nan)
    for begin in range(0, len(T), ROWS):
        part = slice(begin, begin + ROWS)
        residual[part][listed[part]] = _residual(setting, found.q[part], T[part], listed[part])
    close = (residual <= CLEAR) | ~listed
    sure = np.asarray(found.complete & (found.count > 0) & close.all(axis=1), dtype=np.bool_)
    q = wound_near(found.q, near, setting.lower, setting.upper, setting.turning)
    q[~sure], residual[~sure] = np.nan, np.nan
    return Eliminated(sure, q, residual)


def _residual(setting: Setting, q: JointVector, T: PoseMatrix, listed: NDArray[np.bool_]) -> Floats:
    """Errors of the listed solutions, one after another."""
    error = pose.error(setting.robot.forward_kinematics(q[listed]), T[np.nonzero(listed)[0]])
    return np.maximum(np.linalg.norm(error[:, :3], axis=1), np.linalg.norm(error[:, 3:], axis=1))
