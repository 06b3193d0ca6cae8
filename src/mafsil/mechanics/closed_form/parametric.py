"""Closed forms whose redundant joints are an input, and all closed forms as functions with one column per port.

Of given redundant joints: solutions, a check of values alone, and bare configurations.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import mafsil.expression as ex
from mafsil.mechanics.arm_pattern import MERGED, ArmAnglePattern, ArmPattern, Family
from mafsil.mechanics.closed_form.arm_angle import arm_angle_branches
from mafsil.mechanics.closed_form.line import BranchSolution, inputs
from mafsil.mechanics.closed_form.table import (
    JudgedBranch,
    Preferences,
    judge_branches,
    judged_branches,
    label_branches,
    orthonormalise_pose,
    raw,
)

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
        margin: branch margins below which branches may be one, or members of a further continuum.
        split: residual, in units of the arm, up to which a branch with four merged roots may become a solution.
        nearly, bent: the same, in units of the arm, where a solution's branch margin is below `bent`.
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
    preferences: Preferences,
    most: ex.Expression,
) -> tuple[ex.Expression, ex.Expression, ex.Expression]:
    """All branches at values of the redundant joints, and whether they are an answer as they are.

    Args:
        pattern: of the arm, some joints redundant, or counted by its arm angle.
        thresholds: of regular answers.
        T: (4, 4) requested pose; small errors of its rotation are repaired first.
        values: (h,) of the redundant joints, by coordinate; (1,) the arm angle.
        preferences: of the caller; the entries of redundant joints do not count.
        most: largest residual of a solution.

    Returns:
        (branches, n) coordinates; (branches, 4) residual, code of the branch, smallest branch margin, excess over the
        limits;
        (4,) how far T is from a pose, one if a branch needs refinement, one if rounding may have moved a branch far off
        where two pairs of roots merge, and the least excess over the limits of a solution.
    """
    T, defect = orthonormalise_pose(T)
    rows = _branches(pattern, T, values, preferences)
    least = _least([(row.residual <= most, row.excess) for row in rows])
    coded = [_code(row.solution) for row in rows]
    bend = _least([(row.residual <= thresholds.exact, margin) for row, (_, margin) in zip(rows, coded, strict=True)])
    doubtful, folded = ex.Expression(0), ex.Expression(0)
    for row, (_, margin) in zip(rows, coded, strict=True):
        doubtful = ex.logic_or(doubtful, _needs_refinement(thresholds, row, margin))
        folded = ex.logic_or(folded, _fold(pattern, thresholds, row, bend))
    details = [ex.horzcat(row.residual, *code, row.excess) for row, code in zip(rows, coded, strict=True)]
    summary = ex.vertcat(defect, doubtful, folded, least)
    return ex.vertcat(*[ex.horzcat(*row.q) for row in rows]), ex.vertcat(*details), summary


def parametric_check(
    pattern: Pattern, T: ex.Expression, values: ex.Expression, preferences: Preferences, most: ex.Expression
) -> ex.Expression:
    """What values of the redundant joints lead to.

    Arguments as for `parametric_solutions`.

    Returns:
        (3,) the least excess over the limits of a solution, infinite without one; the least residual; how far T is from
        a pose.
    """
    T, defect = orthonormalise_pose(T)
    rows = _branches(pattern, T, values, preferences)
    least_residual = _least([(row.residual < ex.inf, row.residual) for row in rows])
    return ex.vertcat(_least([(row.residual <= most, row.excess) for row in rows]), least_residual, defect)


def parametric_configurations(
    pattern: Pattern, T: ex.Expression, values: ex.Expression, preferences: Preferences, most: ex.Expression
) -> tuple[ex.Expression, ex.Expression, ex.Expression, ex.Expression]:
    """Branches that reach the pose, NaN where one does not; arguments as for `parametric_solutions`.

    With an arm angle a branch that can be made at all is shown, whatever its residual.

    Returns:
        (branches, n) coordinates, (branches,) residuals, (branches,) excess over the limits, infinite without a
        configuration, and how far T is from a pose.
    """
    T, defect = orthonormalise_pose(T)
    q: list[ex.Expression] = []
    residual: list[ex.Expression] = []
    excess: list[ex.Expression] = []
    for row in _branches(pattern, T, values, preferences):
        found = row.residual <= most
        shown = row.residual < ex.inf if isinstance(pattern, ArmAnglePattern) else found
        q.append(ex.horzcat(*[ex.if_else(shown, x, NONE) for x in row.q]))
        residual.append(ex.if_else(shown, row.residual, NONE))
        excess.append(ex.if_else(found, row.excess, ex.inf))
    return ex.vertcat(*q), ex.vertcat(*residual), ex.vertcat(*excess), defect


def _branches(
    pattern: Pattern, T: ex.Expression, values: ex.Expression, preferences: Preferences
) -> list[JudgedBranch]:
    """All branches of a pose that is one."""
    if isinstance(pattern, ArmAnglePattern):
        return arm_angle_branches(pattern, T, values[0], preferences)
    return judged_branches(pattern, T, _with_values(pattern, values, preferences))


def _with_values(pattern: ArmPattern, values: ex.Expression, preferences: Preferences) -> Preferences:
    """The preferences with the redundant joints at their values, in order of their coordinates."""
    q0, turns = ex.Expression(preferences.q0), ex.Expression(preferences.turns)
    for k, locked in enumerate(sorted(pattern.locked, key=lambda one: one.joint)):
        q0[locked.joint] = values[k]
        turns[locked.joint, 0], turns[locked.joint, 1] = ex.cos(values[k]), ex.sin(values[k])
    return Preferences(q0, turns, preferences.lower, preferences.upper)


def _least(rows: list[tuple[ex.Expression, ex.Expression]]) -> ex.Expression:
    """The least of those numbers whose condition holds; infinite if none does."""
    least = ex.Expression(ex.inf)
    for condition, x in rows:
        least = ex.fmin(least, ex.if_else(condition, x, ex.inf))
    return least


def _needs_refinement(thresholds: Thresholds, row: JudgedBranch, margin: ex.Expression) -> ex.Expression:
    """Whether a branch is not quite a solution, merges with another, or is free; `margin` is its smallest."""
    exact = row.residual <= thresholds.exact
    beside = ex.logic_and(row.residual > thresholds.exact, row.residual <= thresholds.candidate)
    return ex.logic_or(beside, ex.logic_and(exact, ex.logic_or(row.free > 0, margin <= thresholds.margin)))


def _fold(pattern: Pattern, thresholds: Thresholds, row: JudgedBranch, bend: ex.Expression) -> ex.Expression:
    """Whether rounding may have moved a branch far off, beside two pairs of merged roots.

    Args:
        pattern: of the arm.
        thresholds: of regular answers.
        row: the branch.
        bend: the smallest branch margin of a solution.
    """
    if isinstance(pattern, ArmAnglePattern) or pattern.family not in (Family.SPHERICAL_WRIST, Family.THREE_PARALLEL):
        return ex.Expression(0)
    size = pattern.size
    nearby = ex.logic_and(row.residual <= thresholds.nearly * size, bend <= thresholds.bent)
    merged = ex.logic_and(_merged_twice(pattern, row.solution), row.residual <= thresholds.split * size)
    return ex.logic_and(row.residual > thresholds.exact, ex.logic_or(nearby, merged))


def _merged_twice(pattern: ArmPattern, solution: BranchSolution) -> ex.Expression:
    """Whether the branches of the shoulder are one, and those of elbow or wrist."""
    if not any(j >= 0 and not prismatic for j, prismatic in zip(pattern.joints, pattern.prismatic, strict=True)):
        # Prismatic joints alone are linear: nothing merges.
        return ex.Expression(0)
    shoulder, elbow, wrist = (
        ex.Expression(1) if branch_margin is None else _merge(branch_margin)
        for branch_margin in solution.branch_margins
    )
    return ex.logic_and(shoulder, ex.logic_or(elbow, wrist))


def _code(solution: BranchSolution) -> tuple[ex.Expression, ex.Expression]:
    """The signs of the branch margins and the reason in one number, as `Row` has it, and the smallest branch margin."""
    code, margin = 27 * solution.reason, ex.Expression(1)
    for branch_margin, weight in zip(solution.branch_margins, (1, 3, 9), strict=True):
        if branch_margin is None:
            code = code + weight
            continue
        code = code + weight * ex.if_else(branch_margin > MERGED, 2, ex.if_else(branch_margin < -MERGED, 0, 1))
        margin = ex.fmin(margin, ex.fabs(branch_margin))
    return code, margin


def _merge(branch_margin: ex.Expression) -> ex.Expression:
    return ex.logic_not(ex.logic_or(branch_margin > MERGED, branch_margin < -MERGED))


def table_function(pattern: ArmPattern, with_q0: bool) -> ex.Function:
    """Of (T_sd[, q0]) to the table of branches, row by row.

    Args:
        pattern: of the arm.
        with_q0: whether the coordinates of free joints are an input.
    """
    T = ex.symbol("T_sd", 16)
    preferred = ex.symbol("q0", pattern.n)
    table = raw(pattern, _pose(T), preferred if with_q0 else None)
    return ex.Function("closed_form", [T, preferred] if with_q0 else [T], [ex.cse(_column(table))])


def structure_function(pattern: ArmPattern) -> ex.Function:
    """Of (T_sd, numbers) to the table of branches: one function for all arms of the same structure.

    Args:
        pattern: of one of them; its numbers are not used.
    """
    T = ex.symbol("T_sd", 16)
    numbers = ex.symbol("numbers", len(pattern.numbers))
    table = raw(pattern, _pose(T), None, inputs(pattern, numbers))
    return ex.Function("closed_form", [T, numbers], [ex.cse(_column(table))])


def labelled_function(pattern: ArmPattern) -> ex.Function:
    """Of (T_sd, q0, turns, lower, upper) to coordinates, details and the defect of the pose.

    Args:
        pattern: of the arm.
    """
    inputs, T, preferences = _inputs(pattern)
    q, details, defect = label_branches(pattern, T, preferences)
    outputs = ex.cse([_column(q), _column(details), defect])
    return ex.Function("labelled_closed_form", inputs, outputs)


def judged_function(pattern: ArmPattern) -> ex.Function:
    """Of (T_sd, q0, turns, lower, upper, tolerance) to coordinates, details and what is decided about the pose.

    Args:
        pattern: of the arm.
    """
    inputs, T, preferences = _inputs(pattern)
    tolerance = ex.symbol("tolerance")
    q, details, decision = judge_branches(pattern, T, preferences, tolerance)
    outputs = ex.cse([_column(q), _column(details), decision])
    return ex.Function("judged_closed_form", [*inputs, tolerance], outputs)


def _inputs(pattern: ArmPattern) -> tuple[list[ex.Expression], ex.Expression, Preferences]:
    """The inputs, and the pose and the preferences that they are."""
    n = pattern.n
    T, turns = ex.symbol("T_sd", 16), ex.symbol("turns", 2 * n)
    q0, lower, upper = (ex.symbol(name, n) for name in ("q0", "lower", "upper"))
    preferences = Preferences(q0, ex.reshape(turns, 2, n).T, lower, upper)
    return [T, q0, turns, lower, upper], _pose(T), preferences


def parametric_function(pattern: Pattern, kind: str, thresholds: Thresholds) -> ex.Function:
    """Of (T_sd, values, q0, turns, lower, upper, most) to what `parametric` makes of them.

    Args:
        pattern: of the arm, some joints locked, or counted by its arm angle.
        kind: `solutions`, `check` or `configurations`.
        thresholds: of regular answers.
    """
    n = pattern.n
    T, values, turns = ex.symbol("T_sd", 16), ex.symbol("values", pattern.parameters), ex.symbol("turns", 2 * n)
    q0, lower, upper = (ex.symbol(name, n) for name in ("q0", "lower", "upper"))
    most = ex.symbol("most")
    preferences = Preferences(q0, ex.reshape(turns, 2, n).T, lower, upper)
    if kind == "solutions":
        q, details, summary = parametric_solutions(pattern, thresholds, _pose(T), values, preferences, most)
        outputs = [_column(q), _column(details), summary]
    elif kind == "check":
        outputs = [parametric_check(pattern, _pose(T), values, preferences, most)]
    else:
        q, residual, excess, defect = parametric_configurations(pattern, _pose(T), values, preferences, most)
        outputs = [_column(q), residual, excess, defect]
    return ex.Function(f"parametric_{kind}", [T, values, q0, turns, lower, upper, most], ex.cse(outputs))


def _pose(T: ex.Expression) -> ex.Expression:
    return ex.reshape(T, 4, 4).T


def _column(table: ex.Expression) -> ex.Expression:
    return ex.vec(table.T)
