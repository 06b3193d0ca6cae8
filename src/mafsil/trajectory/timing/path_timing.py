"""A time law along a path that is slow only where the joints need it: time dilated, the least that limits allow."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mafsil.arrays import Floats
from mafsil.errors import MafsilError
from mafsil.model import JointLimits
from mafsil.solvers.linear_program import minimise
from mafsil.trajectory.motion import Trajectory
from mafsil.trajectory.path import PathMotion
from mafsil.trajectory.profiles.polynomial import quintic_coefficients
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial

LOOK = 2000
"""Places along the motion where its needs are looked at."""
KNOTS = 120
"""Pieces of the dilation; they are shorter where the motion needs it."""
NODES = 8
"""Of Gauss and Legendre per piece."""
LEAST = 0.1
"""Of the dilation, as share of the uniform one: it never comes to rest."""
PLACES = 3
"""Per piece, at which the limits are imposed."""
MARGIN = 0.99
"""Share of the limits that the dilation uses; the rest is for what lies between the places."""


@dataclass(frozen=True, slots=True)
class Slowest:
    """Where a motion is farthest beyond its limits.

    Attributes:
        place: s in 0 .. 1.
        joint: index of the joint.
        quantity: `velocity` or `acceleration`, whichever needs more time.
        factor: how many times slower the motion has to be there.
    """

    place: float
    joint: int
    quantity: str
    factor: float


def slowest(motion: PathMotion, limits: JointLimits) -> Slowest:
    """Where and for which joint a motion needs to be slowed most."""
    t = _look(motion)
    needs = _needs(motion, limits, t)
    order, row, joint = (int(i) for i in np.unravel_index(int(needs.argmax()), needs.shape))
    place = float(motion.law.at(t[row]).u[0])
    return Slowest(place, joint, ("velocity", "acceleration")[order], float(needs.max()))


def dilate_time(motion: PathMotion, limits: JointLimits, acceleration: float) -> PathMotion:
    """The same path, slowed only where limits need it; uniformly where that is as good.

    With dt = dtau / sqrt(y(tau)) the motion u(tau) has  v = u' sqrt(y),  a = u'' y + u' y'/2:  limits are linear in y.

    1. Knots of y where the motion needs them: their density follows max(|u'|/v_max, sqrt(|u''|/a_max)).
    2. y is a quadratic spline; at each place  y u'^2 <= v_max^2,  |u'' y + u' y'/2| <= a_max,  0 < y <= 1.
    3. The largest sum of y / (y at rest)^(3/2), which is the first order of the shortest time: a linear program.
    4. t(tau) by Gauss-Legendre, and s(t) by quintics through position, speed and acceleration at the places.
    5. What is still beyond a limit between the places is stretched uniformly; so is everything if that takes no longer.

    Args:
        motion: a path and a law from rest to rest.
        limits: of the joints; those of velocity and acceleration shape the dilation, the jerk only stretches.
        acceleration: largest |s''| [1/s^2].

    Reference: Verscheure et al., Time-optimal path tracking for robots: a convex optimization approach, IEEE TAC 2009.
    """
    uniform = motion.scale_time(max(motion.stretch_needed(limits) * (1 + 1e-9), 1.0))
    if uniform.duration <= motion.duration * (1 + 1e-6):
        return uniform
    law = _law(motion, limits, acceleration, motion.duration / uniform.duration)
    if law is None:
        return uniform
    candidate = replace(motion, law=law)
    candidate = candidate.scale_time(max(candidate.stretch_needed(limits) * (1 + 1e-9), 1.0))
    return candidate if candidate.duration < uniform.duration else uniform


def _look(motion: PathMotion) -> Floats:
    """Times inside the motion, none of them on a knot of its law."""
    return (np.arange(LOOK) + 0.5) / LOOK * motion.duration


def _needs(motion: PathMotion, limits: JointLimits, t: Floats) -> Floats:
    """(2, t, n) how many times slower the motion has to be for the speed and the acceleration of each joint."""
    u = motion.at(t)
    return np.array([np.abs(u.v) / limits.velocity, np.sqrt(np.abs(u.a) / limits.acceleration)])


def _knots(motion: PathMotion, limits: JointLimits) -> Floats:
    """(KNOTS + 1,) times, closer where the motion has to be slow; the knots of its law are among them."""
    t = _look(motion)
    need = np.maximum(_needs(motion, limits, t).max(axis=(0, 2)), 1.0)
    wide = LOOK // 100
    padded = np.pad(need, wide, mode="edge")
    need = np.lib.stride_tricks.sliding_window_view(padded, 2 * wide + 1).max(axis=1)
    measure = np.concatenate([[0.0], np.cumsum(need / need.sum() + 1.0 / LOOK)])
    even = np.linspace(0.0, float(measure[-1]), KNOTS + 1)
    grid = np.asarray(np.interp(even, measure, np.linspace(0.0, motion.duration, LOOK + 1)), dtype=np.float64)
    for moment in motion.breaks():
        grid[np.abs(grid - moment).argmin()] = moment
    return np.unique(grid)


def _law(motion: PathMotion, limits: JointLimits, acceleration: float, slow: float) -> PiecewisePolynomial | None:
    """s(t) of the dilated motion; `slow` is the share of speed that suits everywhere. None if HiGHS gives up."""
    knots = _knots(motion, limits)
    inside = (np.arange(PLACES) + 0.5) / PLACES
    t = (knots[:-1, None] + inside * np.diff(knots)[:, None]).ravel()
    y, slope = _splines(knots, t)
    u, s = motion.at(t), motion.law.at(t)
    v = np.concatenate([u.v / limits.acceleration, s.v / acceleration], axis=1).T[..., None]
    a = np.concatenate([u.a / limits.acceleration, s.a / acceleration], axis=1).T[..., None]
    hard = (a * y + v / 2 * slope).reshape(-1, y.shape[1])
    need = _needs(motion, limits, t)
    fast = 1.0 / np.maximum(need[0].max(axis=1), 1.0) ** 2
    weight = (np.maximum(need.max(axis=(0, 2)), 1.0) ** 3 * np.repeat(np.diff(knots), PLACES)) @ y
    G = np.concatenate([hard, -hard, y, np.eye(y.shape[1])])
    h = np.concatenate([np.full(2 * len(hard), MARGIN), MARGIN**2 * fast, np.ones(y.shape[1])])
    least = LEAST * (slow * MARGIN) ** 2
    try:
        found = minimise(-weight / weight.max(), G=G, h=h - least * G.sum(axis=1))
    except MafsilError:
        return None
    return None if found is None else _in_time(motion.law, knots, least + found.x)


def _splines(knots: Floats, t: Floats) -> tuple[Floats, Floats]:
    """(t, pieces + 2) values of the quadratic basis splines between knots, and their slopes: de Boor's recursion."""
    x = np.concatenate([[knots[0]] * 2, knots, [knots[-1]] * 2])
    k = np.clip(np.searchsorted(knots, t, side="right") + 1, 2, len(knots))
    rising = (t - x[k]) / (x[k + 1] - x[k])
    before, after = x[k + 1] - x[k - 1], x[k + 2] - x[k]
    left, right = (1 - rising) * (x[k + 1] - t) / before, rising * (t - x[k]) / after
    value, slope = np.zeros((2, len(t), len(knots) + 1))
    rows = np.arange(len(t))
    for column, own, steep in (
        (k - 2, left, -2 * (1 - rising) / before),
        (k - 1, 1 - left - right, 2 * (1 - rising) / before - 2 * rising / after),
        (k, right, 2 * rising / after),
    ):
        value[rows, column], slope[rows, column] = own, steep
    return value, slope


def _in_time(law: Trajectory, knots: Floats, coefficients: Floats) -> PiecewisePolynomial:
    """s(t): quintics between the knots."""
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    middle, half = (knots[1:] + knots[:-1]) / 2, np.diff(knots) / 2
    within = _splines(knots, (middle[:, None] + half[:, None] * nodes).ravel())[0] @ coefficients
    lengths = half * (weights / np.sqrt(within.reshape(-1, NODES))).sum(axis=1)
    y, slope = (basis @ coefficients for basis in _splines(knots, knots))
    s, speed, _ = law.at(knots)
    rate = speed * np.sqrt(y)[:, None]
    # The law's acceleration may jump at its knots: each piece asks for it just inside.
    push = speed * (slope / 2)[:, None]
    begin = law.at(np.nextafter(knots[:-1], knots[1:])).a * y[:-1, None] + push[:-1]
    end = law.at(np.nextafter(knots[1:], knots[:-1])).a * y[1:, None] + push[1:]
    return PiecewisePolynomial.from_pieces(
        lengths,
        [
            quintic_coefficients(s[k], s[k + 1], rate[k], rate[k + 1], begin[k], end[k], float(length))
            for k, length in enumerate(lengths)
        ],
    )
