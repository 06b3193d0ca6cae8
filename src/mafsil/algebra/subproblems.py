"""Canonical subproblems of inverse kinematics as expressions: which turns about known axes bring points together?

A turn is kept as (cosine, sine); the angle is taken only at the end. Where a subproblem has no solution the turn is
that of the nearest miss, and `residual` says by how much it misses; where every angle solves it, `free` is one and the
turn is the one preferred.

References: Paden, Kinematics and Control of Robot Manipulators, 1986; Elias and Wen, IK-Geo, 2022 (numbers 1 to 4).
"""

from __future__ import annotations

from typing import NamedTuple

import mafsil.expression as ex
from mafsil.algebra.spatial import cross
from mafsil.algebra.tolerance import FREE as FREE


class Turn(NamedTuple):
    """Cosine and sine of an angle."""

    c: ex.Expression
    s: ex.Expression

    def about(self, w: ex.Expression, x: ex.Expression) -> ex.Expression:
        """(3,) vector x turned about the unit axis w through the origin."""
        along = ex.dot(w, x) * w
        return along + self.c * (x - along) + self.s * cross(w, x)

    def then(self, other: Turn) -> Turn:
        """The sum of both angles."""
        return Turn(self.c * other.c - self.s * other.s, self.s * other.c + self.c * other.s)

    def back(self) -> Turn:
        """The opposite angle."""
        return Turn(self.c, -self.s)

    @property
    def angle(self) -> ex.Expression:
        """The angle in (-pi, pi]."""
        return ex.atan2(self.s, self.c)


class Root(NamedTuple):
    """One solution of a subproblem in one unknown.

    Attributes:
        turn: the angle.
        free: one where every angle solves.
        residual: how far the nearest miss misses, zero where the subproblem is solved.
        inside: zero where a given distance is too long; where it is too short, one, or two if because the point that
            is turned is farther from the axis than that from which is measured.
    """

    turn: Turn
    free: ex.Expression
    residual: ex.Expression
    inside: ex.Expression | float = 0.0


def zero_turn() -> Turn:
    """The angle zero."""
    return Turn(ex.Expression(1), ex.Expression(0))


def turn_onto(
    w: ex.Expression, p: ex.Expression, z: ex.Expression, preferred: Turn, scale: ex.Expression | float = 1.0
) -> Root:
    """Subproblem 1: the turn about w that brings p nearest to z; any turn where one of them lies on the axis.

    Args:
        w: (3,) unit axis through the origin.
        p, z: (3,) start and goal.
        preferred: the turn taken where all are equal.
        scale: size of p and z, for telling whether they lie on the axis.
    """
    c = ex.dot(p, z) - ex.dot(w, p) * ex.dot(w, z)
    s = ex.dot(w, cross(p, z))
    return _direction(c, s, preferred, (FREE * scale) ** 2)


def turn_between(w: ex.Expression, p: ex.Expression, z: ex.Expression) -> Turn:
    """The turn about w that brings p onto z, unit vectors normal to w but for rounding.

    Args:
        w: (3,) unit axis.
        p, z: (3,) start and goal.
    """
    c, s = ex.dot(p, z), ex.dot(cross(w, p), z)
    # Newton's step towards length one; of vectors that are not normal to w only the direction of (c, s) counts.
    factor = 1.5 - 0.5 * (c * c + s * s)
    return Turn(factor * c, factor * s)


def turns_to_distance(
    w: ex.Expression,
    p: ex.Expression,
    o: ex.Expression,
    square: ex.Expression,
    preferred: Turn,
    scale: ex.Expression | float = 1.0,
) -> tuple[Root, Root]:
    """Subproblem 3: the turns about w that bring p to a given distance from o, both seen along the axis.

    |Rot(w, q) p_ - o_|^2 = square,  p_ and o_ normal to w:  q = psi +- phi, psi from p_ to o_,
    tan^2(phi / 2) = (square - (a - b)^2) / ((a + b)^2 - square),  a = |p_|, b = |o_|

    Args:
        w: (3,) unit axis through the origin.
        p, o: (3,) points [m].
        square: squared distance of their projections on the plane normal to w [m^2]; negative where there is none.
        preferred: the turn taken where all are equal.
        scale: size of the arm [m].
    """
    p, o = _normal(w, p), _normal(w, o)
    a, b = _norm(p), _norm(o)
    far, near = (a + b) ** 2 - square, square - (a - b) ** 2
    distance = ex.sqrt(ex.fmax(square, 0))
    residual = ex.fmax(ex.fmax(distance - (a + b), ex.fabs(a - b) - distance), 0) + ex.sqrt(ex.fmax(-square, 0))
    off_axis = ex.fmin(a, b) > FREE * scale
    middle = _direction(
        ex.if_else(off_axis, ex.dot(p, o), 0), ex.if_else(off_axis, ex.dot(w, cross(p, o)), 0), preferred, 0.0
    )
    return _both(middle, near, far, residual, ex.if_else(near < 0, ex.if_else(a > b, 2.0, 1.0), 0.0))


def turns_to_height(
    w: ex.Expression,
    h: ex.Expression,
    p: ex.Expression,
    height: ex.Expression,
    preferred: Turn,
    scale: ex.Expression | float = 1.0,
) -> tuple[Root, Root]:
    """Subproblem 4: the turns about w that bring p to a given height along h: h . Rot(w, q) p = height.

    Args:
        w: (3,) unit axis through the origin.
        h: (3,) unit direction along which heights are measured.
        p: (3,) point [m].
        height: given height [m].
        preferred: the turn taken where all are equal.
        scale: size of the arm [m].
    """
    along = ex.dot(h, w) * ex.dot(w, p)
    c, s = ex.dot(h, p) - along, ex.dot(h, cross(w, p))
    amplitude = ex.sqrt(c * c + s * s)
    middle = _direction(c, s, preferred, FREE * scale)
    rest = height - along
    residual = ex.fmax(ex.fabs(rest) - amplitude, 0)
    return _both(middle, amplitude - rest, amplitude + rest, residual)


class Pair(NamedTuple):
    """One solution of subproblem 2: turns about two crossing axes."""

    first: Root
    second: Root


def turns_about_two_axes(
    w1: ex.Expression,
    w2: ex.Expression,
    p: ex.Expression,
    z: ex.Expression,
    preferred: tuple[Turn, Turn],
    scale: ex.Expression | float = 1.0,
) -> tuple[Pair, Pair]:
    """Subproblem 2: Rot(w1, q1) Rot(w2, q2) p = z for crossing axes through the origin and |p| = |z|.

    The point between both turns lies on the circle of z about w1 and on that of p about w2. In the frame
    (w1, w2 - k w1, w1 x w2), k = w1.w2, it is (w1.z, g, +-sqrt(r^2 - g^2)), r = |w1 x z|.

    Args:
        w1, w2: (3,) unit axes, not parallel.
        p, z: (3,) start and goal [m].
        preferred: turns taken where all are equal.
        scale: size of p and z [m].
    """
    k = ex.dot(w1, w2)
    sine = ex.sqrt(1 - k * k)
    # Both projections on planes normal to an axis are seen in e1, e2 and f1, -e2: no vector has to be made.
    e1, f1, e2 = (w2 - k * w1) / sine, (w1 - k * w2) / sine, cross(w1, w2) / sine
    height, z1, z2 = ex.dot(w1, z), ex.dot(e1, z), ex.dot(e2, z)
    square = z1 * z1 + z2 * z2
    radius = ex.sqrt(square)
    g = (ex.dot(w2, p) - k * height) / sine
    inside = ex.fmin(ex.fmax(g, -radius), radius)
    aside = ex.sqrt((radius - inside) * (radius + inside))
    p1, p2, y1 = ex.dot(f1, p), -ex.dot(e2, p), sine * height - k * inside
    residual = ex.fmax(ex.fabs(g) - radius, 0)
    # |y| and |z| are equal off the first axis; off the second, |y| is the same for both points.
    first = _Sized(square, (FREE * scale) ** 2)
    second = _Sized(ex.sqrt((p1 * p1 + p2 * p2) * (y1 * y1 + aside * aside)), (FREE * scale) ** 2)
    return tuple(  # type: ignore[return-value]
        Pair(
            first.root(inside * z1 + y2 * z2, inside * z2 - y2 * z1, preferred[0], residual),
            second.root(p1 * y1 - p2 * y2, -p1 * y2 - p2 * y1, preferred[1], ex.Expression(0)),
        )
        for y2 in (aside, -aside)
    )


class _Sized:
    """Directions (c, s) of a known length, which may be none."""

    def __init__(self, size: ex.Expression, least: ex.Expression | float) -> None:
        self.known = size > least
        self.factor = 1 / ex.if_else(self.known, size, 1.0)

    def root(self, c: ex.Expression, s: ex.Expression, preferred: Turn, residual: ex.Expression) -> Root:
        """The turn along (c, s), or the preferred one."""
        turn = Turn(
            ex.if_else(self.known, c * self.factor, preferred.c), ex.if_else(self.known, s * self.factor, preferred.s)
        )
        return Root(turn, ex.logic_not(self.known), residual)


def _both(
    middle: Root,
    sine: ex.Expression,
    cosine: ex.Expression,
    residual: ex.Expression,
    inside: ex.Expression | float = 0.0,
) -> tuple[Root, Root]:
    """The turns middle +- phi with tan^2(phi / 2) = sine / cosine, clamped to where there is one."""
    x, y = ex.fmax(sine, 0), ex.fmax(cosine, 0)
    total = x + y
    known = total > 0
    factor = 1 / ex.if_else(known, total, 1.0)
    used = ex.logic_and(known, ex.logic_not(middle.free))
    phi = Turn(ex.if_else(used, (y - x) * factor, 1.0), ex.if_else(used, 2 * ex.sqrt(x * y) * factor, 0.0))
    return (
        Root(middle.turn.then(phi), middle.free, residual, inside),
        Root(middle.turn.then(phi.back()), middle.free, residual, inside),
    )


def _direction(c: ex.Expression, s: ex.Expression, preferred: Turn, least: ex.Expression | float) -> Root:
    """The turn along (c, s), or the preferred one where that has no direction."""
    return _Sized(ex.sqrt(c * c + s * s), least).root(c, s, preferred, ex.Expression(0))


def _normal(w: ex.Expression, x: ex.Expression) -> ex.Expression:
    return x - ex.dot(w, x) * w


def _norm(x: ex.Expression) -> ex.Expression:
    return ex.sqrt(ex.dot(x, x))
