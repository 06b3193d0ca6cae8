"""Time laws: how a motion from rest to rest spends its time. A law is one row of `LAWS`, found by its name.

A further polynomial law, such as the septic without jerk at its ends, is its coefficients (0, 0, 0, 0, 35, -84, 70,
-20) in a row and its name in `LawName`; what its peaks are follows from them, and everything that takes a law by its
name (Cartesian lines, the moves of a job) knows it.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Literal, Protocol, TypeAlias

import numpy as np

from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.trajectory.piecewise import PiecewisePolynomial
from mafsil.trajectory.trapezoid import trapezoid

LawName: TypeAlias = Literal["quintic", "trapezoid"]


class TimeLaw(Protocol):
    """From rest to rest, all coordinates on one share s(t) of their way, or each with its own blends."""

    def unit(self) -> PiecewisePolynomial:
        """s(t) from 0 to 1 within one second."""
        ...

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
        """The shortest motion whose peaks keep the limits.

        Args:
            start, goal: (n,) positions [rad | m | 1].
            velocity, acceleration: (n,) or a number, largest magnitudes.
            margin: share of time on top, where peaks that equal a limit by formula exceed it by rounding.
            least: shortest duration of a motion whose formula divides by it [s].
        """
        ...


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

    @cached_property
    def peaks(self) -> tuple[float, float]:
        """Largest |ds/dx| and |d2s/dx2|: peak velocity T / distance, peak acceleration T^2 / distance."""
        return self._peak(1), self._peak(2)

    def unit(self) -> PiecewisePolynomial:
        """s(t) from 0 to 1 within one second."""
        return self.between(np.zeros(1), np.ones(1), 1.0)

    def between(self, start: Floats, goal: Floats, duration: float) -> PiecewisePolynomial:
        """The motion from `start` to `goal` (n,) that takes `duration` [s]."""
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
        """Shortest time of all coordinates together [s]: peak velocity p_1 |D| / T, peak acceleration p_2 |D| / T^2.

        Args:
            distance: (n,) D to go [rad | m | 1].
            velocity, acceleration: (n,) or a number, largest magnitudes.
        """
        way = np.abs(distance)
        speed, growth = self.peaks
        each = np.maximum(speed * way / velocity, np.sqrt(growth * way / acceleration))
        return float(each.max(initial=0.0))

    def _peak(self, order: int) -> float:
        """Largest magnitude of a derivative over 0 .. 1, to the last digit.

        It lies at an end or where the next derivative vanishes; the value there, in rational numbers, has an error of
        the square of that of the place.
        """
        slope = np.array([float(_falling(k, order + 1) * c) for k, c in enumerate(self.coefficients)][order + 1 :])
        roots = np.polynomial.polynomial.polyroots(np.trim_zeros(slope, "b")) if slope.any() else np.zeros(0)
        inside = [float(x) for x in roots.real[np.abs(roots.imag) < 1e-8] if 0.0 < x < 1.0]
        return float(max(abs(_value(self.coefficients, Fraction(x), order)) for x in (0.0, *inside, 1.0)))


@dataclass(frozen=True)
class TrapezoidLaw:
    """Constant acceleration, constant speed, constant deceleration.

    Attributes:
        blend: share of the duration that each blend takes where no limits shape it.
    """

    blend: float = 0.25

    def unit(self) -> PiecewisePolynomial:
        """s(t) from 0 to 1 within one second."""
        return trapezoid(0.0, 1.0, acceleration=1.0 / (self.blend * (1.0 - self.blend)), duration=1.0).value

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
        """The shortest motion; its peaks are the limits themselves, and its formula needs neither margin nor least."""
        return trapezoid(start, goal, velocity=velocity, acceleration=acceleration).value


QUINTIC = PolynomialLaw((0, 0, 0, 10, -15, 6))
"""No acceleration at its ends. Reference: Craig, Introduction to Robotics, eq. (7.18)."""

LAWS: dict[LawName, TimeLaw] = {
    "quintic": QUINTIC,
    "trapezoid": TrapezoidLaw(),
}
"""All time laws by name."""


def time_law(name: LawName) -> TimeLaw:
    """The law of that name.

    Raises:
        InputError: there is none; the sentence lists those that are.
    """
    if name not in LAWS:
        raise InputError("input.choice", name="law", value=name, known=", ".join(LAWS))
    return LAWS[name]
