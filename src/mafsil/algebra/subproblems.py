"""Canonical subproblems of inverse kinematics as expressions: which turns about known axes bring points together?

A turn is kept as (cosine, sine); the angle is taken only at the end. Where a subproblem has no solution the turn is
that of the nearest miss, and `shortfall` says by how much it misses; where every angle solves it, `free` is one and the
turn is the one preferred.

References: Paden, Kinematics and Control of Robot Manipulators, 1986; Elias and Wen, IK-Geo, 2022 (numbers 1 to 4).
"""

from __future__ import annotations

from typing import NamedTuple

import casadi as ca

from mafsil.algebra.spatial import cross

FREE = 1e-9
"""Distances from an axis, relative to the size of the arm, below which every turn about it counts as a solution."""


class Turn(NamedTuple):
    """Cosine and sine of an angle."""

    c: ca.SX
    s: ca.SX

    def about(self, w: ca.SX, x: ca.SX) -> ca.SX:
        """(3,) vector x turned about the unit axis w through the origin."""
        along = ca.dot(w, x) * w
        return along + self.c * (x - along) + self.s * cross(w, x)

    def then(self, other: Turn) -> Turn:
        """The sum of both angles."""
        return Turn(self.c * other.c - self.s * other.s, self.s * other.c + self.c * other.s)

    def back(self) -> Turn:
        """The opposite angle."""
        return Turn(self.c, -self.s)

    @property
    def angle(self) -> ca.SX:
        """The angle in (-pi, pi]."""
        return ca.atan2(self.s, self.c)


class Root(NamedTuple):
    """One solution of a subproblem in one unknown.

    Attributes:
        turn: the angle.
        free: one where every angle solves.
        shortfall: how far the nearest miss misses, zero where the subproblem is solved.
        inside: one where the nearest miss is too near, not too far.
    """

    turn: Turn
    free: ca.SX
    shortfall: ca.SX
    inside: ca.SX | float = 0.0


def unturned() -> Turn:
    """The angle zero."""
    return Turn(ca.SX(1), ca.SX(0))


def turn_onto(w: ca.SX, p: ca.SX, z: ca.SX, preferred: Turn, scale: ca.SX | float = 1.0) -> Root:
    """Subproblem 1: the turn about w that brings p nearest to z; any turn where one of them lies on the axis.

    Args:
        w: (3,) unit axis through the origin.
        p, z: (3,) start and goal.
        preferred: the turn taken where all are equal.
        scale: size of p and z, for telling whether they lie on the axis.
    """
    c = ca.dot(p, z) - ca.dot(w, p) * ca.dot(w, z)
    s = ca.dot(w, cross(p, z))
    return _direction(c, s, preferred, (FREE * scale) ** 2)


def turns_to_distance(
    w: ca.SX, p: ca.SX, o: ca.SX, square: ca.SX, preferred: Turn, scale: ca.SX | float = 1.0
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
    distance = ca.sqrt(ca.fmax(square, 0))
    shortfall = ca.fmax(ca.fmax(distance - (a + b), ca.fabs(a - b) - distance), 0) + ca.sqrt(ca.fmax(-square, 0))
    off_axis = ca.fmin(a, b) > FREE * scale
    middle = _direction(
        ca.if_else(off_axis, ca.dot(p, o), 0), ca.if_else(off_axis, ca.dot(w, cross(p, o)), 0), preferred, 0.0
    )
    return _both(middle, near, far, shortfall, near < 0)


def turns_to_height(
    w: ca.SX, h: ca.SX, p: ca.SX, height: ca.SX, preferred: Turn, scale: ca.SX | float = 1.0
) -> tuple[Root, Root]:
    """Subproblem 4: the turns about w that bring p to a given height along h: h . Rot(w, q) p = height.

    Args:
        w: (3,) unit axis through the origin.
        h: (3,) unit direction along which heights are measured.
        p: (3,) point [m].
        height: wanted height [m].
        preferred: the turn taken where all are equal.
        scale: size of the arm [m].
    """
    along = ca.dot(h, w) * ca.dot(w, p)
    c, s = ca.dot(h, p) - along, ca.dot(h, cross(w, p))
    amplitude = ca.sqrt(c * c + s * s)
    middle = _direction(c, s, preferred, FREE * scale)
    rest = height - along
    shortfall = ca.fmax(ca.fabs(rest) - amplitude, 0)
    return _both(middle, amplitude - rest, amplitude + rest, shortfall)


class Pair(NamedTuple):
    """One solution of subproblem 2: turns about two crossing axes."""

    first: Root
    second: Root


def turns_about_two_axes(
    w1: ca.SX, w2: ca.SX, p: ca.SX, z: ca.SX, preferred: tuple[Turn, Turn], scale: ca.SX | float = 1.0
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
    k = ca.dot(w1, w2)
    sine = ca.sqrt(1 - k * k)
    e1, e2 = (w2 - k * w1) / sine, cross(w1, w2) / sine
    height = ca.dot(w1, z)
    radius = _norm(cross(w1, z))
    g = (ca.dot(w2, p) - k * height) / sine
    inside = ca.fmin(ca.fmax(g, -radius), radius)
    aside = ca.sqrt((radius - inside) * (radius + inside))
    shortfall = ca.fabs(g - inside)
    return (
        _pair(w1, w2, p, z, height * w1 + inside * e1 + aside * e2, preferred, shortfall, scale),
        _pair(w1, w2, p, z, height * w1 + inside * e1 - aside * e2, preferred, shortfall, scale),
    )


def _pair(
    w1: ca.SX,
    w2: ca.SX,
    p: ca.SX,
    z: ca.SX,
    y: ca.SX,
    preferred: tuple[Turn, Turn],
    shortfall: ca.SX,
    scale: ca.SX | float,
) -> Pair:
    first, second = turn_onto(w1, y, z, preferred[0], scale), turn_onto(w2, p, y, preferred[1], scale)
    return Pair(first._replace(shortfall=shortfall), second)


def _both(middle: Root, sine: ca.SX, cosine: ca.SX, shortfall: ca.SX, inside: ca.SX | float = 0.0) -> tuple[Root, Root]:
    """The turns middle +- phi with tan^2(phi / 2) = sine / cosine, clamped to where there is one."""
    x, y = ca.fmax(sine, 0), ca.fmax(cosine, 0)
    total = x + y
    known = total > 0
    factor = 1 / ca.if_else(known, total, 1.0)
    used = ca.logic_and(known, ca.logic_not(middle.free))
    phi = Turn(ca.if_else(used, (y - x) * factor, 1.0), ca.if_else(used, 2 * ca.sqrt(x * y) * factor, 0.0))
    return (
        Root(middle.turn.then(phi), middle.free, shortfall, inside),
        Root(middle.turn.then(phi.back()), middle.free, shortfall, inside),
    )


def _direction(c: ca.SX, s: ca.SX, preferred: Turn, least: ca.SX | float) -> Root:
    """The turn along (c, s), or the preferred one where that has no direction."""
    size = ca.sqrt(c * c + s * s)
    known = size > least
    factor = 1 / ca.if_else(known, size, 1.0)
    turn = Turn(ca.if_else(known, c * factor, preferred.c), ca.if_else(known, s * factor, preferred.s))
    return Root(turn, ca.logic_not(known), ca.SX(0))


def _normal(w: ca.SX, x: ca.SX) -> ca.SX:
    return x - ca.dot(w, x) * w


def _norm(x: ca.SX) -> ca.SX:
    return ca.sqrt(ca.dot(x, x))
