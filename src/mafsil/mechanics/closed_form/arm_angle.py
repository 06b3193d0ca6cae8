"""Eight configurations of an arm with spherical shoulder and wrist for an arm angle, as expressions.

Reference: Kreutz-Delgado, Long and Seraji, Kinematic analysis of 7-DOF manipulators, 1992 (the arm angle); Shimizu et
al., Analytical inverse kinematic computation for 7-DOF redundant manipulators with joint limits, 2008.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np

import mafsil.expression as ex
from mafsil.algebra.spatial import cross
from mafsil.algebra.subproblems import Turn
from mafsil.arrays import Floats
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.mechanics.arm_pattern import ArmAnglePattern
from mafsil.mechanics.closed_form.line import BranchSolution, across, aside, norm
from mafsil.mechanics.closed_form.table import JudgedBranch, Preferences, excess_of, wound_angle

ALONG = 1e-9
"""Sine of the angle between the first axis and the line to the wrist up to which the second axis is measured from."""

STRAIGHT = 1e-12
"""The elbow's distance from the line, the same relative to one metre, below which any side of it will do [m]."""

FLAT = 1e-12
"""Sine of the middle joint of three below which only the sum of the others is known."""

ROUNDING = 1e-12
"""By how much the cosine of the elbow's opening may exceed one."""

Columns = tuple[ex.Expression, ex.Expression, ex.Expression]
"""Three orthonormal vectors."""

ThreeTurns = tuple[Turn, Turn, Turn]
"""Of three joints with a common point."""


@dataclass(frozen=True, eq=False)
class _Triple:
    """Two ways in which three joints with a common point make a rotation.

    Attributes:
        turns: of both ways, each of three joints.
        branch_margin: sine of the middle joint: both ways are one where it vanishes.
    """

    turns: tuple[ThreeTurns, ThreeTurns]
    branch_margin: ex.Expression


def arm_angle_branches(
    pattern: ArmAnglePattern, T: ex.Expression, angle: ex.Expression, preferences: Preferences
) -> list[JudgedBranch]:
    """All branches, elbow, shoulder and wrist each with its two roots; coordinates NaN where the wrist is out of reach.

    1. The distance from shoulder to wrist gives the elbow: two openings about where the links are in line.
    2. The frame of (line to the wrist, side of the elbow) before the turn of the shoulder, and the requested frame: its
       side is that of the first axis, turned about the line by the arm angle. One onto the other is the shoulder's
       rotation.
    3. Shoulder and wrist are three turns about axes normal to their neighbours: two ways each.
    4. Forward kinematics of the wrist's centre, and of two unit vectors of the tip, gives the residual of a branch.

    Args:
        pattern: of the arm.
        T: (4, 4) requested pose of the tip in {s}.
        angle: arm angle [rad].
        preferences: of the caller: to where angles are wound, and their limits.
    """
    home = ex.Expression(np.linalg.inv(pattern.home))
    P = T @ home
    R, p = P[:3, :3], P[:3, 3]
    axes = [ex.Expression(w) for w in pattern.axes]
    shoulder, elbow, wrist = (ex.Expression(x) for x in (pattern.shoulder, pattern.elbow, pattern.wrist))
    target = R @ wrist + p - shoulder
    distance = ex.fmax(norm(target), LEAST_DIVISOR)
    # 1.
    centre, cosine = _opening(pattern, distance)
    reached = ex.fabs(cosine) <= 1 + ROUNDING
    cosine = ex.fmax(-1, ex.fmin(1, cosine))
    sine = ex.sqrt(1 - cosine * cosine)
    turn = Turn(ex.cos(angle), ex.sin(angle))
    want = _side_turned(_frame_along(target / distance, axes[0], axes[1], ALONG), turn)
    side = aside(axes[6], axes[5])
    goals = [R @ axes[6], R @ side]
    rows: list[JudgedBranch] = []
    for sign in (1.0, -1.0):
        bend = centre.then(Turn(cosine, sign * sine))
        link = bend.about(axes[3], wrist - elbow)
        # 2.
        seen = elbow - shoulder + link
        have = _frame_along(seen / ex.fmax(norm(seen), LEAST_DIVISOR), elbow - shoulder, axes[3], STRAIGHT)
        S = ex.horzcat(*want) @ ex.horzcat(*have).T
        # 3.
        first = _triple(pattern.axes[:3], S)
        rest = _columns_turned(bend.back(), axes[3], S.T @ R)
        last = _triple(pattern.axes[4:], rest)
        # 4.
        moved = [_apply(axes[4:], turns, [axes[6], side]) for turns in last.turns]
        for before in first.turns:
            place = _apply(axes[:3], before, [seen])[0] - target
            left = [bend.back().about(axes[3], x) for x in _taken_off(axes[:3], before, goals)]
            for after, vectors in zip(last.turns, moved, strict=True):
                squares = [ex.sumsqr(place), *(ex.sumsqr(x - y) for x, y in zip(left, vectors, strict=True))]
                residual = ex.sqrt(ex.fmax(squares[0], ex.fmax(squares[1], squares[2])))
                motions = (*before, bend, *after)
                branch_margins = (first.branch_margin, sine, last.branch_margin)
                rows.append(_judged(motions, ex.if_else(reached, residual, float("nan")), branch_margins, preferences))
    return rows


def _judged(
    motions: tuple[Turn, ...],
    residual: ex.Expression,
    branch_margins: tuple[ex.Expression, ex.Expression, ex.Expression],
    preferences: Preferences,
) -> JudgedBranch:
    """The branch with its angles wound into the limits."""
    known = residual < ex.inf
    q = [ex.if_else(known, wound_angle(one.angle, preferences, i), float("nan")) for i, one in enumerate(motions)]
    solution = BranchSolution(
        motions, (ex.Expression(0),) * len(motions), ex.Expression(0), ex.Expression(0), branch_margins
    )
    excess = excess_of(q, preferences)
    return JudgedBranch(solution, q, residual, ex.Expression(0), excess, excess)


def _opening(pattern: ArmAnglePattern, distance: ex.Expression) -> tuple[Turn, ex.Expression]:
    """The turn of axis 4 that brings the wrist farthest, and the cosine of how far the elbow is from there.

    |Rot(w4, q4) u + v| = distance: u from axis 4 to the wrist, v from the shoulder to axis 4.
    """
    w = pattern.axes[3]
    u, v = pattern.wrist - pattern.elbow, pattern.elbow - pattern.shoulder
    height = float(w @ u + w @ v)
    u, v = u - (w @ u) * w, v - (w @ v) * w
    x, y = float(u @ v), float(np.cross(w, u) @ v)
    size = float(np.hypot(x, y))
    cosine = (distance * distance - height * height - float(u @ u) - float(v @ v)) / (2 * size)
    return Turn(ex.Expression(x / size), ex.Expression(y / size)), cosine


def _frame_along(w: ex.Expression, side: ex.Expression, other: ex.Expression, least: float) -> Columns:
    """The unit vector w, the part of `side` across it, of `other` if that is nearly none, and the normal to both."""
    one, two = across(w, side), across(w, other)
    usable = norm(one) >= least
    chosen = ex.vertcat(*[ex.if_else(usable, one[k], two[k]) for k in range(3)])
    # Of a short part across w rounding leaves some along w: it is taken off again.
    chosen = across(w, chosen / norm(chosen))
    chosen = chosen / norm(chosen)
    return w, chosen, cross(w, chosen)


def _side_turned(frame: Columns, turn: Turn) -> Columns:
    """The frame turned about its first vector."""
    w, side, normal = frame
    return w, turn.c * side + turn.s * normal, turn.c * normal - turn.s * side


def _columns_turned(turn: Turn, w: ex.Expression, R: ex.Expression) -> ex.Expression:
    """Rot(w, angle) R."""
    return ex.horzcat(*[turn.about(w, R[:, k]) for k in range(3)])


def _triple(axes: Floats, R: ex.Expression) -> _Triple:
    """Turns about three axes, the second normal to the others, whose product is R.

    F' R F Rot(y, b0) = Rot(z, a) Rot(y, b + b0) Rot(z, c): F has z along the first axis and y along the second, b0 is
    the angle from the first to the third about the second.
    """
    F, (c0, s0) = _axes_frame(axes)
    Q = ex.Expression(F.T) @ R @ ex.Expression(F @ np.array([[c0, 0.0, s0], [0.0, 1.0, 0.0], [-s0, 0.0, c0]]))
    size = norm(ex.vertcat(Q[0, 2], Q[1, 2]))
    flat = size < FLAT
    divisor = ex.if_else(flat, 1, size)
    # Where the middle joint does not bend, all is in the third.
    a = Turn(ex.if_else(flat, 1, Q[0, 2] / divisor), ex.if_else(flat, 0, Q[1, 2] / divisor))
    c = Turn(ex.if_else(flat, Q[1, 1], -Q[2, 0] / divisor), ex.if_else(flat, Q[1, 0], Q[2, 1] / divisor))
    sine = ex.if_else(flat, 0, size)
    back = Turn(ex.Expression(c0), ex.Expression(-s0))
    one = (a, Turn(Q[2, 2], sine).then(back), c)
    half = ex.if_else(flat, 1, -1)
    two = (_times(half, a), Turn(Q[2, 2], -sine).then(back), _times(half, c))
    return _Triple((one, two), size)


def _axes_frame(axes: Floats) -> tuple[Floats, tuple[float, float]]:
    """(3, 3) z along the first axis and y along the second; cosine and sine from the first to the third about it."""
    across: Floats = axes[1] - (axes[1] @ axes[0]) * axes[0]
    y = across / float(np.linalg.norm(across))
    c, s = float(axes[0] @ axes[2]), float(axes[1] @ np.cross(axes[0], axes[2]))
    size = float(np.hypot(c, s))
    x = cast("Floats", np.cross(y, axes[0]))
    return np.stack([x, y, axes[0]], axis=1), (c / size, s / size)


def _times(sign: ex.Expression, turn: Turn) -> Turn:
    """The turn, or that by half a turn more where the sign is negative."""
    return Turn(sign * turn.c, sign * turn.s)


def _apply(axes: list[ex.Expression], turns: ThreeTurns, vectors: list[ex.Expression]) -> list[ex.Expression]:
    """Vectors carried by three joints."""
    for w, turn in reversed(list(zip(axes, turns, strict=True))):
        vectors = [turn.about(w, x) for x in vectors]
    return vectors


def _taken_off(axes: list[ex.Expression], turns: ThreeTurns, vectors: list[ex.Expression]) -> list[ex.Expression]:
    """Vectors as seen before the motions of three joints."""
    for w, turn in zip(axes, turns, strict=True):
        vectors = [turn.back().about(w, x) for x in vectors]
    return vectors
