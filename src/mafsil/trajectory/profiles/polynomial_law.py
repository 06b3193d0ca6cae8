"""Time laws that are one polynomial: a row of whole coefficients, whose peaks follow from them."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.trajectory.profiles.time_law import shortest_duration
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial


def _value(coefficients: tuple[int, ...], x: Fraction, order: int) -> Fraction:
    """A derivative of the polynomial, exactly."""
    terms = (_falling(k, order) * c * x ** (k - order) for k, c in enumerate(coefficients) if k >= order)
    return sum(terms, start=Fraction(0))


def _falling(k: int, order: int) -> int:
    """k (k - 1) ... (k - order + 1)."""
    factor = 1
    for i in range(order):
        factor *= k - i
    return factor


@dataclass(frozen=True)
class PolynomialLaw:
    """s(x) = sum_k c_k x^k over x = t / T in 0 .. 1.

    Attributes:
        coefficients: c_0, c_1, ... in ascending powers, whole numbers.

    Raises:
        InputError: the polynomial does not lead from 0 to 1, or not from rest to rest.
    """

    coefficients: tuple[int, ...]

    def __post_init__(self) -> None:
        ends = [_value(self.coefficients, Fraction(x), order) for order in (0, 1) for x in (0, 1)]
        if ends != [0, 1, 0, 0]:
            raise InputError("trajectory.law_ends", coefficients=self.coefficients)

    @property
    def peaks(self) -> tuple[float, float, float]:
        """Largest |ds/dx|, |d2s/dx2| and |d3s/dx3|; see `TimeLaw.peaks`."""
        return self._peaks

    @cached_property
    def _peaks(self) -> tuple[float, float, float]:
        return self._peak(1), self._peak(2), self._peak(3)

    def unit(self) -> PiecewisePolynomial:
        """s(t) from 0 to 1 within one second."""
        return self.between(np.zeros(1), np.ones(1), 1.0)

    def between(self, start: Floats, goal: Floats, duration: float) -> PiecewisePolynomial:
        """The motion from `start` to `goal` (*batch, n) that takes `duration` [s]."""
        # A zero is positive, so that what stands still has no negative zero for a speed.
        rows = [c * (goal - start) / duration**k + 0.0 for k, c in enumerate(self.coefficients)]
        rows[0] = np.asarray(start, dtype=np.float64)
        return PiecewisePolynomial.from_pieces([duration], np.stack(rows)[None])

    def fastest(
        self,
        start: Floats,
        goal: Floats,
        *,
        velocity: Floats | float,
        acceleration: Floats | float,
        margin: float = 0.0,
        least: float = 0.0,
    ) -> PiecewisePolynomial:
        """The shortest motion whose peaks keep the limits; see `TimeLaw.fastest`."""
        shortest = self.shortest_duration(goal - start, velocity, acceleration)
        return self.between(start, goal, max(shortest * (1.0 + margin), least))

    def shortest_duration(self, distance: Floats, velocity: Floats | float, acceleration: Floats | float) -> float:
        """Shortest time of all coordinates together [s].

        Args:
            distance: (n,) D to go [rad | m | 1].
            velocity, acceleration: (n,) or a number, largest magnitudes.
        """
        return shortest_duration(self.peaks, distance, velocity, acceleration)

    def _peak(self, order: int) -> float:
        """Largest magnitude of a derivative over 0 .. 1, to the last digit.

        It lies at an end or where the next derivative vanishes; the value there, in rational numbers, has an error of
        the square of that of the place.
        """
        slope = np.array([float(_falling(k, order + 1) * c) for k, c in enumerate(self.coefficients)][order + 1 :])
        roots: NDArray[np.complex128] = np.zeros(0, dtype=np.complex128)
        if slope.any():
            roots = np.asarray(np.polynomial.polynomial.polyroots(np.trim_zeros(slope, "b")), dtype=np.complex128)
        inside = [float(x) for x in roots.real[np.abs(roots.imag) < 1e-8] if 0.0 < x < 1.0]
        return float(max(abs(_value(self.coefficients, Fraction(x), order)) for x in (0.0, *inside, 1.0)))
