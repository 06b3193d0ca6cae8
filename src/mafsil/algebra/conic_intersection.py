"""Where a conic meets a circle or a parabola: the quartic equations of inverse kinematics, as expressions.

A point of the curve is x = (c, s, 1) on the unit circle or (d, d^2, 1) on the parabola; the conic is x' C x = 0.

1. C is divided by its largest coefficient; where all of them are roundoff of larger terms, every x is a solution.
2. In the pencil C + k D, D being the curve itself, det(C + k D) = 0 for three k, where the conic is a pair of lines
   (`_parameter`). One pair of real lines carries all real points that both have in common.
3. That pair is taken apart into its two lines (`_lines`).
4. Every line meets the curve in two points, found by a square root: where two points merge it reaches zero, and nothing
   is divided by their distance.
5. Newton steps on x' C x = 0 along the curve take off the roundoff of steps 2 to 4 (`_polish`).

References: Richter-Gebert, Perspectives on Projective Geometry, 2011, section 11; Elias and Wen, IK-Geo, 2022.
"""

from __future__ import annotations

import mafsil.expression as ex
from mafsil.algebra.subproblems import Root, Turn
from mafsil.algebra.tolerance import DOUBLE_ROOT, VANISHING
from mafsil.floating_point import LEAST_DIVISOR

POLISH = 2
"""Newton steps on the equation itself, after the lines: each doubles the digits, of which the lines leave eight."""


def turns_on_conic(C: ex.Expression, preferred: Turn, scale: ex.Expression) -> tuple[Root, Root, Root, Root]:
    """The turns with x' C x = 0, x = (cos q, sin q, 1).

    Args:
        C: (3, 3) symmetric.
        preferred: the turn taken where every one solves.
        scale: size of the terms of C before they cancelled; what is small beside it is nothing.
    """
    C, free = _scale(C, scale)  # 1.
    roots: list[Root] = []
    # 2. and 3. The circle: c^2 + s^2 - 1 = 0, with determinant -1.
    for line in _lines(C, ex.Expression([[1, 0, 0], [0, 1, 0], [0, 0, -1]]), -1.0):
        # 4. l0 c + l1 s + l2 = 0: its points on the circle lie on either side of the direction (l0, l1), at the
        #    angle whose cosine is -l2 / |(l0, l1)|.
        size = ex.sqrt(line[0] ** 2 + line[1] ** 2)
        known = size > 0
        factor = 1 / ex.if_else(known, size, 1.0)
        middle = Turn(ex.if_else(known, line[0] * factor, 1.0), ex.if_else(known, line[1] * factor, 0.0))
        along = ex.fmin(ex.fmax(-line[2] * factor, -1), 1)
        aside = ex.sqrt((1 - along) * (1 + along))
        for side in (1.0, -1.0):
            # 5.
            turn = _polish(C, middle.then(Turn(along, side * aside)), ex.fabs(line[2]) <= size * (1 + DOUBLE_ROOT))
            turn = Turn(ex.if_else(free, preferred.c, turn.c), ex.if_else(free, preferred.s, turn.s))
            roots.append(Root(turn, free, ex.Expression(0)))
    return roots[0], roots[1], roots[2], roots[3]


def lengths_on_conic(
    C: ex.Expression, scale: ex.Expression
) -> tuple[ex.Expression, ex.Expression, ex.Expression, ex.Expression]:
    """The lengths with x' C x = 0, x = (d, d^2, 1).

    Args:
        C: (3, 3) symmetric.
        scale: as for `turns_on_conic`.
    """
    C, _ = _scale(C, scale)  # 1.
    roots: list[ex.Expression] = []
    # 2. and 3. The parabola: d^2 - (d^2) 1 = 0, with determinant -1/4.
    for line in _lines(C, ex.Expression([[1, 0, 0], [0, 0, -0.5], [0, -0.5, 0]]), -0.25):
        # 4. line: 2 b d + a d^2 + c = 0; the root of larger magnitude without cancellation, the other one from c / a.
        b, a, c = line[0] / 2, line[1], line[2]
        far = -(b + ex.if_else(b < 0, -1, 1) * ex.sqrt(ex.fmax(b * b - a * c, 0)))
        real = b * b * (1 + DOUBLE_ROOT) >= a * c
        for top, below in ((far, a), (c, far)):
            d = top / ex.if_else(ex.equal(below, 0), LEAST_DIVISOR, below)
            roots.append(_polished_length(C, d, real))
    return roots[0], roots[1], roots[2], roots[3]


def _scale(C: ex.Expression, scale: ex.Expression) -> tuple[ex.Expression, ex.Expression]:
    """The conic with its largest coefficient one, and whether it says nothing."""
    largest = ex.Expression(0)
    for i in range(3):
        for j in range(i, 3):
            largest = ex.fmax(largest, ex.fabs(C[i, j]))
    free = largest <= VANISHING * scale
    return C / ex.if_else(free, 1.0, largest), free


def _lines(C: ex.Expression, D: ex.Expression, det_D: float) -> tuple[ex.Expression, ex.Expression]:
    """(3,) and (3,) lines that carry the common points of two conics."""
    # A = l m' + m l' for lines l and m, with adj(A) = -p p', p = l x m: p is a column of the adjugate over the root of
    # its diagonal entry, the largest. Then A + [p] = 2 l m' (or 2 m l'): rows are multiples of one line, columns of the
    # other; the longest of each are taken.
    k = _parameter(C, D, det_D)
    A = C + k * D
    B = _adjugate(A)
    p, size = ex.zeros(3), ex.Expression(-1)
    for i in range(3):
        better = -B[i, i] > size
        root = ex.sqrt(ex.fmax(-B[i, i], 0))
        column = B[:, i] / ex.if_else(root > 0, root, 1.0)
        p, size = (
            _chosen(better, ex.if_else(root > 0, 1.0, 0.0) * column, p),
            ex.if_else(better, -B[i, i], size),
        )
    N = A + _hat(p)
    row, column = ex.zeros(3), ex.zeros(3)
    best_row, best_column = ex.Expression(-1), ex.Expression(-1)
    for i in range(3):
        r, c = N[i, :].T, N[:, i]
        size_r, size_c = ex.sumsqr(r), ex.sumsqr(c)
        row, best_row = _chosen(size_r > best_row, r, row), ex.fmax(size_r, best_row)
        column, best_column = _chosen(size_c > best_column, c, column), ex.fmax(size_c, best_column)
    return row, column


def _parameter(C: ex.Expression, D: ex.Expression, det_D: float) -> ex.Expression:
    """The k for which C + k D is a pair of real lines, and det(C + k D) = 0 a root as simple as possible."""
    # det(C + k D) / det D = k^3 + a k^2 + b k + c. Of its real roots, that with real lines (adj(A) = -p p', so its
    # trace is not positive) and the steepest slope: a double root of the cubic is known to half the digits only.
    adj_C, adj_D = _adjugate(C), _adjugate(D)
    a = ex.trace(C @ adj_D) / det_D
    b = ex.trace(adj_C @ D) / det_D
    c = ex.dot(C[0, :].T, adj_C[:, 0]) / det_D
    best, quality = ex.Expression(0), ex.Expression(-1e300)
    for k in _cubic_roots(a, b, c):
        # Two Newton steps; one that would lead away (at a double root the slope vanishes) is not taken.
        for _ in range(2):
            slope = (3 * k + 2 * a) * k + b
            step = (((k + a) * k + b) * k + c) / ex.if_else(ex.equal(slope, 0), 1.0, slope)
            k = k - ex.if_else(ex.fabs(step) < 1e-3 * (1 + ex.fabs(k)), step, 0.0)
        A = C + k * D
        real = -ex.trace(_adjugate(A))
        size = 1 + ex.fabs(k)
        slope = ex.fabs((3 * k + 2 * a) * k + b)
        worth = ex.if_else(real >= -1e-9 * size**2, slope, -1 + real / size**2)
        best, quality = ex.if_else(worth > quality, k, best), ex.fmax(worth, quality)
    return best


def _cubic_roots(
    a: ex.Expression, b: ex.Expression, c: ex.Expression
) -> tuple[ex.Expression, ex.Expression, ex.Expression]:
    """Real roots of k^3 + a k^2 + b k + c; three times the same where there is only one."""
    shift = a / 3
    P, Q = b / 3 - shift**2, shift * (shift**2 - b / 2) + c / 2  # t^3 + 3 P t + 2 Q
    discriminant = Q * Q + P * P * P
    three = discriminant <= 0
    angle = ex.atan2(ex.sqrt(ex.fmax(-discriminant, 0)), -Q) / 3
    radius = 2 * ex.sqrt(ex.fmax(-P, 0))
    size = ex.fabs(Q) + ex.sqrt(ex.fmax(discriminant, 0))
    u = ex.exp(ex.log(ex.fmax(size, LEAST_DIVISOR)) / 3) * ex.if_else(Q > 0, -1, 1)
    only = u - P / u
    third = 2.0943951023931953
    roots = [ex.if_else(three, radius * ex.cos(angle + i * third), only) - shift for i in (-1, 0, 1)]
    return roots[0], roots[1], roots[2]


def _polish(C: ex.Expression, turn: Turn, real: ex.Expression) -> Turn:
    """Newton steps for x' C x = 0 along the circle, kept only where they help and the line meets the circle.

    Else they would lead to a root that another line has.
    """
    error = _value(C, ex.vertcat(turn.c, turn.s, 1))
    for _ in range(POLISH):
        x = ex.vertcat(turn.c, turn.s, 1)
        slope = 2 * ex.dot(C @ x, ex.vertcat(-turn.s, turn.c, 0))
        step = -error / ex.if_else(ex.equal(slope, 0), 1.0, slope)
        step = ex.fmin(ex.fmax(step, -0.1), 0.1)
        half = step / 2
        rotated = turn.then(Turn((1 - half * half) / (1 + half * half), step / (1 + half * half)))
        after = _value(C, ex.vertcat(rotated.c, rotated.s, 1))
        better = ex.logic_and(real, ex.fabs(after) < ex.fabs(error))
        turn = Turn(ex.if_else(better, rotated.c, turn.c), ex.if_else(better, rotated.s, turn.s))
        error = ex.if_else(better, after, error)
    return turn


def _polished_length(C: ex.Expression, d: ex.Expression, real: ex.Expression) -> ex.Expression:
    """The same along the parabola."""
    error = _value(C, ex.vertcat(d, d * d, 1))
    for _ in range(POLISH):
        slope = 2 * ex.dot(C @ ex.vertcat(d, d * d, 1), ex.vertcat(1, 2 * d, 0))
        moved = d - error / ex.if_else(ex.equal(slope, 0), 1.0, slope)
        after = _value(C, ex.vertcat(moved, moved * moved, 1))
        better = ex.logic_and(real, ex.fabs(after) < ex.fabs(error))
        d, error = ex.if_else(better, moved, d), ex.if_else(better, after, error)
    return d


def _value(C: ex.Expression, x: ex.Expression) -> ex.Expression:
    return ex.dot(x, C @ x)


def _adjugate(A: ex.Expression) -> ex.Expression:
    """(3, 3) of a symmetric matrix: A adj(A) = det(A) I."""
    a, b, c, d, e, f = A[0, 0], A[0, 1], A[0, 2], A[1, 1], A[1, 2], A[2, 2]
    xx, xy, xz = d * f - e * e, c * e - b * f, b * e - c * d
    yy, yz, zz = a * f - c * c, b * c - a * e, a * d - b * b
    return ex.vertcat(ex.horzcat(xx, xy, xz), ex.horzcat(xy, yy, yz), ex.horzcat(xz, yz, zz))


def _hat(p: ex.Expression) -> ex.Expression:
    return ex.vertcat(ex.horzcat(0, -p[2], p[1]), ex.horzcat(p[2], 0, -p[0]), ex.horzcat(-p[1], p[0], 0))


def _chosen(condition: ex.Expression, yes: ex.Expression, no: ex.Expression) -> ex.Expression:
    """Elementwise choice by one condition."""
    return ex.vertcat(*(ex.if_else(condition, yes[i], no[i]) for i in range(3)))
