"""Closed forms whose redundant joints are an input: solutions, a check of values alone, and bare configurations."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import mafsil.expression as ex
from mafsil.mechanics.arm_angle_pattern import ArmAnglePattern
from mafsil.mechanics.arm_pattern import ArmPattern, Family
from mafsil.mechanics.closed_form.arm_angle import arm_angle_branches
from mafsil.mechanics.closed_form.line import Posture
from mafsil.mechanics.closed_form.table import JudgedBranch, Wishes, judged_branches, repaired
from mafsil.mechanics.closed_form.thresholds import MERGED

Pattern: TypeAlias = ArmPattern | ArmAnglePattern
"""Of arms that are solved once a parameter is given: values of redundant joints, or the arm angle."""

NONE = float("nan")
"""Coordinates and residual of a branch that does not reach the pose."""


@dataclass(frozen=True)
class Thresholds:
    """What tells a regular answer from one that needs refinement.

    Attributes:
        exact: residual of a branch that needs no refinement.
        candidate: residual up to which a branch may become a solution by refinement.
        margin: marks below which branches may be one, or members of a further continuum.
        split: residual, in units of the arm, up to which a branch with four merged roots may become a solution.
        nearly, bent: the same, in units of the arm, where a solution's mark is below `bent`.
    """

    exact: float
    candidate: float
    margin: float
    split: float
    nearly: float
    bent: float


def parametric_solutions(
    pattern: Pattern,
    thresholds: Thresholds,
    T: ex.Expression,
    values: ex.Expression,
    wishes: Wishes,
    most: ex.Expression,
) -> tuple[ex.Expression, ex.Expression, ex.Expression]:
    """All branches at values of the redundant joints, and whether they are an answer as they are.

    Args:
        pattern: of the arm, some joints redundant, or counted by its arm angle.
        thresholds: of regular answers.
        T: (4, 4) wanted pose; small errors of its rotation are repaired first.
        values: (h,) of the redundant joints, by coordinate; (1,) the arm angle.
        wishes: of the caller; the entries of redundant joints do not count.
        most: largest residual of a solution.

    Returns:
        (branches, n) coordinates; (branches, 4) residual, code of the branch, smallest mark, excess over the limits;
        (4,) how far T is from a pose, one if a branch needs refinement, one if rounding may have moved a branch far off
        where two pairs of roots merge, and the least excess over the limits of a solution.
    """
    T, defect = repaired(T)
    rows = _branches(pattern, T, values, wishes)
    least = _least([(row.miss <= most, row.excess) for row in rows])
    marks = [_coded(row.posture) for row in rows]
    bend = _least([(row.miss <= thresholds.exact, margin) for row, (_, margin) in zip(rows, marks, strict=True)])
    doubtful, folded = ex.Expression(0), ex.Expression(0)
    for row, (_, margin) in zip(rows, marks, strict=True):
        doubtful = ex.logic_or(doubtful, _needs_refinement(thresholds, row, margin))
        folded = ex.logic_or(folded, _folded(pattern, thresholds, row, bend))
    details = [ex.horzcat(row.miss, *code, row.excess) for row, code in zip(rows, marks, strict=True)]
    summary = ex.vertcat(defect, doubtful, folded, least)
    return ex.vertcat(*[ex.horzcat(*row.q) for row in rows]), ex.vertcat(*details), summary


def parametric_check(
    pattern: Pattern, T: ex.Expression, values: ex.Expression, wishes: Wishes, most: ex.Expression
) -> ex.Expression:
    """What values of the redundant joints lead to.

    Arguments as for `parametric_solutions`.

    Returns:
        (3,) the least excess over the limits of a solution, infinite without one; the least residual; how far T is from
        a pose.
    """
    T, defect = repaired(T)
    rows = _branches(pattern, T, values, wishes)
    missing = _least([(row.miss < ex.inf, row.miss) for row in rows])
    return ex.vertcat(_least([(row.miss <= most, row.excess) for row in rows]), missing, defect)


def parametric_configurations(
    pattern: Pattern, T: ex.Expression, values: ex.Expression, wishes: Wishes, most: ex.Expression
) -> tuple[ex.Expression, ex.Expression, ex.Expression, ex.Expression]:
    """Branches that reach the pose, NaN where one does not; arguments as for `parametric_solutions`.

    With an arm angle a branch that can be made at all is shown, by whatever it misses.

    Returns:
        (branches, n) coordinates, (branches,) residuals, (branches,) excess over the limits, infinite without a
        configuration, and how far T is from a pose.
    """
    T, defect = repaired(T)
    q: list[ex.Expression] = []
    residual: list[ex.Expression] = []
    excess: list[ex.Expression] = []
    for row in _branches(pattern, T, values, wishes):
        found = row.miss <= most
        shown = row.miss < ex.inf if isinstance(pattern, ArmAnglePattern) else found
        q.append(ex.horzcat(*[ex.if_else(shown, x, NONE) for x in row.q]))
        residual.append(ex.if_else(shown, row.miss, NONE))
        excess.append(ex.if_else(found, row.excess, ex.inf))
    return ex.vertcat(*q), ex.vertcat(*residual), ex.vertcat(*excess), defect


def _branches(pattern: Pattern, T: ex.Expression, values: ex.Expression, wishes: Wishes) -> list[JudgedBranch]:
    """All branches of a pose that is one."""
    if isinstance(pattern, ArmAnglePattern):
        return arm_angle_branches(pattern, T, values[0], wishes)
    return judged_branches(pattern, T, _with_values(pattern, values, wishes))


def _with_values(pattern: ArmPattern, values: ex.Expression, wishes: Wishes) -> Wishes:
    """The wishes with the redundant joints at their values, in order of their coordinates."""
    near, turns = ex.Expression(wishes.near), ex.Expression(wishes.turns)
    for k, held in enumerate(sorted(pattern.held, key=lambda one: one.joint)):
        near[held.joint] = values[k]
        turns[held.joint, 0], turns[held.joint, 1] = ex.cos(values[k]), ex.sin(values[k])
    return Wishes(near, turns, wishes.lower, wishes.upper)


def _least(rows: list[tuple[ex.Expression, ex.Expression]]) -> ex.Expression:
    """The least of those numbers whose condition holds; infinite if none does."""
    least = ex.Expression(ex.inf)
    for condition, x in rows:
        least = ex.fmin(least, ex.if_else(condition, x, ex.inf))
    return least


def _needs_refinement(thresholds: Thresholds, row: JudgedBranch, margin: ex.Expression) -> ex.Expression:
    """Whether a branch is not quite a solution, merges with another one, or is free; `margin` is its smallest mark."""
    exact = row.miss <= thresholds.exact
    beside = ex.logic_and(row.miss > thresholds.exact, row.miss <= thresholds.candidate)
    return ex.logic_or(beside, ex.logic_and(exact, ex.logic_or(row.free > 0, margin <= thresholds.margin)))


def _folded(pattern: Pattern, thresholds: Thresholds, row: JudgedBranch, bend: ex.Expression) -> ex.Expression:
    """Whether rounding may have moved a branch far off, beside two pairs of merged roots.

    Args:
        pattern: of the arm.
        thresholds: of regular answers.
        row: the branch.
        bend: the smallest mark of a solution.
    """
    if isinstance(pattern, ArmAnglePattern) or pattern.family not in (Family.SPHERICAL_WRIST, Family.THREE_PARALLEL):
        return ex.Expression(0)
    size = pattern.size
    near = ex.logic_and(row.miss <= thresholds.nearly * size, bend <= thresholds.bent)
    merged = ex.logic_and(_merged_twice(pattern, row.posture), row.miss <= thresholds.split * size)
    return ex.logic_and(row.miss > thresholds.exact, ex.logic_or(near, merged))


def _merged_twice(pattern: ArmPattern, posture: Posture) -> ex.Expression:
    """Whether the branches of the shoulder are one, and those of elbow or wrist."""
    if not any(j >= 0 and not slides for j, slides in zip(pattern.joints, pattern.slides, strict=True)):
        # Slides alone are linear: nothing merges.
        return ex.Expression(0)
    shoulder, elbow, wrist = (ex.Expression(1) if mark is None else _merged(mark) for mark in posture.marks)
    return ex.logic_and(shoulder, ex.logic_or(elbow, wrist))


def _coded(posture: Posture) -> tuple[ex.Expression, ex.Expression]:
    """The signs of the marks and the reason in one number, as `Row` has it, and the smallest mark."""
    code, margin = 27 * posture.reason, ex.Expression(1)
    for mark, weight in zip(posture.marks, (1, 3, 9), strict=True):
        if mark is None:
            code = code + weight
            continue
        code = code + weight * ex.if_else(mark > MERGED, 2, ex.if_else(mark < -MERGED, 0, 1))
        margin = ex.fmin(margin, ex.fabs(mark))
    return code, margin


def _merged(mark: ex.Expression) -> ex.Expression:
    return ex.logic_not(ex.logic_or(mark > MERGED, mark < -MERGED))
