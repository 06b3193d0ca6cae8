"""Exponential, logarithm, power and hyperbolic tangent on all lanes.

References: Muller, Elementary Functions, 2016, chapter 5; Cody and Waite 1980, Software Manual for the Elementary
Functions.
"""

from __future__ import annotations

import math

from mafsil.kernels import exact as table
from mafsil.kernels.emitter import Lanes
from mafsil.kernels.exact import ordered_sum, polynomial, two_product, two_sum

LN2 = (0.6931471804855391, 7.440617110012397e-11)
"""ln 2 in two parts; products of the first with whole numbers up to 2^20 are exact."""
LN2_REST = (7.44061711000415e-11, 8.247117954110931e-23)
"""The second part again in two; products of its first with whole numbers up to 2^13 are exact."""
TWO_THIRDS = (2 / 3, 3.700743415417188e-17)


def exp(lanes: Lanes, x: str) -> str:
    """e^x."""
    # Outside this interval the result is 0 or infinite anyway; inside it n fits two halves of an exponent.
    n, r, lo = _exp_reduced(lanes, _clamp(lanes, x, -747.0, 712.0))
    return _scale(lanes, lanes.add(lanes.const(1.0), _exp_minus_one(lanes, r, lo)), n)


def tanh(lanes: Lanes, x: str) -> str:
    """Hyperbolic tangent: a polynomial up to 0.55, 1 - 2/(e^2x + 1) beyond."""
    # 1. Near zero: x + x^3 P(x^2); the closed form would cancel there.
    size = lanes.fabs(x)
    z = lanes.mul(x, x)
    near = lanes.fma(lanes.mul(x, z), polynomial(lanes, table.TANH, z, lanes.mul(z, z)), x)
    # 2. Beyond 0.55 (tanh > 1/2) the difference from 1 is at most a half, so its rounding is not magnified.
    doubled = exp(lanes, lanes.add(size, size))
    far = lanes.sub(lanes.const(1.0), lanes.div(lanes.const(2.0), lanes.add(doubled, lanes.const(1.0))))
    # 3. Both sides were computed for every lane; the sign comes last, so that minus zero stays.
    small = lanes.compare("olt", size, lanes.const(0.55))
    return lanes.copysign(lanes.select(small, near, far), x)


def _scale(lanes: Lanes, mantissa: str, n: str) -> str:
    """mantissa 2^n for |n| < 2044: in two factors, since 2^n itself may lie outside the range of doubles."""
    half = lanes.integer_op("ashr", n, lanes.whole(1))
    once = lanes.mul(mantissa, _power_of_two(lanes, half))
    return lanes.mul(once, _power_of_two(lanes, lanes.integer_op("sub", n, half)))


def _clamp(lanes: Lanes, x: str, low: float, high: float) -> str:
    """x kept in an interval; NaN stays."""
    x = lanes.select(lanes.compare("olt", x, lanes.const(low)), lanes.const(low), x)
    return lanes.select(lanes.compare("ogt", x, lanes.const(high)), lanes.const(high), x)


def _exp_reduced(lanes: Lanes, x: str) -> tuple[str, str, str]:
    """x = n ln 2 + r + lo with a whole n and |r| <= ln(2)/2.

    1. n = x / ln 2, rounded by adding 1.5 2^52, whose last place is 1; the low bits of that sum are n as an integer.
    2. ln 2 in two parts, of which n times the first is exact (n below 2^11, 33 bits); the step of the second rounds,
       and what that loses is `lo`.
    """
    # 1.
    magic = lanes.const(6755399441055744.0)
    shifted = lanes.add(lanes.mul(x, lanes.const(1 / math.log(2))), magic)
    n = lanes.sub(shifted, magic)
    # 2.
    above = lanes.sub(x, lanes.mul(n, lanes.const(LN2[0])))
    step = lanes.mul(n, lanes.const(LN2[1]))
    r = lanes.sub(above, step)
    lo = lanes.sub(lanes.sub(above, r), step)
    return lanes.integer_op("sub", lanes.bits(shifted), lanes.whole(0x4338000000000000)), r, lo


def _exp_minus_one(lanes: Lanes, r: str, lo: str) -> str:
    """e^(r + lo) - 1 on |r| <= ln(2)/2."""
    r2 = lanes.mul(r, r)
    tail = lanes.fma(r2, polynomial(lanes, table.EXP, r, r2), lo)
    return lanes.add(r, tail)


def _power_of_two(lanes: Lanes, n: str) -> str:
    """2^n for -1022 <= n <= 1023: its bits are the exponent n + 1023 from bit 52 upwards."""
    biased = lanes.integer_op("add", n, lanes.whole(1023))
    return lanes.from_bits(lanes.integer_op("shl", biased, lanes.whole(52)))


def log(lanes: Lanes, x: str) -> str:
    """Natural logarithm; -inf at 0, NaN below."""
    k, f = _log_reduced(lanes, x)
    return _log_special(lanes, x, _log_sum(lanes, k, f))


def _log_reduced(lanes: Lanes, x: str) -> tuple[str, str]:
    """x = 2^k (1 + f) with a whole k (as a double) and sqrt(1/2) <= 1 + f < sqrt(2).

    1. Subnormal numbers have no full mantissa: they are scaled by 2^54 first, which k takes off again.
    2. The bits of x less those of sqrt(1/2), shifted down to the exponent: k steps at sqrt(1/2) 2^k, not at 2^k, so f
       is small on both sides of 1 and log x does not cancel there.
    3. The mantissa is x with k taken off its exponent.
    """
    # 1.
    small = lanes.compare("olt", x, lanes.const(2.0**-1022))
    scaled = lanes.select(small, lanes.mul(x, lanes.const(2.0**54)), x)
    shift = lanes.select_integers(small, lanes.whole(54), lanes.whole(0))
    # 2. The bits of sqrt(1/2).
    root = 0x3FE6A09E667F3BCD
    above = lanes.integer_op("sub", lanes.bits(scaled), lanes.whole(root))
    k = lanes.integer_op("ashr", above, lanes.whole(52))
    # 3.
    mantissa = lanes.integer_op("sub", lanes.bits(scaled), lanes.integer_op("shl", k, lanes.whole(52)))
    f = lanes.sub(lanes.from_bits(mantissa), lanes.const(1.0))
    return lanes.to_real(lanes.integer_op("sub", k, shift)), f


def _log_sum(lanes: Lanes, k: str, f: str) -> str:
    """k ln 2 + log(1 + f), the small parts first; log(1 + f) = f - f^2/2 + s (f^2/2 + R), s = f/(2 + f).

    The series of log((1 + s)/(1 - s)) = 2 s + s z P(z), z = s^2, has odd powers only and converges fast: |s| < 0.172.
    """
    s = lanes.div(f, lanes.add(f, lanes.const(2.0)))
    z = lanes.mul(s, s)
    rest = lanes.mul(z, polynomial(lanes, table.LOG, z, lanes.mul(z, z)))
    half = lanes.mul(lanes.const(0.5), lanes.mul(f, f))
    low = lanes.mul(k, lanes.const(LN2[1]))
    inner = lanes.add(lanes.mul(s, lanes.add(half, rest)), low)
    high = lanes.mul(k, lanes.const(LN2[0]))
    return lanes.sub(high, lanes.sub(lanes.sub(half, inner), f))


def _log_special(lanes: Lanes, x: str, usual: str) -> str:
    """Logarithm at and below 0, at infinity, at NaN."""
    usual = lanes.select(lanes.compare("olt", x, lanes.const(math.inf)), usual, x)
    usual = lanes.select(lanes.compare("olt", x, lanes.const(0.0)), lanes.const(math.nan), usual)
    return lanes.select(lanes.compare("oeq", x, lanes.const(0.0)), lanes.const(-math.inf), usual)


def pow(lanes: Lanes, x: str, y: str) -> str:
    """x^y with the special cases of C: the logarithm has twice the digits, lest its product with y lose some.

    1. log |x| in two doubles; an error of 2^-65 there is at most one of 2^-55 in y log x, below 745 in magnitude.
    2. y log |x|, product and error. Beyond 1e30 the result is 0, 1 or infinite whatever y is, and nothing overflows.
    3. e to that, the error carried along.
    4. Zeros, infinities, signs and NaN as C has them.
    """
    # 1.
    high, low = _log_long(lanes, lanes.fabs(x))
    # 2.
    bounded = _clamp(lanes, y, -1e30, 1e30)
    product, error = two_product(lanes, high, bounded)
    # 3.
    size = _exp_long(lanes, product, lanes.fma(low, bounded, error))
    # 4.
    return _pow_special(lanes, x, y, size)


def _log_long(lanes: Lanes, x: str) -> tuple[str, str]:
    """log(x) for x > 0 as an unevaluated sum of two doubles, relative error about 2^-65.

    1. x = 2^k (1 + f), s = f/(2 + f) and z = s^2, the last two with their errors.
    2. log(1 + f) = 2 s + s z (2/3 + z P(z)): the inner bracket, times z, times s, each product with its error.
    3. k ln 2 in three parts is added, the large sums with their errors.
    """
    # 1.
    k, f = _log_reduced(lanes, x)
    s, s_low = _half_ratio(lanes, f)
    z, z_low = two_product(lanes, s, s)
    z_low = lanes.fma(lanes.add(s, s), s_low, z_low)
    # 2.
    tail = lanes.mul(z, polynomial(lanes, table.LOG_LONG, z, lanes.mul(z, z)))
    inner, inner_low = ordered_sum(lanes, lanes.const(TWO_THIRDS[0]), tail)
    inner_low = lanes.add(inner_low, lanes.const(TWO_THIRDS[1]))
    cubic, cubic_low = _long_product(lanes, z, z_low, inner, inner_low)
    bend, bend_low = _long_product(lanes, s, s_low, cubic, cubic_low)
    main, main_low = ordered_sum(lanes, lanes.add(s, s), bend)
    main_low = lanes.add(main_low, lanes.add(bend_low, lanes.add(s_low, s_low)))
    # 3.
    total, carried = two_sum(lanes, lanes.mul(k, lanes.const(LN2[0])), main)
    low, low_low = two_sum(lanes, lanes.mul(k, lanes.const(LN2_REST[0])), main_low)
    low_low = lanes.fma(k, lanes.const(LN2_REST[1]), low_low)
    return ordered_sum(lanes, total, lanes.add(carried, lanes.add(low, low_low)))


def _half_ratio(lanes: Lanes, f: str) -> tuple[str, str]:
    """f / (2 + f) as a quotient and its error."""
    under, under_low = ordered_sum(lanes, lanes.const(2.0), f)
    s = lanes.div(f, under)
    product, error = two_product(lanes, s, under)
    missing = lanes.sub(lanes.sub(lanes.sub(f, product), error), lanes.mul(s, under_low))
    return s, lanes.div(missing, under)


def _long_product(lanes: Lanes, x: str, x_low: str, y: str, y_low: str) -> tuple[str, str]:
    """(x + x_low) (y + y_low) as a rounded product and its error."""
    product, error = two_product(lanes, x, y)
    return product, lanes.add(error, lanes.fma(x, y_low, lanes.mul(x_low, y)))


def _exp_long(lanes: Lanes, x: str, low: str) -> str:
    """e^(x + low) for a small `low`."""
    clamped = _clamp(lanes, x, -747.0, 712.0)
    low = lanes.select(lanes.compare("oeq", clamped, x), low, lanes.const(0.0))
    n, r, lo = _exp_reduced(lanes, clamped)
    r, lo = two_sum(lanes, r, lanes.add(lo, low))
    return _scale(lanes, lanes.add(lanes.const(1.0), _exp_minus_one(lanes, r, lo)), n)


def _pow_special(lanes: Lanes, x: str, y: str, size: str) -> str:
    """x^y from |x|^y as C99 has it (annex F.9.4.4).

    1. |x| is 0 or infinite: 0 or infinite, as y is negative or not.
    2. x is negative, minus zero included: the sign of x for odd whole y.
    3. x is negative and finite, y not whole: NaN.
    4. x or y is NaN: NaN.
    5. x = 1 or y = 0: 1, even with NaN beside it.
    """
    zero, one, nan = (lanes.const(value) for value in (0.0, 1.0, math.nan))
    # 1.
    base = lanes.fabs(x)
    ends = lanes.mask_op("or", lanes.compare("oeq", base, zero), lanes.compare("oeq", base, lanes.const(math.inf)))
    falls = lanes.mask_op("xor", lanes.compare("ogt", base, one), lanes.compare("ogt", y, zero))
    size = lanes.select(ends, lanes.select(falls, zero, lanes.const(math.inf)), size)
    # 2. y is odd if y is whole and y/2 is not; beyond 2^53 every double is even.
    half = lanes.mul(y, lanes.const(0.5))
    is_whole = lanes.compare("oeq", lanes.trunc(y), y)
    is_odd = lanes.mask_op("and", is_whole, lanes.compare("une", lanes.trunc(half), half))
    minus = lanes.compare_integers("slt", lanes.bits(x), lanes.whole(0))
    size = lanes.select(lanes.mask_op("and", is_odd, minus), lanes.neg(size), size)
    # 3.
    below = lanes.mask_op("and", lanes.compare("olt", x, zero), lanes.compare("ogt", x, lanes.const(-math.inf)))
    size = lanes.select(lanes.mask_op("and", below, lanes.invert(is_whole)), nan, size)
    # 4.
    size = lanes.select(lanes.compare("uno", x, y), nan, size)
    # 5.
    always = lanes.mask_op("or", lanes.compare("oeq", x, one), lanes.compare("oeq", y, zero))
    return lanes.select(always, one, size)
