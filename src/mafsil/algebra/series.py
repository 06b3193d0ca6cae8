"""Analytic functions of s = theta**2 (theta [rad]) behind exp, log and Jacobians; the only small-angle switches.

Every function is exact and smooth at zero. Below the switch point a Taylor polynomial speaks, above it a closed form;
the switch point is where the first dropped term is one rounding error, computed from the coefficients, never guessed.
The dead side of a select never divides by zero, so derivatives are clean as well.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from math import comb, factorial

import mafsil.expression as ex
from mafsil.floating_point import EPS


def half_sine(s: ex.Expression) -> ex.Expression:
    """sin(theta / 2) / theta."""
    return _join(s, _HALF_SINE, lambda safe: ex.sin(ex.sqrt(safe) / 2) / ex.sqrt(safe), _HALF_SWITCH)


def half_cosine(s: ex.Expression) -> ex.Expression:
    """cos(theta / 2)."""
    return _join(s, _HALF_COSINE, lambda safe: ex.cos(ex.sqrt(safe) / 2), _HALF_SWITCH)


def sinc(s: ex.Expression) -> ex.Expression:
    """sin(theta) / theta, by half angles."""
    return 2 * half_sine(s) * half_cosine(s)


def versinc(s: ex.Expression) -> ex.Expression:
    """(1 - cos(theta)) / theta**2, by half angles: nothing cancels."""
    return 2 * half_sine(s) ** 2


def sinc_defect(s: ex.Expression) -> ex.Expression:
    """(theta - sin(theta)) / theta**3."""
    return _join(s, _SINC_DEFECT, lambda safe: (1 - sinc(s)) / safe)


def versinc_slope(s: ex.Expression) -> ex.Expression:
    """Derivative of versinc by s, (theta sin(theta) - 2 (1 - cos(theta))) / (2 theta**4)."""
    return _join(s, _VERSINC_SLOPE, lambda safe: (sinc(s) / 2 - versinc(s)) / safe)


def sinc_defect_slope(s: ex.Expression) -> ex.Expression:
    """Derivative of sinc_defect by s, (theta (1 - cos(theta)) - 3 (theta - sin(theta))) / (2 theta**5)."""
    return _join(s, _SINC_DEFECT_SLOPE, lambda safe: (versinc(s) - 3 * (1 - sinc(s)) / safe) / (2 * safe))


def cotangent_defect(s: ex.Expression) -> ex.Expression:
    """(1 - (theta / 2) cot(theta / 2)) / theta**2, for theta < 2 pi."""
    return _join(s, _COTANGENT_DEFECT, lambda safe: (1 - half_cosine(s) / (2 * half_sine(s))) / safe)


def cotangent_defect_slope(s: ex.Expression) -> ex.Expression:
    """Derivative of cotangent_defect by s, for theta < 2 pi.

    (1 / sin(x)^2 + x cot(x) - 2) / (2 theta^4), x = theta / 2, with the sine's square taken over x^2
    """
    a, c = half_sine(s), half_cosine(s)
    return _join(s, _COTANGENT_DEFECT_SLOPE, lambda safe: (1 / (4 * a**2) + c / (2 * a) - 2) / (2 * safe**2))


def arctangent_ratio(y2: ex.Expression, x: ex.Expression) -> ex.Expression:
    """atan2(y, x) / y with y = sqrt(y2) >= 0, for x >= 0, not both zero; 1 / x at y = 0."""
    near = y2 < _switch(_ARCTANGENT) * x**2
    y = ex.sqrt(ex.if_else(near, 1.0, y2))
    x_near = ex.if_else(near, x, 1.0)
    return ex.if_else(near, _horner(_ARCTANGENT, y2 / x_near**2) / x_near, ex.atan2(y, x) / y)


def bernoulli_numbers(count: int) -> list[Fraction]:
    """B_0, ..., B_(count-1), with B_1 = -1/2.

    sum over j <= m of C(m + 1, j) B_j = 0
    """
    numbers = [Fraction(1)]
    for m in range(1, count):
        numbers.append(-sum((comb(m + 1, j) * numbers[j] for j in range(m)), Fraction(0)) / (m + 1))
    return numbers


def _switch(taylor: Sequence[float]) -> float:
    """The s at which the last coefficient's term, which is dropped, is one rounding error of the first."""
    return (EPS * abs(taylor[0] / taylor[-1])) ** (1 / (len(taylor) - 1))


def _join(
    s: ex.Expression,
    taylor: Sequence[float],
    closed: Callable[[ex.Expression], ex.Expression],
    switch: float | None = None,
) -> ex.Expression:
    """Taylor polynomial below the switch point; above it the closed form, whose divisors are `safe` from zero below."""
    near = s < (switch or _switch(taylor))
    return ex.if_else(near, _horner(taylor, s), closed(ex.if_else(near, 1.0, s)))


def _horner(taylor: Sequence[float], s: ex.Expression) -> ex.Expression:
    """All coefficients but the last, which only served to place the switch point."""
    value = ex.Expression(taylor[-2])
    for coefficient in reversed(taylor[:-2]):
        value = coefficient + s * value
    return value


def _slope(taylor: Sequence[float]) -> list[float]:
    return [k * coefficient for k, coefficient in enumerate(taylor)][1:]


_HALF_SINE = [(-1) ** k / (factorial(2 * k + 1) * 2 * 4**k) for k in range(6)]
_HALF_COSINE = [(-1) ** k / (factorial(2 * k) * 4**k) for k in range(6)]
_HALF_SWITCH = min(_switch(_HALF_SINE), _switch(_HALF_COSINE))
_VERSINC = [(-1) ** k / factorial(2 * k + 2) for k in range(12)]
_SINC_DEFECT = [(-1) ** k / factorial(2 * k + 3) for k in range(12)]
_COTANGENT_DEFECT = [float(abs(B) / factorial(2 * k + 2)) for k, B in enumerate(bernoulli_numbers(28)[2::2])]
_VERSINC_SLOPE, _SINC_DEFECT_SLOPE, _COTANGENT_DEFECT_SLOPE = map(_slope, (_VERSINC, _SINC_DEFECT, _COTANGENT_DEFECT))
_ARCTANGENT = [(-1) ** k / (2 * k + 1) for k in range(7)]
