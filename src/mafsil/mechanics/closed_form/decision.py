"""What the rows of a closed form decide about a pose, as an expression: its solutions, or what has to be done first.

1. Solutions are rows whose residual is within the tolerance.
2. A row in between solution and none, a free joint, and a fold where branches meet ask for care.
3. Where nothing asks for care the solutions are all there are; where some marks are small they may repeat each other.
4. Where the only care asked for is that two branches meet, or that joints of the wrist are free, every solution is
   exact as it stands: rows are to be merged and nothing refined.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce

import casadi as ca

from mafsil.mechanics.arm_pattern import ArmPattern
from mafsil.mechanics.closed_form.thresholds import (
    APART,
    BENT,
    CLEAR,
    FOLD,
    INSIDE,
    LOOSE,
    MERGED,
    NEARLY,
    ORTHOGONALITY,
    ROUNDED,
    SECOND,
    SPLIT,
    candidate,
    folds,
    merges_twice,
)

REPEATED, MEETING, CAREFUL, NONE, NO_POSE = -1.0, -2.0, -3.0, -4.0, -5.0
"""What is decided where the solutions are not distinct, isolated and exact; see `mafsil.ik.answers.facts.Decision`."""


@dataclass(frozen=True, eq=False)
class Row:
    """What is known of one branch.

    Attributes:
        residual, shortfall, free, code, margin, excess: see `mafsil.ik.closed_form`.
        second: the second smallest mark, one where there are not two.
        merged: how many of its marks are within `MERGED`, those counted that the arm does not have.
        merged_shoulder: whether the shoulder's is among them.
        free_first: whether a joint that is found before those of the wrist is free.
    """

    residual: ca.SX
    shortfall: ca.SX
    free: ca.SX
    code: ca.SX
    margin: ca.SX
    excess: ca.SX
    second: ca.SX
    merged: ca.SX
    merged_shoulder: ca.SX
    free_first: ca.SX


def decided(pattern: ArmPattern, rows: Sequence[Row], defect: ca.SX, tolerance: ca.SX) -> ca.SX:
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
    solved = sum((2.0**k * one for k, one in enumerate(good)), ca.SX(0))
    # 2. What asks for care.
    exact, most = ca.fmin(CLEAR, tolerance), ca.fmax(candidate(pattern), tolerance)
    between = [ca.logic_and(row.residual > exact, row.residual <= most) for row in rows]
    meets = [
        ca.logic_and(one, ca.logic_or(row.free > 0, row.margin <= MERGED)) for one, row in zip(good, rows, strict=True)
    ]
    allowed = _any([ca.logic_and(one, row.excess <= INSIDE) for one, row in zip(good, rows, strict=True)])
    lost = ca.logic_and(ca.logic_not(allowed), _any([row.free > 0 for row in rows]))
    nearly = ca.if_else(tolerance > LOOSE, 1e3 * tolerance, LOOSE)
    missed = ca.logic_and(ca.logic_not(found), _any([_least_miss(pattern, row) <= nearly for row in rows]))
    refine = _any([*between, *_folded(pattern, rows), lost, missed])
    if pattern.quartic:
        refine = _any([refine, ca.logic_not(found), *(row.margin <= FOLD for row in rows)])
    # 3. Rows that may repeat each other.
    close = _any([ca.logic_and(one, row.margin < APART) for one, row in zip(good, rows, strict=True)])
    repeated = ca.SX(1) if pattern.quartic or not pattern.plain else close
    # 4. Solutions that only have to be merged.
    twice = [_entangled(pattern, row) for row in rows]
    entangled = _any([ca.logic_and(one, worse) for one, worse in zip(meets, twice, strict=True)])
    careful = ca.logic_or(refine, entangled)
    decision = ca.if_else(repeated, REPEATED, solved)
    decision = ca.if_else(_any(meets), MEETING, decision)
    decision = ca.if_else(found, decision, NONE)
    decision = ca.if_else(careful, CAREFUL, decision)
    return ca.if_else(defect <= ORTHOGONALITY, decision, NO_POSE)


def _least_miss(pattern: ArmPattern, row: Row) -> ca.SX:
    """By how much the nearest configuration may miss: without an exact solution it may be within the tolerance."""
    nearest = ca.fmin(row.residual, row.shortfall)
    if pattern.n >= pattern.equations:
        return nearest
    # All steps may succeed and added joints move: only at folds does that say nothing.
    return ca.if_else(ca.logic_or(row.free > 0, row.margin <= FOLD), nearest, row.residual)


def _folded(pattern: ArmPattern, rows: Sequence[Row]) -> list[ca.SX]:
    """Which rows rounding may have moved off: two pairs of roots merge there and split again.

    A row that falls short while its other marks are large falls short indeed: what went before, with the mark m, is
    known to the rounding over m, and to its square root where that root merges as well.
    """
    if not folds(pattern):
        return []
    margins = [ca.if_else(row.residual <= CLEAR, row.margin, ca.inf) for row in rows]
    beside = reduce(ca.fmin, margins) <= BENT
    found: list[ca.SX] = []
    for row in rows:
        off = ca.logic_and(row.residual > CLEAR, row.residual <= SPLIT * pattern.size)
        merged = ca.logic_and(row.merged > 1, row.merged_shoulder) if merges_twice(pattern) else ca.SX(0)
        near = ca.logic_and(row.residual <= NEARLY * pattern.size, beside)
        near = ca.logic_and(near, row.residual * row.second**2 <= ROUNDED * pattern.size)
        found.append(ca.logic_and(off, ca.logic_or(merged, near)))
    return found


def _entangled(pattern: ArmPattern, row: Row) -> ca.SX:
    """Whether more meets at a solution than two branches, or a wrist that stands straight."""
    return _any([row.second <= SECOND, row.free_first, row.free >= 2.0**pattern.n])


def _any(conditions: Sequence[ca.SX]) -> ca.SX:
    return reduce(ca.logic_or, conditions)
