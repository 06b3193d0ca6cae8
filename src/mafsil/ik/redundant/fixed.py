"""The solution set of a seven-joint arm whose free parameter is given."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from mafsil.arrays import JointVector, PoseMatrix, gate
from mafsil.errors import InputError
from mafsil.ik.answers.question import Question
from mafsil.ik.answers.rows import unlabelled
from mafsil.ik.answers.setting import Setting
from mafsil.ik.answers.solution_set import SolutionSet
from mafsil.ik.redundant.form import ARM_ANGLE, Redundancy, redundancy
from mafsil.ik.refine import distinct, refined

TRIED = 12
"""Values of the held joint that are tried where the preferred one leads nowhere."""


def with_parameter(setting: Setting, T: PoseMatrix, free: float | Mapping[str, float], tolerance: float) -> SolutionSet:
    """All solutions of one pose with the free parameter fixed, each the member of a continuum.

    Args:
        setting: an arm of seven turning joints, task `pose`.
        T: (4, 4) wanted pose in {s}.
        free: value of the parameter that the arm is counted by, or {name: value} of the `arm angle` or a joint [rad].
        tolerance: largest residual of a solution [rad | m].

    Raises:
        InputError: no such parameter, or not one value.
    """
    if setting.task != "pose":
        raise InputError("redundant.only_pose", task=setting.task)
    if isinstance(free, Mapping) and len(free) != 1:
        raise InputError("redundant.one_value", names=", ".join(map(str, free)))
    name, given = next(iter(free.items())) if isinstance(free, Mapping) else (None, free)
    form, value = redundancy(setting.robot, name), gate("free", given, (), finite=True)
    if value.ndim:
        raise InputError("input.shape", name="free", expected="()", got=value.shape, hint="")
    return fixed(setting, form, T, float(value), tolerance)


def tried(setting: Setting, T: PoseMatrix, near: JointVector, tolerance: float) -> SolutionSet | None:
    """Solutions of an arm of seven turning joints, none of which leaves a closed form; None of another arm.

    The held joint is at `near`, or at the nearest of `TRIED` values that leads to solutions.

    Args:
        setting: the arm.
        T: (4, 4) wanted pose in {s}.
        near: (7,) preferred values [rad].
        tolerance: largest residual of a solution [rad | m].
    """
    chain = setting.arm.chain
    if setting.task != "pose" or chain is None or len(chain) != 7 or any(chain.slides):
        return None
    form = redundancy(setting.robot)
    values = form.spread(TRIED)
    best: SolutionSet | None = None
    for value in [near[form.held], *values[np.argsort(np.abs(values - near[form.held]))]]:
        answer = fixed(setting, form, T, float(value), tolerance)
        if answer.within.any():
            return answer
        best = answer if len(answer.q) and best is None else best
    return best


def fixed(setting: Setting, form: Redundancy, T: PoseMatrix, value: float, tolerance: float) -> SolutionSet:
    """The same for a form that is known.

    Args:
        setting: the arm.
        form: how its postures are counted.
        T: (4, 4) wanted pose in {s}.
        value: of the parameter [rad].
        tolerance: largest residual of a solution [rad | m].
    """
    found = form.solve(T, np.array([value]))
    q = found.q[0][found.residual[0] <= 1e-5]
    held = (form.held,) if form.parameter != ARM_ANGLE else ()
    q, residual = refined(setting.robot, q, T, setting.mask, None, held=held)
    good = np.flatnonzero(residual <= tolerance)
    q, residual = q[good], residual[good]
    kept = distinct(q, setting.turning)
    q, residual = q[kept], residual[kept]
    near = setting.middle.copy()
    if held:
        near[form.held] = value
    allowed = (q >= setting.lower - 1e-12) & (q <= setting.upper + 1e-12)
    within = np.asarray(allowed.all(axis=1), dtype=np.bool_)
    rows = unlabelled(q)
    method = "elimination" if form.closed is None and form.angle_form is None else "closed form"
    question = Question(setting, T, near, tolerance)
    return SolutionSet(
        question,
        q,
        residual,
        within,
        rows.rows,
        rows.codes,
        rows.free,
        method=method,
        complete=False,
        isolated=False,
    )
