"""Nguyen's theorem: two plane contacts with friction close iff the line between them lies in both cones, facing.

In the frame with the contacts at (0, -1) and (0, 1) the four cone edges make angles theta with the line:

  e1 = (-s1, c1), e2 = (s2, c2) at the lower, e3 = (-s3, -c3), e4 = (s4, -c4) at the upper contact
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import atan2

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, as_batch, frozen
from mafsil.errors import InputError
from mafsil.grasp.contact import Contact
from mafsil.grasp.tolerances import ROUNDOFF, TYPED
from mafsil.solvers.rational import locate_origin


class NguyenCase(Status):
    """How the line between two contacts and their cones lie; it succeeds where the grasp is force closure."""

    FACING = ("grasp.nguyen_facing", True)
    OUTWARD = ("grasp.nguyen_outward", True)
    SAME_WAY = ("grasp.nguyen_same_way", False)
    ONE_CONE = ("grasp.nguyen_one_cone", False)
    OPPOSITE_SIDES = ("grasp.nguyen_opposite_sides", False)
    SAME_SIDE = ("grasp.nguyen_same_side", False)
    EDGE = ("grasp.nguyen_edge", False)


@dataclass(frozen=True, eq=False, repr=False)
class TwoFingers(Answer, data="force_closure theta combination certificate unresisted"):
    """Verdict of the theorem, true if the grasp is force closure.

    Attributes:
        status: line in both cones, in one, or in none (on opposite sides, or on the same side).
        theta: (4,) angles of the edges from the line [rad].
        matrix: (3, 4) wrenches (f_x, f_y, m) of the edges in the frame of the theorem.
        combination: (4,) sum 1, all > 0, matrix @ combination = 0, if closed; else None.
        certificate: (3,) y != 0 with y . column >= 0 for all four, in the frame of the theorem, if not closed.
        delta: (2,) angles of the normals from the line [rad], of the first from d = p2 - p1, of the second from -d;
            None where only theta was given.
        unresisted: (3,) the wrench (m, f_x, f_y) that the contacts do not resist, in their own frame: as a twist the
            turn about the contact whose cone holds the line, or about any of them; None if closed or without contacts.
    """

    status: NguyenCase
    theta: Floats
    matrix: Floats
    combination: Floats | None
    certificate: Floats | None
    delta: Floats | None = None
    unresisted: Floats | None = None

    @property
    def force_closure(self) -> bool:
        """Whether the grasp is force closure."""
        return self.status.succeeded


def two_fingers(first: Contact, second: Contact) -> TwoFingers:
    """Nguyen's test of two contacts in the plane.

    Args:
        first: the lower contact of the theorem's frame.
        second: the upper one.

    Raises:
        InputError: not in the plane, or at one point.
    """
    if first.dimension != 2 or second.dimension != 2:
        raise InputError("grasp.needs_plane", what="two_fingers")
    d = second.point - first.point
    if not np.linalg.norm(d) > 0:
        raise InputError("grasp.same_point", indices="0, 1")
    psi = _angle(d, first.normal)
    phi = _angle(-d, second.normal)
    theta = [first.alpha + psi, first.alpha - psi, second.alpha - phi, second.alpha + phi]
    found = nguyen(theta)
    delta = frozen([psi, phi])
    if found.force_closure:
        return replace(found, delta=delta)
    return replace(found, delta=delta, unresisted=frozen(_unresisted_wrench(first, second, found.status)))


def _unresisted_wrench(first: Contact, second: Contact, case: NguyenCase) -> Floats:
    """A y with y . w >= 0 for both contacts: a turn about one of them, or the field n_i / (n_i . d) at both."""
    wrenches = np.hstack([first.wrenches(), second.wrenches()])
    slack = -TYPED * float(np.abs(wrenches).max())
    trials = [sign * np.array([1.0, p[1], -p[0]]) for p in (second.point, first.point) for sign in (1.0, -1.0)]
    if case is NguyenCase.SAME_WAY:
        trials = [sign * _field(first, second) for sign in (1.0, -1.0)] + trials
    best = max(trials, key=lambda y: float((y @ wrenches).min()))
    for y in trials:
        if float((y @ wrenches).min()) >= slack:
            return y
    return best


def _field(first: Contact, second: Contact) -> Floats:
    """The twist that moves each contact point along its own normal with the same speed along the line."""
    d = second.point - first.point
    u, v = (c.normal / float(c.normal @ d) for c in (first, second))
    turn = np.array([-d[1], d[0]])
    omega = float((v - u) @ turn) / float(d @ d)
    return np.array([omega, u[0] + omega * first.point[1], u[1] - omega * first.point[0]])


def nguyen(theta: ArrayLike) -> TwoFingers:
    """Nguyen's test in its own frame.

    x = (s2 sin(th3+th4), s1 sin(th3+th4), s4 sin(th1+th2), s3 sin(th1+th2)) spans the null space of the matrix.

    Args:
        theta: (4,) angles of the edges from the line [rad]: 1 and 2 left and right at the lower contact, 3 and 4 left
            and right at the upper one; th1 + th2 and th3 + th4 are the openings of the cones.

    Reference:
        V.-D. Nguyen, Constructing force-closure grasps, IEEE ICRA 1986.
    """
    th = as_batch("theta", theta, (4,), finite=True)
    s, c = np.sin(th), np.cos(th)
    A = np.array([[-s[0], s[1], -s[2], s[3]], [c[0], c[1], -c[2], -c[3]], [-s[0], s[1], s[2], -s[3]]])
    x = np.array([s[1], s[0], s[3], s[2]]) * np.repeat([np.sin(th[2] + th[3]), np.sin(th[0] + th[1])], 2)
    case = _case(th, s)
    if case.succeeded:
        return TwoFingers(case, frozen(th), frozen(A), frozen(x / x.sum()), None)
    return TwoFingers(case, frozen(th), frozen(A), None, frozen(_certificate(A, case, s, c)))


def _case(th: Floats, s: Floats) -> NguyenCase:
    """Both sines of a pair positive: the line runs inside forwards; both negative (opening < pi): backwards."""
    lower, upper = _inside(th[0], th[1], s[0], s[1]), _inside(th[2], th[3], s[2], s[3])
    if lower == upper and lower != 0:
        return NguyenCase.FACING if lower > 0 else NguyenCase.OUTWARD
    if np.any(np.abs(s) <= ROUNDOFF):
        return NguyenCase.EDGE
    if lower and upper:
        return NguyenCase.SAME_WAY
    if lower or upper:
        return NguyenCase.ONE_CONE
    return NguyenCase.SAME_SIDE if (s[1] > 0) == (s[3] > 0) else NguyenCase.OPPOSITE_SIDES


def _inside(left: float, right: float, s_left: float, s_right: float) -> int:
    """1 if the line lies inside the cone forwards, -1 if backwards, 0 if not inside."""
    if np.sin(left + right) <= ROUNDOFF:
        return 0
    return 1 if s_left > ROUNDOFF and s_right > ROUNDOFF else -1 if s_left < -ROUNDOFF and s_right < -ROUNDOFF else 0


def _certificate(A: Floats, case: NguyenCase, s: Floats, c: Floats) -> Floats:
    """One of the textbook directions where it applies, else that of exact arithmetic."""
    if case in (NguyenCase.SAME_SIDE, NguyenCase.OPPOSITE_SIDES):
        y = np.array([1.0, 0, 0]) if case is NguyenCase.SAME_SIDE else np.array([0, 0, 1.0])
        return y if (y @ A).min() >= 0 else -y
    cleaned = np.where(np.abs(A) <= ROUNDOFF, 0.0, A)
    found = locate_origin(cleaned.T.tolist()).certificate
    return np.array([float(v) for v in found or (0, 0, 0)])


def _angle(line: Floats, n: Floats) -> float:
    """Counter-clockwise angle from the line to the normal."""
    return atan2(line[0] * n[1] - line[1] * n[0], float(line @ n))
