"""Would the arm that was meant have as many solutions? A description of six digits leaves some counts open.

An arm that differs by e = `DESCRIBED` from the one described has its solutions where the pose differs by about e:

1. two solutions that are d apart at a fold, where the Jacobian's least singular value is about d, merge within d^2 ~ e;
2. a row of the closed form that falls short of the pose by s becomes a solution, or two, within s ~ e;
3. an arm that is near to a simpler structure, with too few joints for its task, has other solutions once it is of it.

Arms without a closed form are looked at by 1 alone, and by how far the nearest pose is where none is reached.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mafsil.algebra.tolerance import DESCRIBED, SMALLEST_DIVISOR
from mafsil.arrays import JointVector, PoseMatrix
from mafsil.ik.answers.candidate_table import CandidateTable
from mafsil.ik.answers.setting import CLEAR, Setting, turns_of
from mafsil.ik.structure.analysis import structure_in_doubt

MERGING = float(np.sqrt(DESCRIBED))
"""Singular values, relative to the largest, of solutions that rounding may merge: a double root costs the root."""


def folding(setting: Setting, q: JointVector) -> NDArray[np.bool_]:
    """(k,) whether rounding of the description may merge a solution with another, or take it away.

    Args:
        setting: of the arm.
        q: (k, n) solutions.
    """
    values = np.linalg.svd(setting.scaled_jacobians(q), compute_uv=False)
    least = values[:, min(int(setting.mask.sum()), setting.robot.n) - 1]
    return np.asarray(least <= MERGING * np.maximum(values[:, 0], SMALLEST_DIVISOR), dtype=np.bool_)


def nearly_there(setting: Setting, T: PoseMatrix, q0: JointVector) -> NDArray[np.bool_]:
    """(k,) whether a row of the closed form falls short of a pose by no more than rounding explains.

    Args:
        setting: of the arm.
        T: (k, 4, 4) poses.
        q0: (n,) values that free and locked joints take.
    """
    form = setting.arm.form
    if form is None:
        return np.zeros(len(T), dtype=np.bool_)
    details = CandidateTable.of(form.labelled(T, q0, turns_of(q0), *setting.bounds)[1])
    missing = np.nan_to_num(details.subproblem_residual, nan=np.inf)
    explained = (DESCRIBED + form.pattern.defect) * max(1.0, form.pattern.size)
    return np.asarray(((missing > CLEAR) & (missing <= explained)).any(axis=-1), dtype=np.bool_)


def structure_decides(setting: Setting) -> bool:
    """Whether the count depends on whether the arm is of a simpler structure, which rounding leaves open."""
    open_structure = setting.few or bool(setting.arm.locked) or setting.arm.form is None
    return open_structure and structure_in_doubt(setting.robot, setting.task)
