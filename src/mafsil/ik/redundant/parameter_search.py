"""Values of redundant joints that lead to solutions: proven of a locked joint, or sought for many poses."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.ik.answers.setting import Setting, turns_of
from mafsil.ik.redundant.form import Redundancy, redundancy
from mafsil.ik.redundant.intervals import BranchIntervals, certify_intervals, programs, range_of
from mafsil.ik.redundant.parametric_form import ParametricForm
from mafsil.ik.result import ORTHOGONALITY, reach_bound
from mafsil.ik.tolerances import EXACT_POSE, INSET, INSIDE

LOOKED_AT = 64
"""Cells in doubt whose middle is tried."""
COARSE, FINE = 24, 240
"""Values of one redundant joint that are tried, first and then."""
MOST_JOINTS = 3
"""Held joints up to which the number of tried vectors grows by a factor of eight for each."""
TOGETHER = 128
"""Evaluations that are made at once though one of them may be enough: a call of a kernel costs as much."""


@dataclass(frozen=True, eq=False)
class ParameterValues:
    """What is known of each of k poses.

    Attributes:
        values: (k, h) of the redundant joints, by coordinate.
        allowed: (k,) whether they lead to a solution within the limits.
        solved: (k,) whether they lead to any.
        refuted: (k,) whether it is proven that no value leads to a solution within the limits.
        unreachable: (k,) whether it is proven that none leads to any.
    """

    values: Floats
    allowed: NDArray[np.bool_]
    solved: NDArray[np.bool_]
    refuted: NDArray[np.bool_]
    unreachable: NDArray[np.bool_]


def parameter_values(
    setting: Setting, form: ParametricForm, T: PoseMatrix, near: JointVector, most: float
) -> ParameterValues:
    """The preferred values, or the nearest tried ones that lead to solutions within the limits, or else to any.

    1. The preferred values are judged for all poses.
    2. A pose beyond the sphere that the frame cannot leave has no solution.
    3. For the others values spread over the ranges of the redundant joints are tried, the nearest first, until each
       pose has a solution within the limits; the nearest that lead to any solution are remembered.
    4. Of one redundant joint, interval arithmetic then finds values or proves that there are none; see `locked_values`.

    Args:
        setting: an arm whose exact closed form holds joints.
        form: its kernels.
        T: (k, 4, 4) poses; of rows that are none nothing is sought.
        near: (n,) preferred values.
        most: largest residual of a solution.
    """
    count, locked = len(T), sorted(setting.arm.locked)
    # 1.
    values = np.repeat(near[locked][None], count, axis=0)
    judged = _judge(setting, form, T, values, near, most)
    allowed, solved = judged[:, 0] <= INSIDE, judged[:, 1] <= most
    found = ParameterValues(values, allowed, solved, np.zeros(count, dtype=np.bool_), np.zeros(count, dtype=np.bool_))
    open_rows = np.flatnonzero(~allowed & (judged[:, 2] <= ORTHOGONALITY))
    if not len(open_rows):
        return found
    # 2.
    beyond = beyond_sphere(setting, T[open_rows], most)
    found.refuted[open_rows] = found.unreachable[open_rows] = beyond
    open_rows = open_rows[~beyond]
    # 3.
    for tries in _tries(setting, near):
        open_rows = _try(setting, form, T, near, most, tries, found, open_rows)
    # 4.
    if setting.holds_one:
        for i in open_rows:
            _by_intervals(setting, form, T[i], near, most, found, int(i))
    return found


def nearest_allowed(
    setting: Setting, form: ParametricForm, T: PoseMatrix, near: JointVector, most: float
) -> Floats | None:
    """(h,) the nearest of the first tried values that lead one pose (4, 4) to a solution within the limits, or None.

    The same values as `parameter_values` finds where the preferred ones lead to none; arguments as there.
    """
    tries = _tries(setting, near)[0]
    if len(tries) > TOGETHER:
        return None
    allowed = _judge(setting, form, T, tries, near, most)[:, 0] <= INSIDE
    first = int(allowed.argmax())
    return tries[first] if allowed[first] else None


def _judge(
    setting: Setting, form: ParametricForm, T: PoseMatrix, values: Floats, near: JointVector, most: float
) -> Floats:
    """(*batch, 3) least excess of a solution, least residual, how far the pose is from one."""
    turns = setting.middle_turns if near is setting.middle else turns_of(near)
    return form.check(T, values, near, turns, *setting.bounds, most)


def beyond_sphere(setting: Setting, T: PoseMatrix, tolerance: float) -> NDArray[np.bool_]:
    """(k,) which places are farther than a tolerance outside the sphere that the frame cannot leave.

    None of an arm with slides, which may leave their limits.

    Args:
        setting: the arm.
        T: (k, 4, 4) poses.
        tolerance: largest residual of a solution.
    """
    chain = setting.arm.chain
    if chain is None or any(chain.prismatic):
        return np.zeros(len(T), dtype=np.bool_)
    centre, radius = _sphere(setting)
    away = np.linalg.norm(T[:, :3, 3] - centre, axis=1)
    return np.asarray(away > radius * (1 + EXACT_POSE) + tolerance, dtype=np.bool_)


@lru_cache(maxsize=128)
def _sphere(setting: Setting) -> tuple[Floats, float]:
    """Centre and radius of the sphere that the frame cannot leave [m]."""
    return reach_bound(setting.robot.mechanism, None)


def _tries(setting: Setting, near: JointVector) -> tuple[Floats, ...]:
    """(m, h) values that are tried one after the other, in one or two lists."""
    return _middle_tries(setting) if near is setting.middle else _ordered_tries(setting, near)


@lru_cache(maxsize=128)
def _middle_tries(setting: Setting) -> tuple[Floats, ...]:
    return _ordered_tries(setting, setting.middle)


def _ordered_tries(setting: Setting, near: JointVector) -> tuple[Floats, ...]:
    """Values over the ranges of the redundant joints, the nearest to the preferred ones first."""
    locked = sorted(setting.arm.locked)
    low, high = np.maximum(setting.lower[locked], -np.pi), np.minimum(setting.upper[locked], np.pi)
    if len(locked) == 1:
        return tuple(_nearest_first(np.linspace(low, high, count), near[locked]) for count in (COARSE, FINE))
    generator, count = np.random.default_rng(0), COARSE * 8 ** min(len(locked) - 1, MOST_JOINTS - 1)
    values: list[Floats] = [generator.uniform(a, b, count) for a, b in zip(low, high, strict=True)]
    return (_nearest_first(np.stack(values, axis=1), near[locked]),)


def _nearest_first(values: Floats, preferred: Floats | float) -> Floats:
    away = np.abs(values - preferred)
    return values[np.argsort(away if away.ndim == 1 else away.max(axis=1), kind="stable")]


def _try(
    setting: Setting,
    form: ParametricForm,
    T: PoseMatrix,
    near: JointVector,
    most: float,
    tries: Floats,
    found: ParameterValues,
    open_rows: NDArray[np.intp],
) -> NDArray[np.intp]:
    """Write what the first successful try of each open pose is; the poses that are open still."""
    begin = 0
    while begin < len(tries) and len(open_rows):
        some = tries[begin : begin + max(1, TOGETHER // len(open_rows))]
        begin += len(some)
        judged = _judge(setting, form, T[open_rows][:, None], some, near, most)
        for good, marked in ((judged[..., 1] <= most, found.solved), (judged[..., 0] <= INSIDE, found.allowed)):
            # Where any solution is known already only one within the limits is better.
            new = good.any(axis=1) & ~marked[open_rows]
            rows = open_rows[new]
            found.values[rows] = some[good[new].argmax(axis=1)]
            marked[rows] = True
        open_rows = open_rows[~found.allowed[open_rows]]
    return open_rows


def _by_intervals(
    setting: Setting,
    form: ParametricForm,
    T: PoseMatrix,
    near: JointVector,
    most: float,
    found: ParameterValues,
    i: int,
) -> None:
    """The redundant joint of one pose where intervals prove that there are solutions within the limits, or else any."""
    for limits, marked, proven in ((True, found.allowed, found.refuted), (False, found.solved, found.unreachable)):
        if not limits and found.solved[i]:
            return
        known = locked_values(setting, T, float(near[setting.arm.locked[0]]), limits=limits)
        if known is None:
            return
        proven[i] = known.none
        if not len(known.values):
            continue
        judged = _judge(setting, form, T, known.values[:, None], near, most)
        good = judged[:, 0] <= INSIDE if limits else judged[:, 1] <= most
        if good.any():
            found.values[i], marked[i] = known.values[int(good.argmax())], True
            found.solved[i] = True
            return


@dataclass(frozen=True, eq=False)
class LockedValues:
    """What is known of the values of a locked joint.

    Attributes:
        values: (k,) some that lead to configurations, the nearest to the preferred one first.
        none: whether it is proven that no value does.
    """

    values: Floats
    none: bool


def locked_values(setting: Setting, T: PoseMatrix, preferred: float, *, limits: bool = True) -> LockedValues | None:
    """Values of the locked joint at which one pose is reached; None where nothing can be proven of the arm.

    Args:
        setting: an arm whose closed form holds one joint.
        T: (4, 4) desired pose in {s}.
        preferred: value of the locked joint.
        limits: whether the configurations shall be within the joint limits; else joints turn without end, slides too.
    """
    arm = setting.arm
    if not setting.holds_one:
        return None
    locked = arm.locked[0]
    if limits and (form := _by_arm_angle(setting)) is not None:
        return _of_arm_angle(form, T, locked, preferred)
    found = branch_intervals(setting, T, limits=limits)
    if found is None:
        return None
    inset = np.minimum(INSET, (found.high - found.low) / 4)
    values = np.clip(preferred, found.low + inset, found.high - inset)
    doubtful = found.doubtful[:: max(1, len(found.doubtful) // LOOKED_AT), 1:].mean(axis=1)
    none = not len(values) and not len(found.doubtful)
    return LockedValues(_nearest_first(np.concatenate([values, doubtful]), preferred), none)


def branch_intervals(setting: Setting, T: PoseMatrix, *, limits: bool = True) -> BranchIntervals | None:
    """Intervals of the locked joint, branch by branch; None where the closed form has no program for them.

    Args:
        setting: an arm whose exact closed form holds one joint.
        T: (4, 4) desired pose in {s}.
        limits: whether the configurations shall be within the joint limits.
    """
    arm = setting.arm
    assert arm.form is not None
    assert arm.chain is not None
    locked = arm.locked[0]
    given = programs(arm.form.pattern, locked, tuple(map(float, setting.middle)))
    if given is None:
        return None
    endless = np.full(setting.robot.n, np.inf)
    lower, upper = (setting.lower, setting.upper) if limits else (-endless, endless)
    domain = range_of(arm.chain, locked, lower[locked], upper[locked], setting.robot.limits, T)
    return certify_intervals(given, T, locked, domain, lower, upper, ~setting.revolute)


def _by_arm_angle(setting: Setting) -> Redundancy | None:
    """The same arm counted by its arm angle, whose intervals cost far less."""
    if setting.task != "pose" or setting.robot.n != 7:
        return None
    form = redundancy(setting.robot)
    return form if form.angle_form is not None else None


def _of_arm_angle(form: Redundancy, T: PoseMatrix, locked: int, preferred: float) -> LockedValues:
    intervals = form.intervals(T)
    if not intervals:
        return LockedValues(np.zeros(0), none=True)
    shares = np.linspace(0.02, 0.98, 9)
    angles = np.concatenate([low + shares * (high - low) for low, high, _, _ in intervals])
    branch = np.repeat([one[2] for one in intervals], len(shares))
    q = form.solve(T, angles).q[np.arange(len(angles)), branch, locked]
    return LockedValues(_nearest_first(q[np.isfinite(q)], preferred), none=False)
