"""Closed forms as functions with one column per port."""

from __future__ import annotations

import mafsil.expression as ex
from mafsil.mechanics.arm_pattern import ArmPattern
from mafsil.mechanics.closed_form import parametric
from mafsil.mechanics.closed_form.geometry import inputs
from mafsil.mechanics.closed_form.table import Preferences, judge_branches, label_branches, raw


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


def parametric_function(pattern: parametric.Pattern, kind: str, thresholds: parametric.Thresholds) -> ex.Function:
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
        q, details, summary = parametric.parametric_solutions(pattern, thresholds, _pose(T), values, preferences, most)
        outputs = [_column(q), _column(details), summary]
    elif kind == "check":
        outputs = [parametric.parametric_check(pattern, _pose(T), values, preferences, most)]
    else:
        q, residual, excess, defect = parametric.parametric_configurations(pattern, _pose(T), values, preferences, most)
        outputs = [_column(q), residual, excess, defect]
    return ex.Function(f"parametric_{kind}", [T, values, q0, turns, lower, upper, most], ex.cse(outputs))


def _pose(T: ex.Expression) -> ex.Expression:
    return ex.reshape(T, 4, 4).T


def _column(table: ex.Expression) -> ex.Expression:
    return ex.vec(table.T)
