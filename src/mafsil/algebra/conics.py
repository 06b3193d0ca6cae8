"""Where a conic meets a circle or a parabola: the quartic equations of inverse kinematics, as expressions.

A point of the curve is x = (c, s, 1) on the unit circle or (d, d^2, 1) on the parabola; the conic is x' C x = 0. In the
pencil C + k D, D being the curve itself, three conics are pairs of lines; one pair of real lines carries all real
points that both have in common, and every line meets the curve twice. Where two points merge, nothing is divided by
their distance: the square root of one line reaches zero.

References: Richter-Gebert, Perspectives on Projective Geometry, 2011, section 11; Elias and Wen, IK-Geo, 2022.
"""

from __future__ import annotations

import casadi as ca

from mafsil.algebra.subproblems import Root, Turn

POLISH = 2
"""Newton steps on the equation itself, after the lines."""

NEARLY = 1e-6
"""Relative distance of a line from the curve up to which it may touch it but for rounding."""

NOTHING = 1e-12
"""Coefficients, relative to those they are made of, below which an equation says nothing."""


def turns_on_conic(C: ca.SX, preferred: Turn, scale: ca.SX) -> tuple[Root, Root, Root, Root]:
    """The turns with x' C x = 0, x = (cos q, sin q, 1).

    Args:
        C: (3, 3) symmetric.
        preferred: the turn taken where every one solves.
        scale: size of the terms of C before they cancelled; what is small beside it is nothing.
    """
    C, free = _scaled(C, scale)
    roots: list[Root] = []
    for line in _lines(C, ca.SX([[1, 0, 0], [0, 1, 0], [0, 0, -1]]), -1.0):
        size = ca.sqrt(line[0] ** 2 + line[1] ** 2)
        known = size > 0
        factor = 1 / ca.if_else(known, size, 1.0)
        middle = Turn(ca.if_else(known, line[0] * factor, 1.0), ca.if_else(known, line[1] * factor, 0.0))
        along = ca.fmin(ca.fmax(-line[2] * factor, -1), 1)
        aside = ca.sqrt((1 - along) * (1 + along))
        for side in (1.0, -1.0):
            turn = _polished(C, middle.then(Turn(along, side * aside)), ca.fabs(line[2]) <= size * (1 + NEARLY))
            turn = Turn(ca.if_else(free, preferred.c, turn.c), ca.if_else(free, preferred.s, turn.s))
            roots.append(Root(turn, free, ca.SX(0)))
    return roots[0], roots[1], roots[2], roots[3]


def lengths_on_conic(C: ca.SX, scale: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX, ca.SX]:
    """The lengths with x' C x = 0, x = (d, d^2, 1).

    Args:
        C: (3, 3) symmetric.
        scale: as for `turns_on_conic`.
    """
    C, _ = _scaled(C, scale)
    roots: list[ca.SX] = []
    for line in _lines(C, ca.SX([[1, 0, 0], [0, 0, -0.5], [0, -0.5, 0]]), -0.25):
        # line: a d + b d^2 + c = 0
        b, a, c = line[0] / 2, line[1], line[2]
        far = -(b + ca.if_else(b < 0, -1, 1) * ca.sqrt(ca.fmax(b * b - a * c, 0)))
        real = b * b * (1 + NEARLY) >= a * c
        for top, below in ((far, a), (c, far)):
            d = top / ca.if_else(below == 0, 1e-300, below)
            roots.append(_polished_length(C, d, real))
    return roots[0], roots[1], roots[2], roots[3]


def _scaled(C: ca.SX, scale: ca.SX) -> tuple[ca.SX, ca.SX]:
    """The conic with its largest coefficient one, and whether it says nothing."""
    largest = ca.SX(0)
    for i in range(3):
        for j in range(i, 3):
            largest = ca.fmax(largest, ca.fabs(C[i, j]))
    free = largest <= NOTHING * scale
    return C / ca.if_else(free, 1.0, largest), free


def _lines(C: ca.SX, D: ca.SX, det_D: float) -> tuple[ca.SX, ca.SX]:
    """(3,) and (3,) lines that carry the common points of two conics."""
    k = _parameter(C, D, det_D)
    A = C + k * D
    B = _adjugate(A)
    p, strength = ca.SX.zeros(3), ca.SX(-1)
    for i in range(3):
        better = -B[i, i] > strength
        root = ca.sqrt(ca.fmax(-B[i, i], 0))
        column = B[:, i] / ca.if_else(root > 0, root, 1.0)
        p, strength = (
            _chosen(better, ca.if_else(root > 0, 1.0, 0.0) * column, p),
            ca.if_else(better, -B[i, i], strength),
        )
    N = A + _hat(p)
    row, column = ca.SX.zeros(3), ca.SX.zeros(3)
    best_row, best_column = ca.SX(-1), ca.SX(-1)
    for i in range(3):
        r, c = N[i, :].T, N[:, i]
        size_r, size_c = ca.sumsqr(r), ca.sumsqr(c)
        row, best_row = _chosen(size_r > best_row, r, row), ca.fmax(size_r, best_row)
        column, best_column = _chosen(size_c > best_column, c, column), ca.fmax(size_c, best_column)
    return row, column


def _parameter(C: ca.SX, D: ca.SX, det_D: float) -> ca.SX:
    """The k for which C + k D is a pair of real lines, and det(C + k D) = 0 a root as simple as possible."""
    adj_C, adj_D = _adjugate(C), _adjugate(D)
    a = ca.trace(C @ adj_D) / det_D
    b = ca.trace(adj_C @ D) / det_D
    c = ca.dot(C[0, :].T, adj_C[:, 0]) / det_D
    best, quality = ca.SX(0), ca.SX(-1e300)
    for k in _cubic_roots(a, b, c):
        for _ in range(2):
            slope = (3 * k + 2 * a) * k + b
            step = (((k + a) * k + b) * k + c) / ca.if_else(slope == 0, 1.0, slope)
            k = k - ca.if_else(ca.fabs(step) < 1e-3 * (1 + ca.fabs(k)), step, 0.0)
        A = C + k * D
        real = -ca.trace(_adjugate(A))
        size = 1 + ca.fabs(k)
        slope = ca.fabs((3 * k + 2 * a) * k + b)
        worth = ca.if_else(real >= -1e-9 * size**2, slope, -1 + real / size**2)
        best, quality = ca.if_else(worth > quality, k, best), ca.fmax(worth, quality)
    return best


def _cubic_roots(a: ca.SX, b: ca.SX, c: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Real roots of k^3 + a k^2 + b k + c; three times the same where there is only one."""
    shift = a / 3
    P, Q = b / 3 - shift**2, shift * (shift**2 - b / 2) + c / 2  # t^3 + 3 P t + 2 Q
    discriminant = Q * Q + P * P * P
    three = discriminant <= 0
    angle = ca.atan2(ca.sqrt(ca.fmax(-discriminant, 0)), -Q) / 3
    radius = 2 * ca.sqrt(ca.fmax(-P, 0))
    size = ca.fabs(Q) + ca.sqrt(ca.fmax(discriminant, 0))
    u = ca.exp(ca.log(ca.fmax(size, 1e-300)) / 3) * ca.if_else(Q > 0, -1, 1)
    only = u - P / u
    third = 2.0943951023931953
    roots = [ca.if_else(three, radius * ca.cos(angle + i * third), only) - shift for i in (-1, 0, 1)]
    return roots[0], roots[1], roots[2]


def _polished(C: ca.SX, turn: Turn, real: ca.SX) -> Turn:
    """Newton steps for x' C x = 0 along the circle, kept only where they help and the line meets the circle.

    Else they would lead to a root that another line has.
    """
    miss = _value(C, ca.vertcat(turn.c, turn.s, 1))
    for _ in range(POLISH):
        x = ca.vertcat(turn.c, turn.s, 1)
        slope = 2 * ca.dot(C @ x, ca.vertcat(-turn.s, turn.c, 0))
        step = -miss / ca.if_else(slope == 0, 1.0, slope)
        step = ca.fmin(ca.fmax(step, -0.1), 0.1)
        half = step / 2
        rotated = turn.then(Turn((1 - half * half) / (1 + half * half), step / (1 + half * half)))
        after = _value(C, ca.vertcat(rotated.c, rotated.s, 1))
        better = ca.logic_and(real, ca.fabs(after) < ca.fabs(miss))
        turn = Turn(ca.if_else(better, rotated.c, turn.c), ca.if_else(better, rotated.s, turn.s))
        miss = ca.if_else(better, after, miss)
    return turn


def _polished_length(C: ca.SX, d: ca.SX, real: ca.SX) -> ca.SX:
    """The same along the parabola."""
    miss = _value(C, ca.vertcat(d, d * d, 1))
    for _ in range(POLISH):
        slope = 2 * ca.dot(C @ ca.vertcat(d, d * d, 1), ca.vertcat(1, 2 * d, 0))
        moved = d - miss / ca.if_else(slope == 0, 1.0, slope)
        after = _value(C, ca.vertcat(moved, moved * moved, 1))
        better = ca.logic_and(real, ca.fabs(after) < ca.fabs(miss))
        d, miss = ca.if_else(better, moved, d), ca.if_else(better, after, miss)
    return d


def _value(C: ca.SX, x: ca.SX) -> ca.SX:
    return ca.dot(x, C @ x)


def _adjugate(A: ca.SX) -> ca.SX:
    """(3, 3) of a symmetric matrix: A adj(A) = det(A) I."""
    a, b, c, d, e, f = A[0, 0], A[0, 1], A[0, 2], A[1, 1], A[1, 2], A[2, 2]
    xx, xy, xz = d * f - e * e, c * e - b * f, b * e - c * d
    yy, yz, zz = a * f - c * c, b * c - a * e, a * d - b * b
    return ca.vertcat(ca.horzcat(xx, xy, xz), ca.horzcat(xy, yy, yz), ca.horzcat(xz, yz, zz))


def _hat(p: ca.SX) -> ca.SX:
    return ca.vertcat(ca.horzcat(0, -p[2], p[1]), ca.horzcat(p[2], 0, -p[0]), ca.horzcat(-p[1], p[0], 0))


def _chosen(condition: ca.SX, yes: ca.SX, no: ca.SX) -> ca.SX:
    """Elementwise choice by one condition."""
    return ca.vertcat(*(ca.if_else(condition, yes[i], no[i]) for i in range(3)))
