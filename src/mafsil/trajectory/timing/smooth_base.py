"""A first motion along a path whose jerk is finite: the fastest one without limits of jerk, smoothed in time.

Its path velocity is a quadratic spline with coefficients that are never negative, so it only moves forwards; at both
ends velocity and acceleration are zero.
"""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial
from mafsil.trajectory.timing.timing_problem import Timing

SHARES = (0.0, 0.5, 1.0)
"""Of each piece, where what is imposed is looked at."""


def smooth_timing(timing: Timing, width: float, pieces: int) -> PiecewisePolynomial:
    """s(tau) of a timing from rest to rest whose path velocity is averaged over a window; it takes as much longer.

    1. Knots, half of them evenly in time, half by the variation of the averaged acceleration: close in its ramps.
    2. The average at the abscissae of the spline's coefficients: differences of the position over the window.
    3. The spline with these coefficients, zero at both ends with its slope; its integral, scaled to the whole path.

    Args:
        timing: without limits of jerk.
        width: of the window [s].
        pieces: of the result.
    """
    # 1.
    moments = _moments(timing)
    total = float(moments[-1]) + width
    bends = np.union1d(moments, moments + width)
    acceleration = (_velocity(timing, moments, bends) - _velocity(timing, moments, bends - width)) / width
    variation = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(acceleration)))])
    measure = bends / total + variation / max(float(variation[-1]), 1e-300)
    even = np.linspace(0.0, float(measure[-1]), pieces + 1)
    knots: Floats = np.asarray(np.interp(even, measure, bends), dtype=np.float64)
    # 2.
    padded = np.concatenate([[0.0, 0.0], knots, [total, total]])
    abscissae = (padded[1:-2] + padded[2:-1]) / 2.0
    speeds = (_position(timing, moments, abscissae) - _position(timing, moments, abscissae - width)) / width
    speeds[:2] = speeds[-2:] = 0.0
    # 3.
    local = np.stack([speeds[:-2], speeds[1:-1], speeds[2:]], axis=1)
    begin = np.einsum("kid,ki->dk", quadratic_basis(knots)[::3], local)
    h = np.diff(knots)
    places = np.concatenate([[0.0], np.cumsum(begin[0] * h + begin[1] * h**2 / 2.0 + begin[2] * h**3 / 6.0)])
    rows = np.stack([places[:-1], begin[0], begin[1] / 2.0, begin[2] / 6.0], axis=1)
    return PiecewisePolynomial.from_pieces(h, (rows * float(timing.s[-1]) / places[-1])[..., None])


def quadratic_basis(knots: Floats) -> Floats:
    """Value, slope and second derivative of the three quadratic basis splines that count on each piece.

    Returns:
        (3 pieces, 3, 3), at begin, middle and end of each piece, by basis spline and derivative.

    Args:
        knots: (pieces + 1,) increasing.

    Reference: de Boor, A Practical Guide to Splines, ch. IX.
    """
    padded = np.concatenate([[knots[0]] * 2, knots, [knots[-1]] * 2])
    k = np.arange(2, len(knots) + 1)
    h, before, after = padded[k + 1] - padded[k], padded[k + 1] - padded[k - 1], padded[k + 2] - padded[k]
    found = np.zeros((len(h), 3, 3, 3))
    for place, share in enumerate(SHARES):
        falls, rises = (1.0 - share) * h, share * h
        left = np.stack([falls**2, -2.0 * falls, np.full_like(h, 2.0)], axis=-1) / (h * before)[:, None]
        right = np.stack([rises**2, 2.0 * rises, np.full_like(h, 2.0)], axis=-1) / (h * after)[:, None]
        found[:, place, 0], found[:, place, 2] = left, right
        found[:, place, 1] = np.array([1.0, 0.0, 0.0]) - left - right
    return found.reshape(-1, 3, 3)


def _moments(timing: Timing) -> Floats:
    """(places,) the times at the places of the grid [s]."""
    rate = np.sqrt(timing.x)
    return np.concatenate([[0.0], np.cumsum(2.0 * np.diff(timing.s) / (rate[:-1] + rate[1:]))])


def _position(timing: Timing, moments: Floats, t: Floats) -> Floats:
    """s at times, at rest before and after."""
    h, rate = np.diff(timing.s), np.sqrt(timing.x)
    k = np.clip(np.searchsorted(moments, t, side="right") - 1, 0, len(h) - 1)
    local = np.clip(t, 0.0, moments[-1]) - moments[k]
    return timing.s[k] + rate[k] * local + (timing.x[k + 1] - timing.x[k]) / (4.0 * h[k]) * local**2


def _velocity(timing: Timing, moments: Floats, t: Floats) -> Floats:
    """ds/dt at times: linear between the moments."""
    return np.asarray(np.interp(t, moments, np.sqrt(timing.x)), dtype=np.float64)
