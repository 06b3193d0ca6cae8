"""What the rows of a closed form decide about a pose, as an expression: its solutions, or what has to be done first.

1. Solutions are rows whose residual is within the tolerance.
2. A row in between solution and none, a free joint, and a fold where branches meet ask for care.
3. Where nothing asks for care the solutions are all there are; where some branch margins are small they may repeat each
   other.
4. Where the only care required is that two branches meet, or that joints of the wrist are free, every solution is
   exact as it stands: rows are to be merged and nothing refined.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce

import mafsil.expression as ex
from mafsil.mechanics.arm_pattern import (
    APART,
    BENT,
    CLEAR,
    FOLD,
    INSIDE,
    LOOSE,
    MERGED,
    NEARLY,
    ORTHOGONALITY,
    QUARTIC,
    ROUNDED,
    SECOND,
    SPLIT,
    ArmPattern,
    candidate,
    folds,
    merges_twice,
)

REPEATED, MEETING, CAREFUL, NONE, NO_POSE = -1.0, -2.0, -3.0, -4.0, -5.0
"""What is decided where solutions are not distinct, isolated and exact; see `Decision` of inverse kinematics."""


@dataclass(frozen=True, eq=False)
class Row:
    """What is known of one branch.

    Attributes:
        residual, subproblem_residual, free, code, margin, excess: see `mafsil.ik.closed_form`.
        second: the second smallest branch margin, one where there are not two.
        merged: how many of its branch margins are within `MERGED`, those counted that the arm does not have.
        merged_shoulder: whether the shoulder's is among them.
        free_first: whether a joint that is found before those of the wrist is free.
        fixed_excess: by how much a coordinate that stands while the wrist's joints move is beyond its limits.
    """

    residual: ex.Expression
    subproblem_residual: ex.Expression
    free: ex.Expression
    code: ex.Expression
    margin: ex.Expression
    excess: ex.Expression
    second: ex.Expression
    merged: ex.Expression
    merged_shoulder: ex.Expression
    free_first: ex.Expression
    fixed_excess: ex.Expression


def solution_bits(
    pattern: ArmPattern, rows: Sequence[Row], defect: ex.Expression, tolerance: ex.Expression
) -> ex.Expression:
    """The sum of 2^k over the rows k that are solutions, where they are distinct, isolated and exact; else what to do.

    Args:
        pattern: of the arm.
        rows: all branches.
        defect: how far the matrix is from a pose.
        tolerance: largest residual of a solution.
    """
    # 1. Solutions.
    good = [row.residual <= tolerance for row in rows]
    found = _any(good)
    solved = sum((2.0**k * one for k, one in enumerate(good)), ex.Expression(0))
    # 2. What asks for care.
    exact, most = ex.fmin(CLEAR, tolerance), ex.fmax(candidate(pattern), tolerance)
    between = [
        ex.logic_and(ex.logic_and(row.residual > exact, row.residual <= most), ex.logic_not(short))
        for row, short in zip(rows, _short(pattern, rows, tolerance), strict=True)
    ]
    meets = [
        ex.logic_and(one, ex.logic_or(row.free > 0, row.margin <= MERGED)) for one, row in zip(good, rows, strict=True)
    ]
    allowed = _any([ex.logic_and(one, row.excess <= INSIDE) for one, row in zip(good, rows, strict=True)])
    lost = ex.logic_and(ex.logic_not(allowed), _any([_may_be_inside(pattern, row) for row in rows]))
    nearest = ex.if_else(tolerance > LOOSE, 1e3 * tolerance, LOOSE)
    nearly = ex.logic_and(ex.logic_not(found), _any([_least_residual(pattern, row) <= nearest for row in rows]))
    refine = _any([*between, *_near_folds(pattern, rows), lost, nearly])
    if pattern.quartic:
        nearby = [ex.logic_and(one, row.margin < QUARTIC) for one, row in zip(good, rows, strict=True)]
        refine = _any([refine, ex.logic_not(found), *nearby, *(row.margin <= FOLD for row in rows)])
    # 3. Rows that may repeat each other.
    close = _any([ex.logic_and(one, row.margin < APART) for one, row in zip(good, rows, strict=True)])
    repeated = ex.Expression(1) if pattern.quartic or not pattern.plain else close
    # 4. Solutions that only have to be merged.
    twice = [_is_entangled(pattern, row) for row in rows]
    entangled = _any([ex.logic_and(one, worse) for one, worse in zip(meets, twice, strict=True)])
    careful = ex.logic_or(refine, entangled)
    decision = ex.if_else(repeated, REPEATED, solved)
    decision = ex.if_else(_any(meets), MEETING, decision)
    decision = ex.if_else(found, decision, NONE)
    decision = ex.if_else(careful, CAREFUL, decision)
    return ex.if_else(defect <= ORTHOGONALITY, decision, NO_POSE)


def _least_residual(pattern: ArmPattern, row: Row) -> ex.Expression:
    """By how much the nearest configuration may be off: without an exact solution it may be within the tolerance."""
    nearest = ex.fmin(row.residual, row.subproblem_residual)
    if pattern.n >= pattern.equations:
        return nearest
    # All steps may succeed and added joints move: only at folds does that say nothing.
    return ex.if_else(ex.logic_or(row.free > 0, row.margin <= FOLD), nearest, row.residual)


def _near_folds(pattern: ArmPattern, rows: Sequence[Row]) -> list[ex.Expression]:
    """Which rows rounding may have moved off: two pairs of roots merge there and split again.

    A row that falls short while its other branch_margins are large falls short indeed: what went before, with the
        branch margin m, is
    known to the rounding over m, and to its square root where that root merges as well.
    """
    if not folds(pattern):
        return []
    margins = [ex.if_else(row.residual <= CLEAR, row.margin, ex.inf) for row in rows]
    beside = reduce(ex.fmin, margins) <= BENT
    found: list[ex.Expression] = []
    for row in rows:
        off = ex.logic_and(row.residual > CLEAR, row.residual <= SPLIT * pattern.size)
        merged = ex.logic_and(row.merged > 1, row.merged_shoulder) if merges_twice(pattern) else ex.Expression(0)
        nearby = ex.logic_and(row.residual <= NEARLY * pattern.size, beside)
        nearby = ex.logic_and(nearby, row.residual * row.second**2 <= ROUNDED * pattern.size)
        found.append(ex.logic_and(off, ex.logic_or(merged, nearby)))
    return found


def _short(pattern: ArmPattern, rows: Sequence[Row], tolerance: ex.Expression) -> list[ex.Expression]:
    """Which rows fall short by more than rounding explains, as `_near_folds` says."""
    if pattern.quartic or pattern.n < pattern.equations:
        return [ex.Expression(0)] * len(rows)
    found: list[ex.Expression] = []
    for row in rows:
        unsolved = ex.logic_and(row.residual > tolerance, row.subproblem_residual >= 0.1 * row.residual)
        found.append(ex.logic_and(unsolved, row.residual * row.second**2 > ROUNDED * pattern.size))
    return found


def _may_be_inside(pattern: ArmPattern, row: Row) -> ex.Expression:
    """Whether free joints may be chosen so that a row is within the limits: those that stand while they move are."""
    free = row.free > 0
    if pattern.quartic:
        return free
    known = ex.logic_and(ex.logic_not(row.free_first), row.free < 2.0**pattern.n)
    solved = row.residual <= candidate(pattern)
    return ex.logic_and(free, ex.logic_or(ex.logic_not(known), ex.logic_and(solved, row.fixed_excess <= INSIDE)))


def _is_entangled(pattern: ArmPattern, row: Row) -> ex.Expression:
    """Whether more meets at a solution than two branches, or a wrist that stands straight."""
    return _any([row.second <= SECOND, row.free_first, row.free >= 2.0**pattern.n])


def _any(conditions: Sequence[ex.Expression]) -> ex.Expression:
    return reduce(ex.logic_or, conditions)
