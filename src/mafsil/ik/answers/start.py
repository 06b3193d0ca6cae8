"""Where free and held joints stand: the values that are preferred, or the nearest that lead to solutions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import JointVector, PoseMatrix
from mafsil.ik.answers.setting import Setting, bits
from mafsil.ik.answers.solution_set import wound_near
from mafsil.ik.closed_form import Branches, ClosedForm

SCAN = 24
"""Values of a free or held joint that are tried where the preferred one leads nowhere."""


@dataclass(frozen=True, eq=False)
class Start:
    """Values of free and held joints.

    Attributes:
        near: (n,) of which only those count.
        refuted: whether it is proven that no value of the held joint leads to a solution within the limits.
        unreachable: whether it is proven that none leads to any.
    """

    near: JointVector
    refuted: bool = False
    unreachable: bool = False


def start_of(setting: Setting, form: ClosedForm, T: PoseMatrix, near: JointVector, tolerance: float) -> Start:
    """The preferred values, or the nearest that lead to solutions within the limits, or else to any.

    Args:
        setting: the arm.
        form: its closed form.
        T: (4, 4) wanted pose.
        near: (n,) preferred values.
        tolerance: largest residual of a solution.
    """
    from mafsil.ik.redundant.parameter_search import parameter_values
    from mafsil.ik.redundant.parametric_form import has_redundant_joints, parametric_form

    most = setting.candidate
    if has_redundant_joints(setting):
        # A row that almost solves the pose at one value of a held joint is not made a solution by refinement.
        form_of_arm = parametric_form(setting)
        found = parameter_values(setting, form_of_arm, T[None], near, min(tolerance, most))
        moved = near.copy()
        moved[form_of_arm.joints] = found.values[0]
        return Start(moved, bool(found.refuted[0]), bool(found.unreachable[0]))
    arm, table = setting.arm, form.solve(T, near)
    if (not arm.held and not table.free.any()) or _allowed(setting, near, table, most).any():
        return Start(near)
    changed = arm.held if arm.held else bits(int(table.free.max()), setting.robot.n)
    if not changed:
        return Start(near)
    generator = np.random.default_rng(0)
    tries = np.repeat(near[None], SCAN * 8 ** min(len(changed) - 1, 2), axis=0)
    for j in changed:
        low, high = max(setting.lower[j], -np.pi), min(setting.upper[j], np.pi)
        tries[:, j] = (
            np.linspace(low, high, len(tries)) if len(changed) == 1 else generator.uniform(low, high, len(tries))
        )
    found = form.solve(T, tries)
    count = _allowed(setting, near, found, most).sum(axis=1)
    if not count.max():
        if (table.residual <= setting.candidate).any():
            return Start(near)
        count = (found.residual <= setting.candidate).sum(axis=1)
    return Start(tries[int(np.where(count == count.max(), -np.abs(tries - near).max(axis=1), -np.inf).argmax())])


def _allowed(setting: Setting, near: JointVector, table: Branches, most: float) -> NDArray[np.bool_]:
    """(*batch, branches) which rows are solutions within the limits."""
    low, high = setting.lower, setting.upper
    q = wound_near(table.q, near, low, high, setting.turning)
    return (table.residual <= most) & ((q >= low) & (q <= high)).all(axis=-1)
