"""Which values of a locked joint lead to configurations within the limits, or to any: proven, not tried."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats, PoseMatrix
from mafsil.ik.answers.setting import Setting
from mafsil.ik.redundant.form import Redundancy, redundancy
from mafsil.ik.redundant.intervals import BranchIntervals, certify_intervals, programs, range_of
from mafsil.ik.tolerances import INSET

LOOKED_AT = 64
"""Cells in doubt whose middle is tried."""


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


def _nearest_first(values: Floats, preferred: float) -> Floats:
    return values[np.argsort(np.abs(values - preferred), kind="stable")]
