"""The canonical subproblems as tables of angles: a row (angles, shortfall, free) per root."""

from __future__ import annotations

import casadi as ca

from mafsil.algebra.spatial import cross
from mafsil.algebra.subproblem_quartics import linked_circles, turning, two_turns
from mafsil.algebra.subproblems import (
    Root,
    Turn,
    turn_onto,
    turns_about_two_axes,
    turns_to_distance,
    turns_to_height,
    unturned,
)


def distances(w: ca.SX, r: ca.SX, p: ca.SX, o: ca.SX, distance: ca.SX) -> ca.SX:
    """(2, 3) turns about the axis w through r that bring p to a distance from o."""
    height = ca.dot(w, p - o)
    return _table(turns_to_distance(w, p - r, o - r, distance**2 - height**2, unturned()))


def heights(w: ca.SX, h: ca.SX, p: ca.SX, height: ca.SX) -> ca.SX:
    """(2, 3) turns about w that bring p to a height along h."""
    return _table(turns_to_height(w, h, p, height, unturned()))


def two_axes(w1: ca.SX, w2: ca.SX, p: ca.SX, z: ca.SX) -> ca.SX:
    """(2, 5) turns about w1 and w2 that bring p to z, and a zero; lengths that differ are a shortfall."""
    length = ca.fabs(ca.norm_2(p) - ca.norm_2(z))
    rows: list[ca.SX] = []
    for pair in turns_about_two_axes(w1, w2, p, z, (unturned(), unturned())):
        free = ca.fmax(pair.first.free, pair.second.free)
        short = ca.if_else(length > 1e-9, length, pair.first.shortfall)
        rows.append(ca.horzcat(pair.first.turn.angle, pair.second.turn.angle, 0, short, free))
    return ca.vertcat(*rows)


def wrist(w4: ca.SX, w5: ca.SX, w6: ca.SX, R: ca.SX) -> ca.SX:
    """(2, 5) turns about w4, w5, w6 that make the rotation R."""
    aside = cross(w6, w5)
    aside = aside / ca.sqrt(ca.dot(aside, aside))
    rows: list[ca.SX] = []
    for pair in turns_about_two_axes(w4, w5, w6, R @ w6, (unturned(), unturned())):
        side = pair.second.turn.back().about(w5, pair.first.turn.back().about(w4, R @ aside))
        last = turn_onto(w6, aside, side, unturned())
        angles = (pair.first.turn.angle, pair.second.turn.angle, last.turn.angle)
        rows.append(ca.horzcat(*angles, pair.first.shortfall, pair.first.free))
    return ca.vertcat(*rows)


def three_axes(k1: ca.SX, k2: ca.SX, k3: ca.SX, p0: ca.SX, p1: ca.SX, p2: ca.SX, p3: ca.SX) -> ca.SX:
    """(4, 5) turns with p0 + Rot(k1, q1) p1 = Rot(k2, q2) (p2 + Rot(k3, q3) p3)."""
    zero = unturned()
    rows: list[ca.SX] = []
    for first, second, third, free in two_turns(k1, k2, p0, p1, turning(k3, p3, p2), (zero, zero, zero)):
        assert isinstance(first, Root)
        assert isinstance(second, Root)
        assert isinstance(third, Turn)
        left = p0 + first.turn.about(k1, p1)
        right = second.turn.about(k2, p2 + third.about(k3, p3))
        short = ca.sqrt(ca.sumsqr(left - right))
        loose = ca.fmax(free, ca.fmax(first.free, second.free))
        rows.append(ca.horzcat(first.turn.angle, second.turn.angle, third.angle, short, loose))
    return ca.vertcat(*rows)


def circles(A: ca.SX, B: ca.SX, b: ca.SX) -> ca.SX:
    """(4, 4) turns with A (cos q1, sin q1) + B (cos q2, sin q2) = b."""
    rows: list[ca.SX] = []
    for first, second in linked_circles(A, B, b, (unturned(), unturned())):
        x, y = (ca.vertcat(root.turn.c, root.turn.s) for root in (first, second))
        short = ca.sqrt(ca.sumsqr(A @ x + B @ y - b))
        rows.append(ca.horzcat(first.turn.angle, second.turn.angle, short, ca.fmax(first.free, second.free)))
    return ca.vertcat(*rows)


def _table(roots: tuple[Root, Root]) -> ca.SX:
    return ca.vertcat(*(ca.horzcat(root.turn.angle, root.shortfall, root.free) for root in roots))
