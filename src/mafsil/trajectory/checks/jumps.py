"""Jumps of a trajectory's derivatives: at its breaks, and at places that it does not name as such."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats
from mafsil.floating_point import EPS
from mafsil.trajectory.motion import Trajectory, derivative
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial

NEAR = 1e-6
"""How far beside a break a derivative is looked at, relative to the shorter piece beside it."""
JUMP = 1e-6
"""A jump, relative to the largest value of its derivative and in SI units for the position; below it is rounding."""
CLOSEST = 16 * EPS
"""Share of the duration below which two times are one."""
CONSTRUCTED = 64 * EPS
"""Share of the position, over the k-th power of a piece's length, by which derivative k is off by rounding."""
INSIDE = np.array([0.1, 0.21, 0.38, 0.5, 0.62, 0.79, 0.9])
"""Shares of a piece at which its derivatives are looked at: of no smooth motion all are zeros."""
SAMPLES, BISECTIONS = 2048, 40
"""Where breaks are not known: evenly spaced times, and halvings of an interval that holds a jump."""


@dataclass(frozen=True, slots=True)
class Jump:
    """A derivative that is not continuous.

    Attributes:
        order: 0 for the position, to 3 for the jerk.
        time: [s].
        coordinate: index.
        size: value after less value before.
    """

    order: int
    time: float
    coordinate: int
    size: float


def jumps(trajectory: Trajectory, order: int, *, ends: bool = True, tolerance: float = JUMP) -> tuple[Jump, ...]:
    """The jumps of one derivative, in the order of time.

    Polynomials are evaluated on both sides of their knots. Of other motions the values beside a break at two distances
    give the jump without its slope: 2 J(h) - J(2 h), where J(h) = f(t + h) - f(t - h).

    Args:
        trajectory: without batch dimensions.
        order: of the derivative, 0 to 3.
        ends: whether start and end count, before and after which a trajectory rests.
        tolerance: relative to the largest value of the derivative: smaller differences are no jumps.
    """
    duration = trajectory.duration
    if not duration > 0.0:
        return ()
    exact = isinstance(trajectory, PiecewisePolynomial)
    begin, wide, sizes, largest = _of_polynomial(trajectory, order) if exact else _of_any(trajectory, order)
    if not ends:
        begin, wide, sizes = begin[1:-1], wide[1:-1], sizes[1:-1]
    if not len(sizes):
        return ()
    largest = np.maximum(largest, np.abs(sizes).max(axis=0))
    u = np.abs(trajectory.at(begin).u).max(axis=0)
    threshold = tolerance * (np.maximum(largest, 1.0) if order == 0 else largest)
    noise = CONSTRUCTED * np.maximum(u, u.max(initial=0.0)) / np.power(wide, order)[:, None]
    found = np.argwhere(np.abs(sizes) > np.maximum(threshold, noise))
    return tuple(Jump(order, float(begin[k]), int(i), float(sizes[k, i])) for k, i in found)


def _of_polynomial(motion: PiecewisePolynomial, order: int) -> tuple[Floats, Floats, Floats, Floats]:
    """Times of the knots, the longer piece beside each, the jumps there, and the largest value of the derivative."""
    knots = motion.knots
    after, before = motion.derivative(knots[:-1], order), motion.derivative(knots[1:], order, within=knots[:-1])
    rests = [after[:1], before[-1:]] if order == 0 else [0.0 * after[:1], 0.0 * before[-1:]]
    sizes = np.concatenate([after, rests[1]]) - np.concatenate([rests[0], before])
    gaps = np.diff(knots)
    within = motion.derivative((knots[:-1, None] + gaps[:, None] * INSIDE).ravel(), order)
    largest = np.abs(np.concatenate([after, before, within])).max(axis=0)
    return knots, np.maximum(np.insert(gaps, 0, gaps[0]), np.append(gaps, gaps[-1])), sizes, largest


def _of_any(trajectory: Trajectory, order: int) -> tuple[Floats, Floats, Floats, Floats]:
    """The same, by values beside the places at two distances."""
    least = CLOSEST * trajectory.duration
    begin, end = _clusters(_places(trajectory, order), least)
    gaps = begin[1:] - end[:-1]
    left, right = np.insert(gaps, 0, gaps[:1]), np.append(gaps, gaps[-1:])
    if not len(gaps):
        return begin[:0], begin[:0], np.zeros((0, trajectory.n)), np.zeros(trajectory.n)
    h = np.maximum(NEAR * np.minimum(left, right), least)
    once, twice = (
        derivative(trajectory, end + k * h, order) - derivative(trajectory, begin - k * h, order) for k in (1.0, 2.0)
    )
    samples = derivative(trajectory, np.linspace(0.0, trajectory.duration, 257), order)
    return begin, np.maximum(left, right), 2.0 * once - twice, np.abs(samples).max(axis=0)


def _places(trajectory: Trajectory, order: int) -> Floats:
    """Times at which a derivative may jump: breaks, and where values leap between two neighbouring times."""
    breaks = trajectory.breaks()
    if order == 3 or len(breaks) < 2:
        return breaks
    inner = np.linspace(0.0, trajectory.duration, SAMPLES + 1)[1:-1]
    t = np.unique(np.concatenate([breaks, inner]))
    beside = NEAR * np.diff(t) * np.isin(t[:-1], breaks), NEAR * np.diff(t) * np.isin(t[1:], breaks)
    return np.unique(np.concatenate([breaks, _leaps(trajectory, t[:-1] + beside[0], t[1:] - beside[1], order)]))


def _leaps(trajectory: Trajectory, low: Floats, high: Floats, order: int) -> Floats:
    """Times in the intervals from `low` to `high` at which a derivative changes as its own derivative does not say.

    |f(b) - f(a) - (b - a) (f'(a) + 4 f'(m) + f'(b))/6| shrinks with the interval unless f jumps in it.
    """
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        halves = [_residual(trajectory, a, b, order) for a, b in ((low, middle), (middle, high))]
        largest = max(1.0 if order == 0 else 0.0, *(half[1] for half in halves))
        first = halves[0][0] >= halves[1][0]
        suspect = np.maximum(halves[0][0], halves[1][0]) > 0.5 * JUMP * largest
        low, high = np.where(first, low, middle)[suspect], np.where(first, middle, high)[suspect]
        if not len(low):
            return low
    return (low + high) / 2


def _residual(trajectory: Trajectory, a: Floats, b: Floats, order: int) -> tuple[Floats, float]:
    """(k,) the largest of all coordinates over each interval; and the largest value of the derivative."""
    f = [derivative(trajectory, x, order) for x in (a, b)]
    slopes = [derivative(trajectory, x, order + 1) for x in (a, (a + b) / 2, b)]
    rise = (b - a)[:, None] * (slopes[0] + 4.0 * slopes[1] + slopes[2]) / 6.0
    return np.abs(f[1] - f[0] - rise).max(axis=1, initial=0.0), float(np.abs(f[0]).max(initial=0.0))


def _clusters(t: Floats, least: float) -> tuple[Floats, Floats]:
    """First and last time of each group of times that are as good as one."""
    split = np.flatnonzero(np.diff(t) > 8.0 * least) + 1
    return t[np.insert(split, 0, 0)], t[np.append(split, len(t)) - 1]
