"""Solutions of one pose by searches from many starts: they prove nothing, and they count what they tried."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.ik.answers.setting import Setting
from mafsil.ik.refine import pose_errors, refine_rows, residuals
from mafsil.ik.tolerances import SELF_MOTION
from mafsil.lazy_module import lazily

if TYPE_CHECKING:
    import mafsil.ik.numerical as numerical
else:
    numerical = lazily("mafsil.ik.numerical")

SEARCHES, RESTARTS = 8, 255
"""Searches without limits where nothing better is known, half as many within them, and the restarts of the latter."""

FREE_RESTARTS = 63
"""Restarts of the searches without limits."""

SPREAD = 256
"""Starts without limits where only a part of the pose is asked for."""

REPRESENTATIVES = 8
"""Members of continua that are kept where nothing better than a search is known."""


class Search:
    """The searches for one pose.

    Attributes:
        tried: `starts` within the limits and `free_starts` without, so far.
    """

    def __init__(self, setting: Setting, T: PoseMatrix, tolerance: float) -> None:
        self.setting, self.T, self.tolerance = setting, T, tolerance
        self.tried = {"starts": 0, "free_starts": 0}

    def anywhere(self) -> tuple[JointVector, Floats]:
        """(k, m) solutions and (k,) their residuals, first sought within the limits, then without."""
        inside, size = self.within_limits()
        if len(inside):
            return inside, size
        setting = self.setting
        if setting.task == "pose":
            self.tried["free_starts"] += SEARCHES * (FREE_RESTARTS + 1)
            some = [
                numerical.solve_ik(setting.robot, self.T, limits=False, restarts=FREE_RESTARTS, seed=k)
                for k in range(SEARCHES)
            ]
            q = np.array([one.q for one in some if one.all_solved]).reshape(-1, setting.robot.n)
        else:
            self.tried["free_starts"] += SPREAD
            q = setting.middle + np.random.default_rng(0).uniform(-np.pi, np.pi, (SPREAD, setting.robot.n))
        q, residual = refine_rows(setting.robot, q, self.T, setting.mask, None, steps=60)
        good = np.flatnonzero(residual <= self.tolerance)
        values = np.linalg.svd(setting.scaled_jacobians(q[good]), compute_uv=False)
        if ((values > SELF_MOTION * values[:, :1]).sum(axis=1) < setting.robot.n).all():
            # Each is the member of a continuum: some of them stand for all.
            good = good[:REPRESENTATIVES]
        return q[good], residual[good]

    def within_limits(self) -> tuple[JointVector, Floats]:
        """(k, m) a solution within the limits, if one is found there, and (k,) its residual."""
        setting = self.setting
        for seed in range(SEARCHES // 2):
            self.tried["starts"] += RESTARTS + 1
            one = numerical.solve_ik(
                setting.robot, self.T, task=setting.task, tolerance=self.tolerance, restarts=RESTARTS, seed=seed
            )
            if one.all_solved:
                return self._polish(one.q[None])
        return setting.nothing, np.zeros(0)

    def _polish(self, q: JointVector) -> tuple[JointVector, Floats]:
        """The solution brought to working precision where that leaves no limit."""
        setting = self.setting
        before = residuals(pose_errors(setting.robot, q, self.T, setting.mask, None))
        better, after = refine_rows(setting.robot, q, self.T, setting.mask, None)
        kept = setting.within_limits(better) & (after <= before)
        return np.where(kept[:, None], better, q), np.where(kept, after, before)
