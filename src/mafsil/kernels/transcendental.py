"""Elementary functions on all lanes at once, in IR arithmetic alone; ULP says how far each may be from the truth.

All are branch-free, but for huge angles and far quotients, and pass NaN on. A row's result does not depend on the lanes
beside it. On targets without fused multiply-add the same bounds hold.

References: Muller et al., Handbook of Floating-Point Arithmetic, 2018; Muller, Elementary Functions, 2016;
Cody and Waite 1980, Software Manual for the Elementary Functions.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from mafsil.kernels import coefficients as table
from mafsil.kernels.argument import reduced
from mafsil.kernels.emitter import Lanes
from mafsil.kernels.exact import ordered_sum, two_product, two_sum

ULP = {
    "sin": 1.0, "cos": 1.0, "tan": 2.0, "asin": 2.0, "acos": 2.0, "atan": 1.0, "atan2": 2.0,
    "exp": 1.0, "expm1": 2.0, "log": 1.0, "log1p": 2.0, "pow": 1.0, "hypot": 1.5,
    "sinh": 2.0, "cosh": 2.0, "tanh": 2.0, "asinh": 3.0, "acosh": 3.0, "atanh": 3.0,
}  # fmt: skip
"""Largest distance from the exact value, in units of its last place; proven by samples against mpmath in the tests."""

INFINITY = math.inf
LN2 = (0.6931471804855391, 7.440617110012397e-11)
"""ln 2 in two parts; products of the first with whole numbers up to 2^20 are exact."""
LN2_REST = (7.44061711000415e-11, 8.247117954110931e-23)
"""The second part again in two; products of its first with whole numbers up to 2^13 are exact."""
TWO_THIRDS = (2 / 3, 3.700743415417188e-17)
HALF_PI_LOW = 6.123233995736766e-17
SIGN = 1 << 63


def polynomial(lanes: Lanes, coefficients: Sequence[float], z: str, z2: str) -> str:
    """Sum of coefficients[k] z^k by Estrin's scheme on pairs, z2 = z*z."""
    pairs = [
        lanes.fma(z, lanes.const(coefficients[k + 1]), lanes.const(coefficients[k]))
        for k in range(0, len(coefficients) - 1, 2)
    ]
    if len(coefficients) % 2:
        pairs.append(lanes.const(coefficients[-1]))
    total = pairs[-1]
    for pair in reversed(pairs[:-1]):
        total = lanes.fma(z2, total, pair)
    return total


def sincos(lanes: Lanes, angles: list[str], wanted: list[set[str]]) -> list[tuple[str, str]]:
    """(sin, cos) of every angle; what is not wanted is an empty name."""
    return [_on_quarter(lanes, *parts, want) for parts, want in zip(reduced(lanes, angles), wanted, strict=True)]


def _on_quarter(lanes: Lanes, r: str, lo: str, turns: str, wanted: set[str]) -> tuple[str, str]:
    """sin and cos of n pi/2 + r + lo."""
    z = lanes.mul(r, r)
    z2 = lanes.mul(z, z)
    small = lanes.add(r, lanes.fma(lanes.mul(r, z), polynomial(lanes, table.SIN, z, z2), lo))
    tail = lanes.fms(z2, polynomial(lanes, table.COS, z, z2), lanes.mul(r, lo))
    large = lanes.add(lanes.const(1.0), lanes.fma(lanes.const(-0.5), z, tail))
    odd = lanes.compare_integers("ne", lanes.integer_op("and", turns, lanes.whole(1)), lanes.whole(0))
    sine = cosine = ""
    if "sin" in wanted:
        sine = _turned(lanes, lanes.select(odd, large, small), turns)
    if "cos" in wanted:
        after = lanes.integer_op("add", turns, lanes.whole(1))
        cosine = _turned(lanes, lanes.select(odd, small, large), after)
    return sine, cosine


def _turned(lanes: Lanes, x: str, turns: str) -> str:
    """-x if bit 1 of `turns` is set."""
    sign = lanes.integer_op("and", lanes.integer_op("shl", turns, lanes.whole(62)), lanes.whole(SIGN))
    return lanes.from_bits(lanes.integer_op("xor", lanes.bits(x), sign))


def _sign_bit(lanes: Lanes, x: str) -> str:
    return lanes.integer_op("and", lanes.bits(x), lanes.whole(SIGN))


def _with_sign(lanes: Lanes, x: str, sign: str) -> str:
    """x, its sign flipped where the sign bit is set."""
    return lanes.from_bits(lanes.integer_op("xor", lanes.bits(x), sign))


def exp(lanes: Lanes, x: str) -> str:
    """e^x."""
    return _exp_scaled(lanes, x, 0)


def _exp_scaled(lanes: Lanes, x: str, power: int) -> str:
    """2^power e^x: the power joins the exponent, so nothing overflows early."""
    n, r, lo = _exp_reduced(lanes, _clamped(lanes, x, -747.0, 712.0))
    mantissa = lanes.add(lanes.const(1.0), _exp_minus_one(lanes, r, lo))
    whole = lanes.integer_op("add", n, lanes.whole(power))
    half = lanes.integer_op("ashr", whole, lanes.whole(1))
    once = lanes.mul(mantissa, _power_of_two(lanes, half))
    return lanes.mul(once, _power_of_two(lanes, lanes.integer_op("sub", whole, half)))


def _clamped(lanes: Lanes, x: str, low: float, high: float) -> str:
    """x kept in an interval; NaN stays."""
    x = lanes.select(lanes.compare("olt", x, lanes.const(low)), lanes.const(low), x)
    return lanes.select(lanes.compare("ogt", x, lanes.const(high)), lanes.const(high), x)


def _exp_reduced(lanes: Lanes, x: str) -> tuple[str, str, str]:
    """x = n ln 2 + r + lo with a whole n and |r| <= ln(2)/2."""
    magic = lanes.const(6755399441055744.0)
    shifted = lanes.add(lanes.mul(x, lanes.const(1 / math.log(2))), magic)
    n = lanes.sub(shifted, magic)
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
    """2^n for -1022 <= n <= 1023."""
    biased = lanes.integer_op("add", n, lanes.whole(1023))
    return lanes.from_bits(lanes.integer_op("shl", biased, lanes.whole(52)))


def expm1(lanes: Lanes, x: str) -> str:
    """e^x - 1 without cancellation at 0."""
    n, r, lo = _exp_reduced(lanes, _clamped(lanes, x, -50.0, 710.0))
    half = _power_of_two(lanes, lanes.integer_op("sub", n, lanes.whole(1)))
    sum_ = lanes.fma(half, _exp_minus_one(lanes, r, lo), lanes.sub(half, lanes.const(0.5)))
    tiny = lanes.compare("olt", lanes.fabs(x), lanes.const(2.0**-54))
    return lanes.select(tiny, x, lanes.mul(lanes.const(2.0), sum_))


def log(lanes: Lanes, x: str) -> str:
    """Natural logarithm; -inf at 0, NaN below."""
    k, f = _log_reduced(lanes, x)
    return _log_special(lanes, x, _log_sum(lanes, k, f, lanes.const(0.0)))


def _log_reduced(lanes: Lanes, x: str) -> tuple[str, str]:
    """x = 2^k (1 + f) with a whole k (as a double) and sqrt(1/2) <= 1 + f < sqrt(2)."""
    small = lanes.compare("olt", x, lanes.const(2.0**-1022))
    scaled = lanes.select(small, lanes.mul(x, lanes.const(2.0**54)), x)
    shift = lanes.select_integers(small, lanes.whole(54), lanes.whole(0))
    root = 0x3FE6A09E667F3BCD
    above = lanes.integer_op("sub", lanes.bits(scaled), lanes.whole(root))
    k = lanes.integer_op("ashr", above, lanes.whole(52))
    mantissa = lanes.integer_op("sub", lanes.bits(scaled), lanes.integer_op("shl", k, lanes.whole(52)))
    f = lanes.sub(lanes.from_bits(mantissa), lanes.const(1.0))
    return lanes.to_real(lanes.integer_op("sub", k, shift)), f


def _log_sum(lanes: Lanes, k: str, f: str, extra: str) -> str:
    """k ln 2 + log(1 + f) + extra, the small parts first; log(1 + f) = f - f^2/2 + s (f^2/2 + R), s = f/(2 + f)."""
    s = lanes.div(f, lanes.add(f, lanes.const(2.0)))
    z = lanes.mul(s, s)
    rest = lanes.mul(z, polynomial(lanes, table.LOG, z, lanes.mul(z, z)))
    half = lanes.mul(lanes.const(0.5), lanes.mul(f, f))
    low = lanes.add(lanes.mul(k, lanes.const(LN2[1])), extra)
    inner = lanes.add(lanes.mul(s, lanes.add(half, rest)), low)
    high = lanes.mul(k, lanes.const(LN2[0]))
    return lanes.sub(high, lanes.sub(lanes.sub(half, inner), f))


def _log_special(lanes: Lanes, x: str, usual: str) -> str:
    """Logarithm at and below 0, at infinity, at NaN."""
    usual = lanes.select(lanes.compare("olt", x, lanes.const(INFINITY)), usual, x)
    usual = lanes.select(lanes.compare("olt", x, lanes.const(0.0)), lanes.const(math.nan), usual)
    return lanes.select(lanes.compare("oeq", x, lanes.const(0.0)), lanes.const(-INFINITY), usual)


def log1p(lanes: Lanes, x: str) -> str:
    """log(1 + x) without cancellation at 0."""
    u = lanes.add(lanes.const(1.0), x)
    large = lanes.compare("ogt", lanes.fabs(x), lanes.const(1.0))
    lost = lanes.select(
        large, lanes.sub(lanes.const(1.0), lanes.sub(u, x)), lanes.sub(x, lanes.sub(u, lanes.const(1.0)))
    )
    k, f = _log_reduced(lanes, u)
    sum_ = _log_special(lanes, u, _log_sum(lanes, k, f, lanes.div(lost, u)))
    tiny = lanes.compare("olt", lanes.fabs(x), lanes.const(2.0**-54))
    return lanes.select(tiny, x, sum_)


def sinh(lanes: Lanes, x: str) -> str:
    """Hyperbolic sine: a polynomial up to 1, exponentials beyond."""
    z = lanes.mul(x, x)
    near = lanes.fma(lanes.mul(x, z), polynomial(lanes, table.SINH, z, lanes.mul(z, z)), x)
    half = _exp_scaled(lanes, lanes.fabs(x), -1)
    far = lanes.sub(half, lanes.div(lanes.const(0.25), half))
    small = lanes.compare("olt", lanes.fabs(x), lanes.const(1.0))
    return lanes.select(small, near, lanes.copysign(far, x))


def cosh(lanes: Lanes, x: str) -> str:
    """Hyperbolic cosine."""
    half = _exp_scaled(lanes, lanes.fabs(x), -1)
    return lanes.add(half, lanes.div(lanes.const(0.25), half))


def tanh(lanes: Lanes, x: str) -> str:
    """Hyperbolic tangent: a polynomial up to 0.55, 1 - 2/(e^2x + 1) beyond."""
    size = lanes.fabs(x)
    z = lanes.mul(x, x)
    near = lanes.fma(lanes.mul(x, z), polynomial(lanes, table.TANH, z, lanes.mul(z, z)), x)
    doubled = _exp_scaled(lanes, lanes.add(size, size), 0)
    far = lanes.sub(lanes.const(1.0), lanes.div(lanes.const(2.0), lanes.add(doubled, lanes.const(1.0))))
    small = lanes.compare("olt", size, lanes.const(0.55))
    return lanes.select(small, near, lanes.copysign(far, x))


def asinh(lanes: Lanes, x: str) -> str:
    """log(|x| + sqrt(1 + x^2)), signed."""
    size = lanes.fabs(x)
    large = lanes.compare("ogt", size, lanes.const(2.0**28))
    held = lanes.select(large, lanes.const(1.0), size)
    square = lanes.mul(held, held)
    root = lanes.sqrt(lanes.add(lanes.const(1.0), square))
    inner = lanes.add(held, lanes.div(square, lanes.add(lanes.const(1.0), root)))
    far = lanes.add(log(lanes, size), lanes.const(math.log(2)))
    return lanes.copysign(lanes.select(large, far, log1p(lanes, inner)), x)


def acosh(lanes: Lanes, x: str) -> str:
    """log(x + sqrt(x^2 - 1)); NaN below 1."""
    large = lanes.compare("ogt", x, lanes.const(2.0**28))
    above = lanes.sub(lanes.select(large, lanes.const(1.0), x), lanes.const(1.0))
    root = lanes.sqrt(lanes.mul(above, lanes.add(above, lanes.const(2.0))))
    far = lanes.add(log(lanes, x), lanes.const(math.log(2)))
    near = log1p(lanes, lanes.add(above, root))
    result = lanes.select(large, far, near)
    return lanes.select(lanes.compare("olt", x, lanes.const(1.0)), lanes.const(math.nan), result)


def atanh(lanes: Lanes, x: str) -> str:
    """log1p(2|x| / (1 - |x|)) / 2, signed."""
    size = lanes.fabs(x)
    ratio = lanes.div(lanes.add(size, size), lanes.sub(lanes.const(1.0), size))
    result = lanes.mul(lanes.const(0.5), log1p(lanes, ratio))
    result = lanes.select(lanes.compare("ogt", size, lanes.const(1.0)), lanes.const(math.nan), result)
    return lanes.copysign(result, x)


def atan(lanes: Lanes, x: str) -> str:
    """Arc tangent."""
    size = lanes.fabs(x)
    small = lanes.compare("olt", size, lanes.const(1.0))
    one = lanes.const(1.0)
    angle = _atan_of_quotient(lanes, lanes.select(small, size, one), lanes.select(small, one, size))
    return lanes.copysign(_from_quarter(lanes, angle, small), x)


def _atan_of_quotient(lanes: Lanes, a: str, b: str) -> tuple[str, str]:
    """atan(a/b) for 0 <= a <= b as a main part and a small one; beyond tan(pi/8) as pi/4 + atan((a-b)/(a+b))."""
    beyond = lanes.compare("ogt", a, lanes.mul(b, lanes.const(math.tan(math.pi / 8))))
    over = lanes.select(beyond, lanes.sub(a, b), a)
    under = lanes.select(beyond, lanes.add(a, b), b)
    t = lanes.div(over, under)
    z = lanes.mul(t, t)
    tail = lanes.mul(lanes.mul(t, z), polynomial(lanes, table.ATAN, z, lanes.mul(z, z)))
    eighth = lanes.select(beyond, lanes.const(math.pi / 4), lanes.const(0.0))
    low = lanes.select(beyond, lanes.const(HALF_PI_LOW / 2), lanes.const(0.0))
    main = lanes.add(eighth, t)
    lost = lanes.add(lanes.sub(t, lanes.sub(main, eighth)), low)
    return main, lanes.add(tail, lost)


def _from_quarter(lanes: Lanes, angle: tuple[str, str], direct: str) -> str:
    """The angle itself where `direct`, else pi/2 minus it."""
    main, rest = angle
    quarter = lanes.const(math.pi / 2)
    turned = lanes.sub(quarter, lanes.sub(main, lanes.sub(lanes.const(HALF_PI_LOW), rest)))
    return lanes.select(direct, lanes.add(main, rest), turned)


def atan2(lanes: Lanes, y: str, x: str) -> str:
    """Angle of (x, y), with the signs of zeros and the infinities of C."""
    height, width = lanes.fabs(y), lanes.fabs(x)
    steep = lanes.compare("ogt", height, width)
    over = lanes.select(steep, width, height)
    under = lanes.select(steep, height, width)
    over, under = _safe_quotient(lanes, over, under)
    main, rest = _atan_of_quotient(lanes, over, under)
    leftward = lanes.compare_integers("slt", lanes.bits(x), lanes.whole(0))
    def by_octant(quarter: float, half: float) -> str:
        return lanes.select(
            steep, lanes.const(quarter), lanes.select(leftward, lanes.const(half), lanes.const(0.0))
        )

    base, low = by_octant(math.pi / 2, math.pi), by_octant(HALF_PI_LOW, 2 * HALF_PI_LOW)
    minus = lanes.mask_op("xor", steep, leftward)
    main = lanes.select(minus, lanes.neg(main), main)
    rest = lanes.select(minus, lanes.neg(rest), rest)
    total = lanes.add(base, main)
    lost = lanes.sub(main, lanes.sub(total, base))
    angle = lanes.add(total, lanes.add(lanes.add(lost, low), rest))
    return _with_sign(lanes, angle, _sign_bit(lanes, y))


def _safe_quotient(lanes: Lanes, over: str, under: str) -> tuple[str, str]:
    """over/under, 0 <= over <= under, rescaled: 0/0 is 0/1, inf/inf is 1/1, sums of huge numbers do not overflow."""
    huge = lanes.compare("ogt", under, lanes.const(2.0**1000))
    scale = lanes.select(huge, lanes.const(2.0**-100), lanes.const(1.0))
    none = lanes.compare("oeq", under, lanes.const(0.0))
    endless = lanes.mask_op("and", *(lanes.compare("oeq", x, lanes.const(INFINITY)) for x in (over, under)))
    over = lanes.select(endless, lanes.const(1.0), lanes.mul(over, scale))
    under = lanes.select(endless, lanes.const(1.0), lanes.mul(under, scale))
    return over, lanes.select(none, lanes.const(1.0), under)


def asin(lanes: Lanes, x: str) -> str:
    """Arc sine; NaN beyond 1."""
    size = lanes.fabs(x)
    small, z, root = _arc_reduced(lanes, size)
    t = lanes.select(small, size, root)
    tail = lanes.mul(lanes.mul(t, z), polynomial(lanes, table.ASIN, z, lanes.mul(z, z)))
    near = lanes.add(t, tail)
    lost = lanes.sub(lanes.const(HALF_PI_LOW), lanes.mul(lanes.const(2.0), lanes.add(tail, _root_error(lanes, root, z))))
    quarter, twice = lanes.const(math.pi / 2), lanes.mul(lanes.const(2.0), t)
    total = lanes.sub(quarter, twice)
    carried = lanes.sub(lanes.sub(quarter, total), twice)
    far = lanes.add(total, lanes.add(carried, lost))
    return lanes.copysign(lanes.select(small, near, far), x)


def acos(lanes: Lanes, x: str) -> str:
    """Arc cosine; NaN beyond 1."""
    size = lanes.fabs(x)
    small, z, root = _arc_reduced(lanes, size)
    t = lanes.select(small, x, root)
    tail = lanes.mul(lanes.mul(t, z), polynomial(lanes, table.ASIN, z, lanes.mul(z, z)))
    quarter = lanes.const(math.pi / 2)
    total = lanes.sub(quarter, t)
    carried = lanes.sub(lanes.sub(quarter, total), t)
    near = lanes.add(total, lanes.add(carried, lanes.sub(lanes.const(HALF_PI_LOW), tail)))
    tail = lanes.add(tail, _root_error(lanes, root, z))
    right = lanes.mul(lanes.const(2.0), lanes.add(root, tail))
    half_turn, twice = lanes.const(math.pi), lanes.mul(lanes.const(2.0), root)
    total = lanes.sub(half_turn, twice)
    carried = lanes.sub(lanes.sub(half_turn, total), twice)
    low = lanes.sub(lanes.const(2 * HALF_PI_LOW), lanes.mul(lanes.const(2.0), tail))
    left = lanes.add(total, lanes.add(carried, low))
    far = lanes.select(lanes.compare("olt", x, lanes.const(0.0)), left, right)
    return lanes.select(small, near, far)


def _arc_reduced(lanes: Lanes, size: str) -> tuple[str, str, str]:
    """|x| < 1/2, the square of the sine in use, and sqrt((1 - |x|)/2)."""
    small = lanes.compare("olt", size, lanes.const(0.5))
    half = lanes.mul(lanes.const(0.5), lanes.sub(lanes.const(1.0), size))
    return small, lanes.select(small, lanes.mul(size, size), half), lanes.sqrt(half)


def _root_error(lanes: Lanes, root: str, square: str) -> str:
    """What is missing in root = sqrt(square): (square - root^2) / (2 root)."""
    product, error = two_product(lanes, root, root)
    missing = lanes.sub(lanes.sub(square, product), error)
    floor = lanes.select(lanes.compare("ogt", root, lanes.const(0.0)), root, lanes.const(1.0))
    return lanes.div(missing, lanes.add(floor, floor))


def hypot(lanes: Lanes, x: str, y: str) -> str:
    """sqrt(x^2 + y^2) without overflow; an infinity wins over NaN, as in C."""
    a, b = lanes.fabs(x), lanes.fabs(y)
    steep = lanes.compare("ogt", b, a)
    large, small = lanes.select(steep, b, a), lanes.select(steep, a, b)
    up = lanes.compare("olt", large, lanes.const(2.0**-500))
    down = lanes.compare("ogt", large, lanes.const(2.0**500))
    scale = lanes.select(up, lanes.const(2.0**600), lanes.select(down, lanes.const(2.0**-600), lanes.const(1.0)))
    back = lanes.select(up, lanes.const(2.0**-600), lanes.select(down, lanes.const(2.0**600), lanes.const(1.0)))
    large, small = lanes.mul(large, scale), lanes.mul(small, scale)
    root = lanes.mul(lanes.sqrt(lanes.fma(large, large, lanes.mul(small, small))), back)
    endless = lanes.mask_op(
        "or",
        lanes.compare("oeq", a, lanes.const(INFINITY)),
        lanes.compare("oeq", b, lanes.const(INFINITY)),
    )
    return lanes.select(endless, lanes.const(INFINITY), root)


def pow(lanes: Lanes, x: str, y: str) -> str:
    """x^y with the special cases of C: the logarithm to twice the digits, so that its product with y is exact enough."""
    high, low = _log_long(lanes, lanes.fabs(x))
    bounded = _clamped(lanes, y, -1e30, 1e30)
    product, error = two_product(lanes, high, bounded)
    size = _exp_long(lanes, product, lanes.fma(low, bounded, error))
    return _pow_special(lanes, x, y, size)


def _log_long(lanes: Lanes, x: str) -> tuple[str, str]:
    """log(x) for x > 0 as an unevaluated sum of two doubles, relative error about 2^-65."""
    k, f = _log_reduced(lanes, x)
    s, s_low = _half_ratio(lanes, f)
    z, z_low = two_product(lanes, s, s)
    z_low = lanes.fma(lanes.add(s, s), s_low, z_low)
    # log(1 + f) = 2 s + s z (2/3 + z P(z))
    tail = lanes.mul(z, polynomial(lanes, table.LOG_LONG, z, lanes.mul(z, z)))
    inner, inner_low = ordered_sum(lanes, lanes.const(TWO_THIRDS[0]), tail)
    inner_low = lanes.add(inner_low, lanes.const(TWO_THIRDS[1]))
    cubic, cubic_low = _long_product(lanes, z, z_low, inner, inner_low)
    bend, bend_low = _long_product(lanes, s, s_low, cubic, cubic_low)
    main, main_low = ordered_sum(lanes, lanes.add(s, s), bend)
    main_low = lanes.add(main_low, lanes.add(bend_low, lanes.add(s_low, s_low)))
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
    clamped = _clamped(lanes, x, -747.0, 712.0)
    low = lanes.select(lanes.compare("oeq", clamped, x), low, lanes.const(0.0))
    n, r, lo = _exp_reduced(lanes, clamped)
    r, lo = two_sum(lanes, r, lanes.add(lo, low))
    mantissa = lanes.add(lanes.const(1.0), _exp_minus_one(lanes, r, lo))
    half = lanes.integer_op("ashr", n, lanes.whole(1))
    once = lanes.mul(mantissa, _power_of_two(lanes, half))
    return lanes.mul(once, _power_of_two(lanes, lanes.integer_op("sub", n, half)))


def _pow_special(lanes: Lanes, x: str, y: str, size: str) -> str:
    """x^y from |x|^y: zeros, infinities, signs, NaN."""
    zero, one, nan = (lanes.const(value) for value in (0.0, 1.0, math.nan))
    base = lanes.fabs(x)
    ends = lanes.mask_op("or", lanes.compare("oeq", base, zero), lanes.compare("oeq", base, lanes.const(INFINITY)))
    falls = lanes.mask_op("xor", lanes.compare("ogt", base, one), lanes.compare("ogt", y, zero))
    size = lanes.select(ends, lanes.select(falls, zero, lanes.const(INFINITY)), size)
    half = lanes.mul(y, lanes.const(0.5))
    is_whole = lanes.compare("oeq", lanes.trunc(y), y)
    is_odd = lanes.mask_op("and", is_whole, lanes.compare("une", lanes.trunc(half), half))
    minus = lanes.compare_integers("slt", lanes.bits(x), lanes.whole(0))
    size = lanes.select(lanes.mask_op("and", is_odd, minus), lanes.neg(size), size)
    below = lanes.mask_op("and", lanes.compare("olt", x, zero), lanes.compare("ogt", x, lanes.const(-INFINITY)))
    size = lanes.select(lanes.mask_op("and", below, lanes.invert(is_whole)), nan, size)
    size = lanes.select(lanes.compare("uno", x, y), nan, size)
    always = lanes.mask_op("or", lanes.compare("oeq", x, one), lanes.compare("oeq", y, zero))
    return lanes.select(always, one, size)
