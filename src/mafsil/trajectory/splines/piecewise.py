"""Piecewise polynomials on a common time axis: what cubics, quintics, trapezoids and rests are made of.

Real roots of many polynomials at once, between 0 and 1.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import comb, perm, prod
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, frozen, real_array
from mafsil.errors import InputError
from mafsil.fields import check_fields, numbers
from mafsil.lazy_module import lazily
from mafsil.trajectory.motion import Motion, Printed, moving_at, times
from mafsil.trajectory.tolerances import REAL_ROOT

if TYPE_CHECKING:
    import mafsil.trajectory.jerk.online_loops as online_loops
else:
    online_loops = lazily("mafsil.trajectory.jerk.online_loops")

NODES, WEIGHTS = np.polynomial.legendre.leggauss(16)
PANELS = 8
"""Panels of quadrature in every smooth stretch."""
MANY = 4096
"""Numbers from which on a compiled loop samples them: fewer are not worth loading it."""


@dataclass(frozen=True, eq=False, repr=False)
class PiecewisePolynomial(Printed):
    """u(t) = sum_k coefficients[i, k] (t - knots[i])^k for knots[i] <= t < knots[i + 1].

    Attributes:
        knots: (pieces + 1,) increasing times, the first is zero [s].
        coefficients: (pieces, degree + 1, *batch, n) in ascending powers of the time since the piece's start.
    """

    knots: Floats
    coefficients: Floats
    __post_init__ = check_fields(knots=numbers(1), coefficients=numbers())

    @classmethod
    def from_pieces(cls, durations: ArrayLike, coefficients: ArrayLike) -> PiecewisePolynomial:
        """Pieces one after the other.

        Args:
            durations: (pieces,) length of each [s].
            coefficients: (pieces, degree + 1, *batch, n).

        Raises:
            InputError: a number that is not finite: times too short, or distances too large, for floating point.
        """
        lengths, each = real_array("durations", durations), real_array("coefficients", coefficients)
        knots = np.concatenate([[0.0], np.cumsum(lengths)])
        if not (np.isfinite(knots).all() and np.isfinite(each).all()):
            raise InputError("trajectory.overflow", duration=float(knots[-1]))
        return cls(frozen(knots), frozen(each))

    @property
    def duration(self) -> float:
        """Length in time [s]."""
        return float(self.knots[-1])

    @property
    def n(self) -> int:
        """Number of coordinates."""
        return self.coefficients.shape[-1]

    @property
    def degree(self) -> int:
        """Degree of the pieces."""
        return self.coefficients.shape[1] - 1

    def breaks(self) -> Floats:
        """(pieces + 1,) the knots [s]."""
        return self.knots

    def at(self, t: ArrayLike) -> Motion:
        """Position, velocity and acceleration at the times `t` (*times) [s]; at rest outside 0 .. duration."""
        moment = times(t)
        if not moment.ndim:
            return self._at_one(float(moment))
        piece, local = self._locate(moment)
        moving = moving_at(moment, self.duration, self.coefficients.ndim - 2)
        u, v, a = self._sample(piece, local)
        return Motion(u, v, a) if moving.all() else Motion(u, v * moving, a * moving)

    def _sample(self, piece: NDArray[np.intp], local: Floats) -> Motion:
        """The motion at times (*times) within pieces, its derivatives there too beyond the ends."""
        shape = self.coefficients.shape[2:]
        if local.size * prod(shape) < MANY:
            rows = self.coefficients[piece]
            return Motion(*(self._horner(rows, local, order) for order in range(3)))
        u, v, a = (np.empty((*local.shape, *shape)) for _ in range(3))
        flat = (x.reshape(local.size, -1) for x in (u, v, a))
        rows = self._with_derivatives.reshape(len(self.knots) - 1, self.degree + 1, 3, -1)
        online_loops.sample_pieces(rows, piece.ravel(), local.ravel(), *flat)
        return Motion(u, v, a)

    def _at_one(self, t: float) -> Motion:
        """At one time, as laws ask in each tick: Horner's rule once for position, velocity and acceleration."""
        clamped = min(max(t, 0.0), self.duration)
        piece = min(int(self.knots.searchsorted(clamped, side="right")), len(self.knots) - 1) - 1
        local = clamped - float(self.knots[piece])
        rows = self._with_derivatives[piece]
        value: Floats = rows[-1] + 0.0
        for row in rows[-2::-1]:
            value = value * local + row
        moving = float(0.0 <= t <= self.duration)
        return Motion(value[0], value[1] * moving, value[2] * moving)

    @cached_property
    def _with_derivatives(self) -> Floats:
        """(pieces, degree + 1, 3, *batch, n) coefficients of the motion and its derivatives, in ascending powers."""
        shape = self.coefficients.shape
        rows = np.zeros((*shape[:2], 3, *shape[2:]))
        for order in range(min(3, shape[1])):
            factors = _factors(self.degree, order).reshape((-1,) + (1,) * (len(shape) - 2))
            rows[:, : shape[1] - order, order] = factors * self.coefficients[:, order:]
        return rows

    def jerk(self, t: ArrayLike) -> Floats:
        """(*times, *batch, n) third derivative at the times `t` [rad/s^3 | m/s^3]; zero outside 0 .. duration."""
        moment = times(t)
        piece, local = self._locate(moment)
        return self._derivative(piece, local, 3) * moving_at(moment, self.duration, self.coefficients.ndim - 2)

    def derivative(self, t: ArrayLike, order: int, *, within: ArrayLike | None = None) -> Floats:
        """(*times, *batch, n) a derivative of any order, outside 0 .. duration that of its ends.

        Args:
            t: (*times) [s].
            order: 0 for the position.
            within: (*times) of the pieces that are evaluated, even beyond their ends; `t` if None [s].
        """
        moment = times(t)
        piece, local = self._locate(moment)
        if within is not None:
            piece = self._locate(times(within))[0]
            local = moment - self.knots[piece]
        return self._derivative(piece, local, order)

    def bound(self, order: int) -> Floats:
        """(*batch, n) that the magnitude of a derivative nowhere exceeds: the largest Bernstein coefficient."""
        h, degree = np.diff(self.knots), self.degree - order
        if degree < 0:
            return np.zeros(self.coefficients.shape[2:])
        powers = range(order, self.degree + 1)
        wide = (-1, *(1 for _ in self.coefficients.shape[2:]))
        scaled = [self.coefficients[:, k] * (perm(k, order) * h ** (k - order)).reshape(wide) for k in powers]
        # b_i = sum_{j <= i} C(i, j) / C(m, j) a_j of the polynomial sum_j a_j x^j on 0 .. 1.
        lift = np.array([[comb(i, j) / comb(degree, j) for j in range(degree + 1)] for i in range(degree + 1)])
        return np.abs(np.tensordot(lift, np.stack(scaled), axes=1)).max(axis=(0, 1))

    def scale_time(self, factor: float) -> PiecewisePolynomial:
        """The same path, `factor` times as slow."""
        powers = factor ** -np.arange(self.degree + 1.0)
        scaled = self.coefficients * powers.reshape((-1,) + (1,) * (self.coefficients.ndim - 2))
        return PiecewisePolynomial(frozen(self.knots * factor), frozen(scaled))

    def stationary_times(self, order: int) -> Floats:
        """(k,) times between knots at which a coordinate's derivative of the given order is stationary [s]."""
        lengths: Floats = np.diff(self.knots)
        rows = self.coefficients.reshape(len(lengths), self.degree + 1, -1)[:, order + 1 :]
        # Over a share of the piece's length coefficients are of the size of what they add to the value.
        shares = np.power(lengths[:, None], np.arange(rows.shape[1], dtype=np.float64))
        slopes = rows * (_factors(self.degree, order + 1) * shares)[..., None]
        piece, share = roots_inside(np.moveaxis(slopes, 1, -1))
        return np.unique(self.knots[piece] + share * lengths[piece])

    def _locate(self, t: Floats) -> tuple[NDArray[np.intp], Floats]:
        """Index of the piece (*times), and time since its start."""
        clamped = np.clip(t, 0.0, self.duration)
        piece = np.clip(np.searchsorted(self.knots, clamped, side="right") - 1, 0, len(self.knots) - 2)
        return piece, clamped - self.knots[piece]

    def _derivative(self, piece: NDArray[np.intp], local: Floats, order: int) -> Floats:
        return self._horner(self.coefficients[piece], local, order)

    def _horner(self, rows: Floats, local: Floats, order: int) -> Floats:
        """Horner's rule on the derivative of the given order.

        Args:
            rows: (*times, degree + 1, *batch, n) coefficients of the pieces at the times.
            local: (*times) since the pieces began [s].
            order: of the derivative.
        """
        axis = local.ndim
        local = local.reshape(local.shape + (1,) * (rows.ndim - axis - 1))
        value = np.zeros(rows.shape[:axis] + rows.shape[axis + 1 :])
        factors: list[float] = _factors(self.degree, order).tolist()
        for power, factor in reversed(list(enumerate(factors, start=order))):
            value = value * local + factor * rows.take(power, axis=axis)
        return value


@lru_cache(maxsize=256)
def _factors(degree: int, order: int) -> Floats:
    """The factors k! / (k - order)! for k = order .. degree."""
    k = np.arange(order, degree + 1, dtype=np.float64)
    factors = np.ones_like(k)
    for i in range(order):
        factors *= k - i
    return frozen(factors)


def way_length(slope: Callable[[Floats], Floats], breaks: Floats) -> float:
    """Length of a way between its first and last break: the integral of |du/ds|, by Gauss and Legendre.

    Args:
        slope: of places (k, l), to (k, l, n).
        breaks: (m,) places between which the way is smooth.
    """
    half = np.repeat(np.diff(breaks) / (2 * PANELS), PANELS)
    middle = (breaks[:-1, None] + (2 * np.arange(PANELS) + 1) * half.reshape(-1, PANELS)).ravel()
    speed = np.linalg.norm(slope(middle[:, None] + half[:, None] * NODES), axis=-1)
    return float(half @ (speed @ WEIGHTS))


def roots_inside(polynomials: Floats) -> tuple[NDArray[np.intp], Floats]:
    """Roots x with 0 < x < 1, nearly real ones included: a double root may come out as a complex pair.

    Args:
        polynomials: (pieces, n, degree + 1) ascending coefficients; leading ones may vanish.

    Returns:
        (k,) the piece to which each root belongs, and (k,) the roots.
    """
    pieces, n, count = polynomials.shape
    places: list[NDArray[np.intp]] = [np.zeros(0, dtype=np.intp)]
    roots: list[Floats] = [np.zeros(0)]
    if count < 2:
        return places[0], roots[0]
    flat = polynomials.reshape(-1, count)
    piece = np.repeat(np.arange(pieces, dtype=np.intp), n)
    degrees: NDArray[np.intp] = np.where(flat != 0.0, np.arange(count, dtype=np.intp), 0).max(axis=1, initial=0)
    for degree in range(1, count):
        mine = np.flatnonzero(degrees == degree)
        if not len(mine):
            continue
        x = _roots(flat[mine, : degree + 1])
        inside = (np.abs(x.imag) <= REAL_ROOT * (1.0 + np.abs(x.real))) & (x.real > 0.0) & (x.real < 1.0)
        places.append(np.repeat(piece[mine], degree).reshape(x.shape)[inside])
        roots.append(x.real[inside])
    return np.concatenate(places), np.concatenate(roots)


def _roots(polynomials: Floats) -> NDArray[np.complex128]:
    """(k, degree) roots of (k, degree + 1) ascending coefficients whose last is not zero."""
    k, degree = len(polynomials), polynomials.shape[1] - 1
    with np.errstate(over="ignore"):
        monic = polynomials[:, :-1] / polynomials[:, -1:]
    if degree == 1:
        return -monic.astype(np.complex128)
    if degree == 2:
        return _quadratic(monic)
    companion = np.zeros((k, degree, degree))
    companion[:, 1:, :-1] = np.eye(degree - 1)
    # A leading coefficient that is next to nothing has a root far away: none of the others suffers from clipping it.
    companion[:, :, -1] = -np.clip(monic, -1e150, 1e150)
    return np.asarray(np.linalg.eigvals(companion), dtype=np.complex128)


def _quadratic(monic: Floats) -> NDArray[np.complex128]:
    """Roots of x^2 + b x + c without cancellation: the larger one by the formula, the other from their product."""
    c, half = monic[:, 0], monic[:, 1] / 2.0
    root = np.sqrt((half**2 - c).astype(np.complex128))
    large = -(half + np.where(half >= 0.0, 1.0, -1.0) * root)
    with np.errstate(divide="ignore", invalid="ignore"):
        small = np.where(large != 0.0, c / large, 0.0)
    return np.asarray(np.stack([large, small], axis=1), dtype=np.complex128)
