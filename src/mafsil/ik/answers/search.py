"""Solutions of one pose by searches from many starts: they prove nothing, and they count what they tried.

Where free and locked joints stand: the values that are preferred, or the nearest that lead to solutions.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.ik.answers.setting import Setting, bits
from mafsil.ik.refine import pose_errors, refine_rows, residuals, wound_near
from mafsil.ik.structure.closed_form import Branches, ClosedForm
from mafsil.ik.tolerances import SELF_MOTION
from mafsil.lazy_module import lazily

if TYPE_CHECKING:
    import mafsil.ik.numerical as numerical
    import mafsil.ik.redundant.parameter_search as parameter_search
    import mafsil.ik.redundant.parametric_form as redundant_parametric_form
else:
    numerical = lazily("mafsil.ik.numerical")
    parameter_search = lazily("mafsil.ik.redundant.parameter_search")
    redundant_parametric_form = lazily("mafsil.ik.redundant.parametric_form")


SCAN = 24
"""Values of a free or locked joint that are tried where the preferred one leads nowhere."""
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
        q, residual = refine_rows(setting.robot, q, self.T, setting.mask, steps=60)
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
        before = residuals(pose_errors(setting.robot, q, self.T, setting.mask))
        better, after = refine_rows(setting.robot, q, self.T, setting.mask)
        kept = setting.within_limits(better) & (after <= before)
        return np.where(kept[:, None], better, q), np.where(kept, after, before)


@dataclass(frozen=True, eq=False)
class Start:
    """Values of free and locked joints.

    Attributes:
        q0: (n,) of which only those count.
        refuted: whether it is proven that no value of the locked joint leads to a solution within the limits.
        unreachable: whether it is proven that none leads to any.
    """

    q0: JointVector
    refuted: bool = False
    unreachable: bool = False


def start_of(setting: Setting, form: ClosedForm, T: PoseMatrix, q0: JointVector, tolerance: float) -> Start:
    """The preferred values, or the nearest that lead to solutions within the limits, or else to any.

    Args:
        setting: the arm.
        form: its closed form.
        T: (4, 4) requested pose.
        q0: (n,) preferred values.
        tolerance: largest residual of a solution.
    """
    most = setting.candidate
    if redundant_parametric_form.has_redundant_joints(setting):
        # A row that almost solves the pose at one value of a locked joint is not made a solution by refinement.
        form_of_arm = redundant_parametric_form.parametric_form(setting)
        found = parameter_search.parameter_values(setting, form_of_arm, T[None], q0, min(tolerance, most))
        moved = q0.copy()
        moved[form_of_arm.joints] = found.values[0]
        return Start(moved, bool(found.refuted[0]), bool(found.unreachable[0]))
    arm, table = setting.arm, form.solve(T, q0)
    if (not arm.locked and not table.free.any()) or _allow(setting, q0, table, most).any():
        return Start(q0)
    changed = arm.locked if arm.locked else bits(int(table.free.max()), setting.robot.n)
    if not changed:
        return Start(q0)
    generator = np.random.default_rng(0)
    tries = np.repeat(q0[None], SCAN * 8 ** min(len(changed) - 1, 2), axis=0)
    for j in changed:
        low, high = max(setting.lower[j], -np.pi), min(setting.upper[j], np.pi)
        tries[:, j] = (
            np.linspace(low, high, len(tries)) if len(changed) == 1 else generator.uniform(low, high, len(tries))
        )
    found = form.solve(T, tries)
    count = _allow(setting, q0, found, most).sum(axis=1)
    if not count.max():
        if (table.residual <= setting.candidate).any():
            return Start(q0)
        count = (found.residual <= setting.candidate).sum(axis=1)
    return Start(tries[int(np.where(count == count.max(), -np.abs(tries - q0).max(axis=1), -np.inf).argmax())])


def _allow(setting: Setting, q0: JointVector, table: Branches, most: float) -> NDArray[np.bool_]:
    """(*batch, branches) which rows are solutions within the limits."""
    low, high = setting.lower, setting.upper
    q = wound_near(table.q, q0, low, high, setting.revolute)
    return (table.residual <= most) & ((q >= low) & (q <= high)).all(axis=-1)
