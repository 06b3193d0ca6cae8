"""Trigonometric functions and their inverses on all lanes.

Reference: Muller, Elementary Functions, 2016, chapters 9 to 11.
"""

from __future__ import annotations

import math

from mafsil.kernels import exact as table
from mafsil.kernels.argument import HALF_PI_LOW, reduce_angles
from mafsil.kernels.emitter import Lanes
from mafsil.kernels.exact import ordered_sum, polynomial, two_product

SIGN = 1 << 63


def sincos(lanes: Lanes, angles: list[str], needed: list[set[str]]) -> list[tuple[str, str]]:
    """(sin, cos) of every angle; what is not needed is an empty name."""
    return [_on_quarter(lanes, *parts, want) for parts, want in zip(reduce_angles(lanes, angles), needed, strict=True)]


def _on_quarter(lanes: Lanes, r: str, rest: str, turns: str, needed: set[str]) -> tuple[str, str]:
    """sin and cos of n pi/2 + r - rest.

    1. On |r| <= pi/4: sin r = r - r^3 P(r^2) and cos r = 1 - r^2/2 + r^4 Q(r^2); the rest enters to first order:
       sin(r - rest) = sin r - rest, cos(r - rest) = cos r + r rest.
    2. A quarter turn exchanges them: for odd n, sin of the whole is cos of the part.
    3. Signs: sin is negative for n = 2, 3 (mod 4), cos for n = 1, 2, which is the same of n + 1.
    """
    # 1. The large term is added last in both, so only its rounding counts.
    z = lanes.mul(r, r)
    z2 = lanes.mul(z, z)
    small = lanes.sub(r, lanes.fnma(lanes.mul(r, z), polynomial(lanes, table.SIN, z, z2), rest))
    tail = lanes.fma(z2, polynomial(lanes, table.COS, z, z2), lanes.mul(r, rest))
    large = lanes.add(lanes.const(1.0), lanes.fnma(lanes.mul(lanes.const(0.5), r), r, tail))
    # 2. and 3.
    odd = lanes.compare_integers("ne", lanes.integer_op("and", turns, lanes.whole(1)), lanes.whole(0))
    sine = cosine = ""
    if "sin" in needed:
        sine = _turn(lanes, lanes.select(odd, large, small), turns)
    if "cos" in needed:
        after = lanes.integer_op("add", turns, lanes.whole(1))
        cosine = _turn(lanes, lanes.select(odd, small, large), after)
    return sine, cosine


def _turn(lanes: Lanes, x: str, turns: str) -> str:
    """-x if bit 1 of `turns` is set: the bit is moved to the place of the sign and flips it there."""
    sign = lanes.integer_op("and", lanes.integer_op("shl", turns, lanes.whole(62)), lanes.whole(SIGN))
    return lanes.from_bits(lanes.integer_op("xor", lanes.bits(x), sign))


def tan(lanes: Lanes, x: str) -> str:
    """Tangent: a quotient of sine and cosine, each with its rounding error, and one step that mends the quotient.

    1. The angle as quarter turns and r.
    2. sin and cos of r, each as a main part and a small one: rounded alone they would cost one unit in the last place
       each, and the quotient a third.
    3. tan(n pi/2 + r) is sin/cos for even n and -cos/sin for odd n.
    4. The quotient, and one step of Newton for what it lacks: quotient under - over, found exactly.
    """
    # 1.
    ((r, rest, turns),) = reduce_angles(lanes, [x])
    # 2.
    z = lanes.mul(r, r)
    z2 = lanes.mul(z, z)
    bend = lanes.fnma(lanes.mul(r, z), polynomial(lanes, table.SIN, z, z2), rest)
    sine, sine_low = ordered_sum(lanes, r, lanes.neg(bend))
    drop, drop_low = two_product(lanes, lanes.mul(lanes.const(0.5), r), r)
    main, lost = ordered_sum(lanes, lanes.const(1.0), lanes.neg(drop))
    tail = lanes.fma(z2, polynomial(lanes, table.COS, z, z2), lanes.mul(r, rest))
    cosine, cosine_low = ordered_sum(lanes, main, lanes.add(lanes.sub(lost, drop_low), tail))
    # 3.
    odd = lanes.compare_integers("ne", lanes.integer_op("and", turns, lanes.whole(1)), lanes.whole(0))
    over, over_low = lanes.select(odd, cosine, sine), lanes.select(odd, cosine_low, sine_low)
    under, under_low = lanes.select(odd, sine, cosine), lanes.select(odd, sine_low, cosine_low)
    # 4.
    quotient = lanes.div(over, under)
    product, error = two_product(lanes, quotient, under)
    excess = lanes.add(lanes.add(lanes.sub(product, over), error), lanes.fms(quotient, under_low, over_low))
    quotient = lanes.sub(quotient, lanes.div(excess, under))
    return lanes.select(odd, lanes.neg(quotient), quotient)


def atan(lanes: Lanes, x: str) -> str:
    """Arc tangent: of |x| below 1, of 1/|x| above, where it is pi/2 less; then the sign."""
    size = lanes.fabs(x)
    small = lanes.compare("olt", size, lanes.const(1.0))
    one = lanes.const(1.0)
    angle = _atan_of_quotient(lanes, lanes.select(small, size, one), lanes.select(small, one, size))
    return lanes.copysign(_from_quarter(lanes, angle, small), x)


def _atan_of_quotient(lanes: Lanes, a: str, b: str) -> tuple[str, str]:
    """atan(a/b) for 0 <= a <= b as a main part and a small one; beyond tan(pi/8) as pi/4 + atan((a-b)/(a+b)).

    1. Which of the two, so that the polynomial needs to reach no farther than tan(pi/8) = 0.414.
    2. One division: t, and atan t = t + t^3 P(t^2).
    3. pi/4 (in two parts) is added; what the sum loses joins the small part.
    """
    # 1.
    beyond = lanes.compare("ogt", a, lanes.mul(b, lanes.const(math.tan(math.pi / 8))))
    over = lanes.select(beyond, lanes.sub(a, b), a)
    under = lanes.select(beyond, lanes.add(a, b), b)
    # 2.
    t = lanes.div(over, under)
    z = lanes.mul(t, t)
    tail = lanes.mul(lanes.mul(t, z), polynomial(lanes, table.ATAN, z, lanes.mul(z, z)))
    # 3.
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
    """Angle of (x, y), with the signs of zeros and the infinities of C.

    1. The smaller of |x| and |y| over the larger, scaled so that no part overflows or vanishes: an angle up to pi/4.
    2. The octant says what it is measured from: 0, pi/2 or pi, each in two parts, and in which direction.
    3. The sum with its rounding error, and the sign of y, that of a zero included.
    """
    # 1.
    height, width = lanes.fabs(y), lanes.fabs(x)
    steep = lanes.compare("ogt", height, width)
    over = lanes.select(steep, width, height)
    under = lanes.select(steep, height, width)
    over, under = _safe_quotient(lanes, over, under)
    main, rest = _atan_of_quotient(lanes, over, under)
    # 2. The sign bit of x, not x < 0: minus zero lies to the left as well.
    leftward = lanes.compare_integers("slt", lanes.bits(x), lanes.whole(0))

    def by_octant(quarter: float, half: float) -> str:
        return lanes.select(steep, lanes.const(quarter), lanes.select(leftward, lanes.const(half), lanes.const(0.0)))

    base, low = by_octant(math.pi / 2, math.pi), by_octant(HALF_PI_LOW, 2 * HALF_PI_LOW)
    minus = lanes.mask_op("xor", steep, leftward)
    main = lanes.select(minus, lanes.neg(main), main)
    rest = lanes.select(minus, lanes.neg(rest), rest)
    # 3.
    total = lanes.add(base, main)
    lost = lanes.sub(main, lanes.sub(total, base))
    angle = lanes.add(total, lanes.add(lanes.add(lost, low), rest))
    sign = lanes.integer_op("and", lanes.bits(y), lanes.whole(SIGN))
    return lanes.from_bits(lanes.integer_op("xor", lanes.bits(angle), sign))


def _safe_quotient(lanes: Lanes, over: str, under: str) -> tuple[str, str]:
    """over/under, 0 <= over <= under, rescaled: 0/0 is 0/1, inf/inf is 1/1, sums of huge numbers do not overflow."""
    # Powers of two scale both without rounding; the quotient stays what it was.
    huge = lanes.compare("ogt", under, lanes.const(2.0**1000))
    tiny = lanes.compare("olt", under, lanes.const(2.0**-900))
    scale = lanes.select(tiny, lanes.const(2.0**100), lanes.const(1.0))
    scale = lanes.select(huge, lanes.const(2.0**-100), scale)
    none = lanes.compare("oeq", under, lanes.const(0.0))
    endless = lanes.mask_op("and", *(lanes.compare("oeq", x, lanes.const(math.inf)) for x in (over, under)))
    over = lanes.select(endless, lanes.const(1.0), lanes.mul(over, scale))
    under = lanes.select(endless, lanes.const(1.0), lanes.mul(under, scale))
    return over, lanes.select(none, lanes.const(1.0), under)


def asin(lanes: Lanes, x: str) -> str:
    """Arc sine; NaN beyond 1.

    1. Up to 1/2: asin x = x + x^3 P(x^2).
    2. Beyond: asin x = pi/2 - 2 asin(sqrt((1 - x)/2)), so that the same polynomial serves and nothing cancels near 1.
       The root is rounded; what it lacks (`_root_error`) counts twice, like the root.
    3. pi/2 less twice the root, with the rounding error of that difference.
    """
    # 1.
    size = lanes.fabs(x)
    small, z, root = _arc_reduced(lanes, size)
    t = lanes.select(small, size, root)
    tail = lanes.mul(lanes.mul(t, z), polynomial(lanes, table.ASIN, z, lanes.mul(z, z)))
    near = lanes.add(t, tail)
    # 2.
    lost = lanes.sub(
        lanes.const(HALF_PI_LOW), lanes.mul(lanes.const(2.0), lanes.add(tail, _root_error(lanes, root, z)))
    )
    # 3.
    quarter, twice = lanes.const(math.pi / 2), lanes.mul(lanes.const(2.0), t)
    total = lanes.sub(quarter, twice)
    carried = lanes.sub(lanes.sub(quarter, total), twice)
    far = lanes.add(total, lanes.add(carried, lost))
    return lanes.copysign(lanes.select(small, near, far), x)


def acos(lanes: Lanes, x: str) -> str:
    """Arc cosine; NaN beyond 1.

    1. |x| <= 1/2: acos x = pi/2 - x - x^3 P(x^2).
    2. x > 1/2: acos x = 2 asin(sqrt((1 - x)/2)), which is exact down to the last place near 1.
    3. x < -1/2: acos x = pi - 2 asin(sqrt((1 + x)/2)).
    """
    # 1.
    size = lanes.fabs(x)
    small, z, root = _arc_reduced(lanes, size)
    t = lanes.select(small, x, root)
    tail = lanes.mul(lanes.mul(t, z), polynomial(lanes, table.ASIN, z, lanes.mul(z, z)))
    quarter = lanes.const(math.pi / 2)
    total = lanes.sub(quarter, t)
    carried = lanes.sub(lanes.sub(quarter, total), t)
    near = lanes.add(total, lanes.add(carried, lanes.sub(lanes.const(HALF_PI_LOW), tail)))
    # 2.
    tail = lanes.add(tail, _root_error(lanes, root, z))
    right = lanes.mul(lanes.const(2.0), lanes.add(root, tail))
    # 3.
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
    # At a root of 0 nothing is missing; 1 keeps the quotient from being 0/0.
    floor = lanes.select(lanes.compare("ogt", root, lanes.const(0.0)), root, lanes.const(1.0))
    return lanes.div(missing, lanes.add(floor, floor))
