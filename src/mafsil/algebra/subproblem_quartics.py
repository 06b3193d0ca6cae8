"""Subproblems with up to four solutions, as expressions: three general joints place a point, two circles are linked.

1. The point that the third joint moves is linear in x: (cos q, sin q, 1) of a revolute joint, (d, d^2, 1) of a
   prismatic one; and so is its squared length, since cos^2 + sin^2 = 1 and d^2 is an entry of its own (`MovedPoint`).
2. The first two joints are eliminated by what they leave as it is: a revolute one heights along its axis and distances
   from it, a prismatic one the components across it. Where two such invariants are linear in x, the length of a vector
   that is given twice leaves one equation of second degree: the conic x' C x = 0.
3. The conic meets the curve of x in up to four points (`conic_intersection`): the motions of the third joint.
4. With each of them the point is known; the first two joints follow by angles between known vectors.

All canonical subproblems also stand here as tables of angles: a row (angles, residual, free) per root.

References: Pieper, 1968; Elias and Wen, IK-Geo, 2022 (subproblems 5 and 6).
"""

from __future__ import annotations

from typing import NamedTuple

import mafsil.expression as ex
from mafsil.algebra.conic_intersection import lengths_on_conic, turns_on_conic
from mafsil.algebra.spatial import cross
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


class MovedPoint(NamedTuple):
    """A point moved by one joint, in x = (cos q, sin q, 1) or (d, d^2, 1).

    Attributes:
        point: (3, 3) the point is `point @ x`.
        square: (3,) its squared length is `square . x`.
        prismatic: whether x is that of a prismatic joint.
        size: a length the terms were made of [m].
    """

    point: ex.Expression
    square: ex.Expression
    prismatic: bool
    size: ex.Expression

    def solutions(
        self, C: ex.Expression, scale: ex.Expression, preferred: Turn
    ) -> list[tuple[Turn | ex.Expression, ex.Expression, ex.Expression]]:
        """The four motions with x' C x = 0, each as (motion, x, free)."""
        if self.prismatic:
            return [(d, ex.vertcat(d, d * d, 1), ex.Expression(0)) for d in lengths_on_conic(C, scale)]
        roots = turns_on_conic(C, preferred, scale)
        return [(root.turn, ex.vertcat(root.turn.c, root.turn.s, 1), root.free) for root in roots]


def revolute_point(k: ex.Expression, p: ex.Expression, offset: ex.Expression) -> MovedPoint:
    """offset + Rot(k, q) p: the part of p along k stays, the rest turns."""
    along = ex.dot(k, p) * k
    A, B, rest = p - along, cross(k, p), offset + along
    square = ex.vertcat(2 * ex.dot(rest, A), 2 * ex.dot(rest, B), ex.dot(A, A) + ex.dot(rest, rest))
    return MovedPoint(ex.horzcat(A, B, rest), square, False, ex.sqrt(ex.sumsqr(p)) + ex.sqrt(ex.sumsqr(offset)))


def prismatic_point(w: ex.Expression, offset: ex.Expression) -> MovedPoint:
    """offset + d w, w a unit vector."""
    square = ex.vertcat(2 * ex.dot(w, offset), 1, ex.dot(offset, offset))
    return MovedPoint(ex.horzcat(w, ex.zeros(3), offset), square, True, ex.sqrt(ex.sumsqr(offset)))


class Triple(NamedTuple):
    """Two further motions with the one that was found from the conic, and the largest residual."""

    first: Root | ex.Expression
    second: Root | ex.Expression
    third: Turn | ex.Expression
    free: ex.Expression


def two_revolutes(
    k1: ex.Expression,
    k2: ex.Expression,
    p0: ex.Expression,
    p1: ex.Expression,
    moved: MovedPoint,
    preferred: tuple[Turn, Turn, Turn],
    scale: ex.Expression | float = 1.0,
) -> list[Triple]:
    """Subproblem 5: p0 + Rot(k1, q1) p1 = Rot(k2, q2) v, v the moved point; axes neither parallel nor meeting.

    With p0 along the common normal of both axes: k1 . and |.|^2 of  Rot(k2, q2) v - p0 = Rot(k1, q1) p1  are linear in
    X = Rot(k2, q2) v, whose part normal to k2 therefore is linear in x, and as long as that of v.

    Args:
        k1, k2: (3,) unit axes through the origin.
        p0, p1: (3,) [m].
        moved: v, in x.
        preferred: the turns taken where every one solves.
        scale: size of the arm [m].
    """
    # The common normal: p0 as parts along both axes and across, the first two moved over to p1 and v.
    k = ex.dot(k1, k2)
    sine2 = 1 - k * k
    sine = ex.sqrt(sine2)
    a, b = ex.dot(p0, k1), ex.dot(p0, k2)
    # p0 = alpha k1 + beta k2 + m e2, e2 along the common normal.
    alpha, beta = (a - k * b) / sine2, (b - k * a) / sine2
    p1 = p1 + alpha * k1
    V = moved.point - ex.horzcat(ex.zeros(3, 2), beta * k2)
    square = moved.square - 2 * beta * (k2.T @ moved.point).T + ex.vertcat(0, 0, beta * beta)
    # X = X1 e1 + X2 e2 + height k2 with linear forms X1 and X2m = m X2: k1 . X from the height along k1, e2 . X from
    # the squared length. |X|^2 = |v|^2, times m^2, is the conic.
    e1 = (k1 - k * k2) / sine
    e2 = cross(k2, e1)
    m = ex.dot(p0, e2)
    one = ex.Expression([0, 0, 1])
    height = (k2.T @ V).T
    X1 = (ex.dot(k1, p1) * one - k * height) / sine
    X2m = (square + (m * m - ex.dot(p1, p1)) * one) / 2
    C = m * m * (_outer(X1) + _outer(height) - _squares(V)) + _outer(X2m)
    # Terms of C are lengths to the fourth.
    size = moved.size + ex.sqrt(ex.sumsqr(p1)) + ex.sqrt(ex.sumsqr(p0))
    triples: list[Triple] = []
    for motion, x, free in moved.solutions(C, size**4, preferred[2]):
        v = V @ x
        X = ex.dot(X1, x) * e1 + ex.dot(X2m, x) / m * e2 + ex.dot(height, x) * k2
        second = turn_onto(k2, v, X, preferred[1], scale)
        reached = second.turn.about(k2, v)
        first = turn_onto(k1, p1, reached - m * e2, preferred[0], scale)
        triples.append(Triple(first, second, motion, free))
    return triples


def prismatic_then_revolute(
    w1: ex.Expression,
    k2: ex.Expression,
    goal: ex.Expression,
    moved: MovedPoint,
    preferred: tuple[Turn, Turn, Turn],
    scale: ex.Expression | float = 1.0,
) -> list[Triple]:
    """goal - d w1 = Rot(k2, q2) v, v the moved point; w1 not normal to k2.

    Args:
        w1, k2: (3,) unit direction of the prismatic joint, unit axis through the origin.
        goal: (3,) [m].
        moved: v, in x.
        preferred: the turns taken where every one solves.
        scale: size of the arm [m].
    """
    k = ex.dot(w1, k2)
    one = ex.Expression([0, 0, 1])
    height = (k2.T @ moved.point).T
    kd = ex.dot(k2, goal) * one - height
    X = k * (goal @ one.T) - w1 @ kd.T
    C = _squares(X) - k * k * _squares(moved.point)
    triples: list[Triple] = []
    for motion, x, free in moved.solutions(C, (moved.size + ex.sqrt(ex.sumsqr(goal))) ** 2, preferred[2]):
        second = turn_onto(k2, moved.point @ x, X @ x / k, preferred[1], scale)
        triples.append(Triple(ex.dot(kd, x) / k, second, motion, free))
    return triples


def revolute_then_prismatic(
    k1: ex.Expression,
    w2: ex.Expression,
    p1: ex.Expression,
    moved: MovedPoint,
    preferred: tuple[Turn, Turn, Turn],
    scale: ex.Expression | float = 1.0,
) -> list[Triple]:
    """Rot(k1, q1) p1 = v + d w2, v the moved point; w2 not normal to k1.

    Args:
        k1, w2: (3,) unit axis through the origin, unit direction of the prismatic joint.
        p1: (3,) [m].
        moved: v, in x.
        preferred: the turns taken where every one solves.
        scale: size of the arm [m].
    """
    k = ex.dot(k1, w2)
    one = ex.Expression([0, 0, 1])
    kd = ex.dot(k1, p1) * one - (k1.T @ moved.point).T
    X = k * moved.point + w2 @ kd.T
    C = _squares(X) - k * k * ex.dot(p1, p1) * _outer(one)
    triples: list[Triple] = []
    for motion, x, free in moved.solutions(C, (moved.size + ex.sqrt(ex.sumsqr(p1))) ** 2, preferred[2]):
        first = turn_onto(k1, p1, X @ x / k, preferred[0], scale)
        triples.append(Triple(first, ex.dot(kd, x) / k, motion, free))
    return triples


def two_prismatics(
    w1: ex.Expression, w2: ex.Expression, goal: ex.Expression, moved: MovedPoint, preferred: tuple[Turn, Turn, Turn]
) -> list[Triple]:
    """goal - d1 w1 = v + d2 w2, v on a moved: only the height across both directions counts.

    Args:
        w1, w2: (3,) unit directions, not parallel.
        goal: (3,) [m].
        moved: v, in x.
        preferred: the turns taken where every one solves.
    """
    normal = cross(w1, w2)
    one = ex.Expression([0, 0, 1])
    line = (normal.T @ moved.point).T - ex.dot(normal, goal) * one
    # The line times that at infinity, which meets no point of the curve that counts.
    C = (line @ one.T + one @ line.T) / 2
    triples: list[Triple] = []
    for motion, x, free in moved.solutions(C, moved.size + ex.sqrt(ex.sumsqr(goal)), preferred[2]):
        rest = goal - moved.point @ x
        k = ex.dot(w1, w2)
        a, b = ex.dot(w1, rest), ex.dot(w2, rest)
        triples.append(Triple((a - k * b) / (1 - k * k), (b - k * a) / (1 - k * k), motion, free))
    return triples


class Linked(NamedTuple):
    """One solution of two linked circles."""

    first: Root
    second: Root


def linked_circles(A: ex.Expression, B: ex.Expression, b: ex.Expression, preferred: tuple[Turn, Turn]) -> list[Linked]:
    """Subproblem 6: A (cos q1, sin q1) + B (cos q2, sin q2) = b; B regular, up to four solutions.

    (cos q2, sin q2) = B^-1 (b - A (cos q1, sin q1)) is of length one.

    Args:
        A, B: (2, 2).
        b: (2,).
        preferred: the turns taken where every one solves.
    """
    det = B[0, 0] * B[1, 1] - B[0, 1] * B[1, 0]
    adj = ex.vertcat(ex.horzcat(B[1, 1], -B[0, 1]), ex.horzcat(-B[1, 0], B[0, 0]))
    X = adj @ ex.horzcat(-A, b)
    C = _squares(X) - det * det * _outer(ex.Expression([0, 0, 1]))
    scale = ex.sumsqr(adj) * (ex.sumsqr(A) + ex.sumsqr(b)) + det * det
    found: list[Linked] = []
    for root in turns_on_conic(C, preferred[0], scale):
        y = X @ ex.vertcat(root.turn.c, root.turn.s, 1) * ex.sign(det)
        size = ex.sqrt(ex.sumsqr(y))
        known = size > 0
        factor = 1 / ex.if_else(known, size, 1.0)
        second = Turn(
            ex.if_else(known, y[0] * factor, preferred[1].c), ex.if_else(known, y[1] * factor, preferred[1].s)
        )
        found.append(Linked(root, Root(second, ex.logic_not(known), ex.Expression(0))))
    return found


def _outer(x: ex.Expression) -> ex.Expression:
    """(3, 3) the square of a linear form."""
    return x @ x.T


def _squares(V: ex.Expression) -> ex.Expression:
    """(3, 3) the squared length of linear forms, one a row."""
    return V.T @ V


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
