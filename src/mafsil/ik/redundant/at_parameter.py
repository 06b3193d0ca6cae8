"""The solution set of an arm with seven coordinates whose free parameter is given, or chosen."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import isfinite

import numpy as np

from mafsil.arrays import Floats, JointVector, PoseMatrix, as_batch
from mafsil.errors import InputError
from mafsil.ik.answers.branch import UNNAMED
from mafsil.ik.answers.candidate_table import without_branch
from mafsil.ik.answers.question import LOOSE, Question
from mafsil.ik.answers.search import Search, Start
from mafsil.ik.answers.setting import CLEAR, Setting
from mafsil.ik.answers.solution_set import SolutionSet
from mafsil.ik.redundant.form import ARM_ANGLE, Redundancy, redundancy
from mafsil.ik.redundant.parameter_search import beyond_sphere
from mafsil.ik.refine import distinct, refine_rows, wound_near
from mafsil.ik.result import ORTHOGONALITY, IKStatus, clean_poses, printed_pose
from mafsil.ik.tolerances import AT_LIMIT, INWARDS, NEARLY_REACHED, ON_LIMIT
from mafsil.kernels.lazy import preset

TRIED = 24
"""Values of the locked joint that are tried before limits are asked."""

BESIDE = 2
"""How many of those are tried beside the value that a search found."""

_NO_ROW, _NO_NAME, _NO_FREE = np.full(16, -1), np.full(16, UNNAMED), np.zeros(16, dtype=np.int64)


def with_parameter(setting: Setting, T: PoseMatrix, free: float | Mapping[str, float], tolerance: float) -> SolutionSet:
    """All solutions of one pose with the free parameter fixed, each the member of a continuum.

    Args:
        setting: an arm with seven coordinates, task `pose`.
        T: (4, 4) desired pose in {s}, perhaps with small errors of its rotation.
        free: value of the parameter that the arm is counted by, or {name: value} of the `arm angle` or a joint [rad].
        tolerance: largest residual of a solution [rad | m].

    Raises:
        InputError: no such parameter, or not one value.
    """
    if setting.task != "pose":
        raise InputError("redundant.only_pose", task=setting.task)
    name, value = (None, free) if type(free) is float and isfinite(free) else _name(free)
    form = redundancy(setting.robot, name)
    answer = _regular(setting, form, T, value, tolerance)
    return solve_known_form(setting, form, _pose(T), value, tolerance) if answer is None else answer


def _name(free: float | Mapping[str, float]) -> tuple[str | None, float]:
    """Name of the parameter, None for that by which the arm is counted, and its value."""
    if isinstance(free, Mapping) and len(free) != 1:
        raise InputError("redundant.one_value", names=", ".join(map(str, free)))
    name, given = next(iter(free.items())) if isinstance(free, Mapping) else (None, free)
    value = as_batch("free", given, (), finite=True)
    if value.ndim:
        raise InputError("input.shape", name="free", expected="()", got=value.shape, hint="")
    return name, float(value)


def _pose(T: PoseMatrix) -> PoseMatrix:
    """The pose with its rotation at working precision."""
    clean, valid = clean_poses(T[None])
    return clean[0] if valid[0] else printed_pose("T_sd", T)


def _regular(setting: Setting, form: Redundancy, T: PoseMatrix, value: float, tolerance: float) -> SolutionSet | None:
    """The branches at a value of the parameter where none needs refinement, by one kernel; None elsewhere."""
    if form.regular is None or tolerance < CLEAR:
        return None
    near, turns = setting.middle, setting.middle_turns
    q, details, summary = form.regular.solutions.call(T, np.array([value]), near, turns, *setting.bounds, tolerance)
    defect, doubtful, _, excess = summary.tolist()
    if doubtful or not defect <= ORTHOGONALITY:
        return None
    good = details[:, 0] <= CLEAR
    q, chosen = q[good], details[good]
    if form.locked >= 0:
        near = near.copy()
        near[form.locked] = value
    k = len(q)
    answer = SolutionSet(
        Question(setting, T.copy(), near, tolerance),
        q,
        chosen[:, 0],
        chosen[:, 3] <= ON_LIMIT,
        _NO_ROW[:k],
        _NO_NAME[:k],
        _NO_FREE[:k],
        method="closed form",
        complete=False,
        isolated=False,
    )
    if excess <= ON_LIMIT:
        preset(answer, status=IKStatus.CONTINUUM)
    return answer


def answer_at(question: Question) -> SolutionSet:
    """The answer to a question; of seven coordinates without an exact closed form the locked joint is sought with care.

    Args:
        question: to any arm.
    """
    setting, arm = question.setting, question.setting.arm
    if arm.form is None and question.tolerance <= LOOSE and beyond_sphere(setting, question.T[None], LOOSE)[0]:
        # Proven before anything is searched.
        preset(question, start=Start(question.q0, refuted=True, unreachable=True))
        return question.answer()
    if arm.form is not None or arm.general is not None:
        answer = question.answer()
        if answer.within.any() or len(arm.locked) != 1 or question.setting.holds_one:
            return answer
        other = try_locked(question)
        return other if other is not None and other.within.any() else answer
    other = try_locked(question)
    return question.answer() if other is None else other


def try_locked(question: Question) -> SolutionSet | None:
    """Solutions of an arm with seven coordinates whose others are solved once one is locked; None where there are none.

    The locked joint is at `near`, or where a search finds a solution within the limits, or at the nearest of some
    values that leads to such. Where none does, configurations with another joint at one of its limits are sought: the
    configurations within the limits end there.

    Args:
        question: to any arm.
    """
    setting = question.setting
    chain = setting.arm.chain
    if setting.task != "pose" or chain is None or len(chain) != 7:
        return None
    form = redundancy(setting.robot)
    best: SolutionSet | None = None
    for value in _values(question, form):
        answer = solve_known_form(
            setting, form, question.T, value, question.tolerance, question.others, question.search
        )
        if answer.within.any():
            return answer
        best = answer if len(answer.q) and best is None else best
    return best


def _values(question: Question, form: Redundancy) -> Iterator[float]:
    """Values of the locked joint, the preferred one first, those beside configurations at limits last."""
    setting, T, near = question.setting, question.T, float(question.q0[form.locked])
    yield near
    values = form.spread(TRIED)
    found, _ = question.search.within_limits()
    if len(found):
        # The same values for all poses: constants of their eliminations are known after a few poses.
        value = float(form.value(found[0]))
        yield from values[np.argsort(np.abs(values - value), kind="stable")][:BESIDE]
        yield value
    yield from values[np.argsort(np.abs(values - near), kind="stable")]
    ends = np.unique(_at_limits(setting, form, T))
    if len(ends):
        beside = (ends[:, None] + np.concatenate([INWARDS, -INWARDS])).reshape(-1)
        values = np.concatenate([(ends[1:] + ends[:-1]) / 2, beside])
        values = values[(values >= setting.lower[form.locked]) & (values <= setting.upper[form.locked])]
        yield from values[np.argsort(np.abs(values - near), kind="stable")]


def _at_limits(setting: Setting, form: Redundancy, T: PoseMatrix) -> Floats:
    """(k,) values of the locked joint of configurations with one joint at a limit and the others within theirs."""
    found: list[Floats] = []
    for joint, limit, method in form.limited:
        others = method.solve(T)
        q = np.insert(others, joint, limit, axis=1)
        q = wound_near(q, setting.middle, setting.lower, setting.upper, setting.revolute)
        q[:, joint] = limit
        allowed = (q >= setting.lower - AT_LIMIT) & (q <= setting.upper + AT_LIMIT)
        found.append(q[allowed.all(axis=1), form.locked])
    return np.concatenate(found) if found else np.zeros(0)


def solve_known_form(
    setting: Setting,
    form: Redundancy,
    T: PoseMatrix,
    value: float,
    tolerance: float,
    others: JointVector | None = None,
    search: Search | None = None,
) -> SolutionSet:
    """The same for a form that is known.

    Args:
        setting: the arm.
        form: how its configurations are counted.
        T: (4, 4) desired pose in {s}.
        value: of the parameter [rad].
        tolerance: largest residual of a solution [rad | m].
        others: coordinates of the whole robot, where joints that do not move the frame are.
        search: what was tried before.
    """
    found = form.solve(T, np.array([value]))
    q = found.q[0][found.residual[0] <= NEARLY_REACHED]
    locked = (form.locked,) if form.parameter != ARM_ANGLE else ()
    q, residual = refine_rows(setting.robot, q, T, setting.mask, locked=locked)
    good = np.flatnonzero(residual <= tolerance)
    q, residual = q[good], residual[good]
    kept = distinct(q, setting.revolute)
    q, residual = q[kept], residual[kept]
    near = setting.middle.copy()
    if locked:
        near[form.locked] = value
    allowed = (q >= setting.lower - ON_LIMIT) & (q <= setting.upper + ON_LIMIT)
    within = np.asarray(allowed.all(axis=1), dtype=np.bool_)
    rows = without_branch(q)
    method = "elimination" if form.closed is None and form.angle_form is None else "closed form"
    question = Question(setting, T, near, tolerance, others, search)
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
