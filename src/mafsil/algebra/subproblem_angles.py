"""The canonical subproblems as tables of angles: a row (angles, residual, free) per root."""

from __future__ import annotations

import mafsil.expression as ex
from mafsil.algebra.spatial import cross
from mafsil.algebra.subproblem_quartics import linked_circles, revolute_point, two_revolutes
from mafsil.algebra.subproblems import (
    Root,
    Turn,
    turn_onto,
    turns_about_two_axes,
    turns_to_distance,
    turns_to_height,
    zero_turn,
)
from mafsil.algebra.tolerance import FREE


def distances(
    w: ex.Expression, r: ex.Expression, p: ex.Expression, o: ex.Expression, distance: ex.Expression
) -> ex.Expression:
    """(2, 3) turns about the axis w through r that bring p to a distance from o."""
    height = ex.dot(w, p - o)
    return _table(turns_to_distance(w, p - r, o - r, distance**2 - height**2, zero_turn()))


def heights(w: ex.Expression, h: ex.Expression, p: ex.Expression, height: ex.Expression) -> ex.Expression:
    """(2, 3) turns about w that bring p to a height along h."""
    return _table(turns_to_height(w, h, p, height, zero_turn()))


def two_axes(w1: ex.Expression, w2: ex.Expression, p: ex.Expression, z: ex.Expression) -> ex.Expression:
    """(2, 5) turns about w1 and w2 that bring p to z, and a zero; lengths that differ are a residual."""
    length = ex.fabs(ex.norm_2(p) - ex.norm_2(z))
    rows: list[ex.Expression] = []
    for pair in turns_about_two_axes(w1, w2, p, z, (zero_turn(), zero_turn())):
        free = ex.fmax(pair.first.free, pair.second.free)
        short = ex.if_else(length > FREE, length, pair.first.residual)
        rows.append(ex.horzcat(pair.first.turn.angle, pair.second.turn.angle, 0, short, free))
    return ex.vertcat(*rows)


def wrist(w4: ex.Expression, w5: ex.Expression, w6: ex.Expression, R: ex.Expression) -> ex.Expression:
    """(2, 5) turns about w4, w5, w6 that make the rotation R."""
    aside = cross(w6, w5)
    aside = aside / ex.sqrt(ex.dot(aside, aside))
    rows: list[ex.Expression] = []
    for pair in turns_about_two_axes(w4, w5, w6, R @ w6, (zero_turn(), zero_turn())):
        side = pair.second.turn.back().about(w5, pair.first.turn.back().about(w4, R @ aside))
        last = turn_onto(w6, aside, side, zero_turn())
        angles = (pair.first.turn.angle, pair.second.turn.angle, last.turn.angle)
        rows.append(ex.horzcat(*angles, pair.first.residual, pair.first.free))
    return ex.vertcat(*rows)


def three_axes(
    k1: ex.Expression,
    k2: ex.Expression,
    k3: ex.Expression,
    p0: ex.Expression,
    p1: ex.Expression,
    p2: ex.Expression,
    p3: ex.Expression,
) -> ex.Expression:
    """(4, 5) turns with p0 + Rot(k1, q1) p1 = Rot(k2, q2) (p2 + Rot(k3, q3) p3)."""
    zero = zero_turn()
    rows: list[ex.Expression] = []
    for first, second, third, free in two_revolutes(k1, k2, p0, p1, revolute_point(k3, p3, p2), (zero, zero, zero)):
        assert isinstance(first, Root)
        assert isinstance(second, Root)
        assert isinstance(third, Turn)
        left = p0 + first.turn.about(k1, p1)
        right = second.turn.about(k2, p2 + third.about(k3, p3))
        short = ex.sqrt(ex.sumsqr(left - right))
        loose = ex.fmax(free, ex.fmax(first.free, second.free))
        rows.append(ex.horzcat(first.turn.angle, second.turn.angle, third.angle, short, loose))
    return ex.vertcat(*rows)


def circles(A: ex.Expression, B: ex.Expression, b: ex.Expression) -> ex.Expression:
    """(4, 4) turns with A (cos q1, sin q1) + B (cos q2, sin q2) = b."""
    rows: list[ex.Expression] = []
    for first, second in linked_circles(A, B, b, (zero_turn(), zero_turn())):
        x, y = (ex.vertcat(root.turn.c, root.turn.s) for root in (first, second))
        short = ex.sqrt(ex.sumsqr(A @ x + B @ y - b))
        rows.append(ex.horzcat(first.turn.angle, second.turn.angle, short, ex.fmax(first.free, second.free)))
    return ex.vertcat(*rows)


def _table(roots: tuple[Root, Root]) -> ex.Expression:
    return ex.vertcat(*(ex.horzcat(root.turn.angle, root.residual, root.free) for root in roots))
