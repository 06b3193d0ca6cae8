"""Subproblems with up to four solutions, as expressions: three general joints place a point, two circles are linked.

What moves with the last joint is linear in x = (cos q, sin q, 1) of a turn and in x = (d, d^2, 1) of a slide; the other
joints are eliminated by what they keep (heights, distances), which leaves one conic x' C x = 0.

References: Pieper, 1968; Elias and Wen, IK-Geo, 2022 (subproblems 5 and 6).
"""

from __future__ import annotations

from typing import NamedTuple

import casadi as ca

from mafsil.algebra.conics import lengths_on_conic, turns_on_conic
from mafsil.algebra.spatial import cross
from mafsil.algebra.subproblems import Root, Turn, turn_onto


class Course(NamedTuple):
    """A point moved by one joint: linear in x.

    Attributes:
        point: (3, 3) the point is `point @ x`.
        square: (3,) its squared length is `square . x`.
        slides: whether x is that of a slide.
        size: a length the terms were made of [m].
    """

    point: ca.SX
    square: ca.SX
    slides: bool
    size: ca.SX

    def solutions(self, C: ca.SX, scale: ca.SX, preferred: Turn) -> list[tuple[Turn | ca.SX, ca.SX, ca.SX]]:
        """The four motions with x' C x = 0, each as (motion, x, free)."""
        if self.slides:
            return [(d, ca.vertcat(d, d * d, 1), ca.SX(0)) for d in lengths_on_conic(C, scale)]
        roots = turns_on_conic(C, preferred, scale)
        return [(root.turn, ca.vertcat(root.turn.c, root.turn.s, 1), root.free) for root in roots]


def turning(k: ca.SX, p: ca.SX, offset: ca.SX) -> Course:
    """The course of `offset + Rot(k, q) p`."""
    along = ca.dot(k, p) * k
    A, B, rest = p - along, cross(k, p), offset + along
    square = ca.vertcat(2 * ca.dot(rest, A), 2 * ca.dot(rest, B), ca.dot(A, A) + ca.dot(rest, rest))
    return Course(ca.horzcat(A, B, rest), square, False, ca.sqrt(ca.sumsqr(p)) + ca.sqrt(ca.sumsqr(offset)))


def sliding(w: ca.SX, offset: ca.SX) -> Course:
    """The course of `offset + d w`, w a unit vector."""
    square = ca.vertcat(2 * ca.dot(w, offset), 1, ca.dot(offset, offset))
    return Course(ca.horzcat(w, ca.SX.zeros(3), offset), square, True, ca.sqrt(ca.sumsqr(offset)))


class Triple(NamedTuple):
    """Two further motions with the one that was found from the conic, and the largest shortfall."""

    first: Root | ca.SX
    second: Root | ca.SX
    third: Turn | ca.SX
    free: ca.SX


def two_turns(
    k1: ca.SX,
    k2: ca.SX,
    p0: ca.SX,
    p1: ca.SX,
    course: Course,
    preferred: tuple[Turn, Turn, Turn],
    scale: ca.SX | float = 1.0,
) -> list[Triple]:
    """Subproblem 5: p0 + Rot(k1, q1) p1 = Rot(k2, q2) v, v on a course; axes neither parallel nor meeting.

    With p0 along the common normal of both axes: k1 . and |.|^2 of  Rot(k2, q2) v - p0 = Rot(k1, q1) p1  are linear in
    X = Rot(k2, q2) v, whose part normal to k2 therefore is linear in x, and as long as that of v.

    Args:
        k1, k2: (3,) unit axes through the origin.
        p0, p1: (3,) [m].
        course: of v, in x.
        preferred: the turns taken where every one solves.
        scale: size of the arm [m].
    """
    k = ca.dot(k1, k2)
    sine2 = 1 - k * k
    sine = ca.sqrt(sine2)
    a, b = ca.dot(p0, k1), ca.dot(p0, k2)
    # p0 = alpha k1 + beta k2 + m n; its parts along the axes move with them.
    alpha, beta = (a - k * b) / sine2, (b - k * a) / sine2
    p1 = p1 + alpha * k1
    V = course.point - ca.horzcat(ca.SX.zeros(3, 2), beta * k2)
    square = course.square - 2 * beta * (k2.T @ course.point).T + ca.vertcat(0, 0, beta * beta)
    e1 = (k1 - k * k2) / sine
    e2 = cross(k2, e1)
    m = ca.dot(p0, e2)
    one = ca.SX([0, 0, 1])
    height = (k2.T @ V).T
    X1 = (ca.dot(k1, p1) * one - k * height) / sine
    X2m = (square + (m * m - ca.dot(p1, p1)) * one) / 2
    C = m * m * (_outer(X1) + _outer(height) - _squares(V)) + _outer(X2m)
    size = course.size + ca.sqrt(ca.sumsqr(p1)) + ca.sqrt(ca.sumsqr(p0))
    triples: list[Triple] = []
    for motion, x, free in course.solutions(C, size**4, preferred[2]):
        v = V @ x
        X = ca.dot(X1, x) * e1 + ca.dot(X2m, x) / m * e2 + ca.dot(height, x) * k2
        second = turn_onto(k2, v, X, preferred[1], scale)
        reached = second.turn.about(k2, v)
        first = turn_onto(k1, p1, reached - m * e2, preferred[0], scale)
        triples.append(Triple(first, second, motion, free))
    return triples


def slide_then_turn(
    w1: ca.SX, k2: ca.SX, goal: ca.SX, course: Course, preferred: tuple[Turn, Turn, Turn], scale: ca.SX | float = 1.0
) -> list[Triple]:
    """Goal - d w1 = Rot(k2, q2) v, v on a course; w1 not normal to k2.

    Args:
        w1, k2: (3,) unit direction of the slide, unit axis through the origin.
        goal: (3,) [m].
        course: of v, in x.
        preferred: the turns taken where every one solves.
        scale: size of the arm [m].
    """
    k = ca.dot(w1, k2)
    one = ca.SX([0, 0, 1])
    height = (k2.T @ course.point).T
    kd = ca.dot(k2, goal) * one - height
    X = k * (goal @ one.T) - w1 @ kd.T
    C = _squares(X) - k * k * _squares(course.point)
    triples: list[Triple] = []
    for motion, x, free in course.solutions(C, (course.size + ca.sqrt(ca.sumsqr(goal))) ** 2, preferred[2]):
        second = turn_onto(k2, course.point @ x, X @ x / k, preferred[1], scale)
        triples.append(Triple(ca.dot(kd, x) / k, second, motion, free))
    return triples


def turn_then_slide(
    k1: ca.SX, w2: ca.SX, p1: ca.SX, course: Course, preferred: tuple[Turn, Turn, Turn], scale: ca.SX | float = 1.0
) -> list[Triple]:
    """Rot(k1, q1) p1 = v + d w2, v on a course; w2 not normal to k1.

    Args:
        k1, w2: (3,) unit axis through the origin, unit direction of the slide.
        p1: (3,) [m].
        course: of v, in x.
        preferred: the turns taken where every one solves.
        scale: size of the arm [m].
    """
    k = ca.dot(k1, w2)
    one = ca.SX([0, 0, 1])
    kd = ca.dot(k1, p1) * one - (k1.T @ course.point).T
    X = k * course.point + w2 @ kd.T
    C = _squares(X) - k * k * ca.dot(p1, p1) * _outer(one)
    triples: list[Triple] = []
    for motion, x, free in course.solutions(C, (course.size + ca.sqrt(ca.sumsqr(p1))) ** 2, preferred[2]):
        first = turn_onto(k1, p1, X @ x / k, preferred[0], scale)
        triples.append(Triple(first, ca.dot(kd, x) / k, motion, free))
    return triples


def two_slides(w1: ca.SX, w2: ca.SX, goal: ca.SX, course: Course, preferred: tuple[Turn, Turn, Turn]) -> list[Triple]:
    """Goal - d1 w1 = v + d2 w2, v on a course: only the height across both slides counts.

    Args:
        w1, w2: (3,) unit directions, not parallel.
        goal: (3,) [m].
        course: of v, in x.
        preferred: the turns taken where every one solves.
    """
    normal = cross(w1, w2)
    one = ca.SX([0, 0, 1])
    line = (normal.T @ course.point).T - ca.dot(normal, goal) * one
    # The line times that at infinity, which meets no point of the curve that counts.
    C = (line @ one.T + one @ line.T) / 2
    triples: list[Triple] = []
    for motion, x, free in course.solutions(C, course.size + ca.sqrt(ca.sumsqr(goal)), preferred[2]):
        rest = goal - course.point @ x
        k = ca.dot(w1, w2)
        a, b = ca.dot(w1, rest), ca.dot(w2, rest)
        triples.append(Triple((a - k * b) / (1 - k * k), (b - k * a) / (1 - k * k), motion, free))
    return triples


class Linked(NamedTuple):
    """One solution of two linked circles."""

    first: Root
    second: Root


def linked_circles(A: ca.SX, B: ca.SX, b: ca.SX, preferred: tuple[Turn, Turn]) -> list[Linked]:
    """Subproblem 6: A (cos q1, sin q1) + B (cos q2, sin q2) = b; B regular, up to four solutions.

    (cos q2, sin q2) = B^-1 (b - A (cos q1, sin q1)) is of length one.

    Args:
        A, B: (2, 2).
        b: (2,).
        preferred: the turns taken where every one solves.
    """
    det = B[0, 0] * B[1, 1] - B[0, 1] * B[1, 0]
    adj = ca.vertcat(ca.horzcat(B[1, 1], -B[0, 1]), ca.horzcat(-B[1, 0], B[0, 0]))
    X = adj @ ca.horzcat(-A, b)
    C = _squares(X) - det * det * _outer(ca.SX([0, 0, 1]))
    scale = ca.sumsqr(adj) * (ca.sumsqr(A) + ca.sumsqr(b)) + det * det
    found: list[Linked] = []
    for root in turns_on_conic(C, preferred[0], scale):
        y = X @ ca.vertcat(root.turn.c, root.turn.s, 1) * ca.sign(det)
        size = ca.sqrt(ca.sumsqr(y))
        known = size > 0
        factor = 1 / ca.if_else(known, size, 1.0)
        second = Turn(
            ca.if_else(known, y[0] * factor, preferred[1].c), ca.if_else(known, y[1] * factor, preferred[1].s)
        )
        found.append(Linked(root, Root(second, ca.logic_not(known), ca.SX(0))))
    return found


def _outer(x: ca.SX) -> ca.SX:
    """(3, 3) the square of a linear form."""
    return x @ x.T


def _squares(V: ca.SX) -> ca.SX:
    """(3, 3) the squared length of linear forms, one a row."""
    return V.T @ V
