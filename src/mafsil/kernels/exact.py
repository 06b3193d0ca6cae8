"""Polynomials on all lanes and their coefficients, and sums and products together with their rounding errors.

A number and its error are a number of twice the digits. The coefficients of minimax polynomials stand lowest order
first; tests/kernels/minimax.py says of what, and computes them.
"""

from __future__ import annotations

from collections.abc import Sequence

from mafsil.kernels.emitter import Lanes

SIN = (
    -0.16666666666666632,
    0.008333333333322418,
    -0.00019841269829812353,
    2.755731369357077e-06,
    -2.5050758384833997e-08,
    1.5896811858055323e-10,
)
COS = (
    0.0416666666666666,
    -0.0013888888888874131,
    2.480158728948717e-05,
    -2.7557314353829943e-07,
    2.0875723484200875e-09,
    -1.1359659099381198e-11,
)
TANH = (
    -0.333333333333333,
    0.13333333333326813,
    -0.05396825396386678,
    0.02186948838875194,
    -0.008863232646832342,
    0.003592092470401529,
    -0.001455545571409515,
    0.000588455300130805,
    -0.00023340814982205263,
    8.335332422338535e-05,
    -1.951675216996668e-05,
)
LOG = (
    0.6666666666666735,
    0.39999999999413105,
    0.2857142874277025,
    0.2222219853077321,
    0.18183566685783356,
    0.1531398637895229,
    0.14796628313511473,
)
LOG_LONG = (
    0.3999999999999998,
    0.2857142857144515,
    0.22222222217527085,
    0.18181818871469874,
    0.15384556791923787,
    0.13336320470546761,
    0.11674756385314058,
    0.11989531943910964,
)
ATAN = (
    -0.333333333333332,
    0.19999999999953771,
    -0.14285714280215708,
    0.11111110784424666,
    -0.09090897785288421,
    0.07692060696356073,
    -0.06663109369660289,
    0.05847926615824369,
    -0.05039465621500414,
    0.03806845350441478,
    -0.017911251065489298,
)
ASIN = (
    0.16666666666666763,
    0.07499999999970268,
    0.044642857175115555,
    0.030381942683846183,
    0.022372215654305812,
    0.017351600193473087,
    0.013980960291701826,
    0.011397785062868553,
    0.010786480285072328,
    0.0036832188284561048,
    0.02176308568069405,
    -0.021076729523443725,
    0.032676551081546976,
)
EXP = (
    0.5,
    0.16666666666666685,
    0.04166666666666673,
    0.008333333333316739,
    0.001388888888885843,
    0.00019841269897059077,
    2.4801587373701268e-05,
    2.755723423677988e-06,
    2.7557233416715324e-07,
    2.5112239814569768e-08,
    2.092692273346156e-09,
)


def two_product(lanes: Lanes, x: str, y: str) -> tuple[str, str]:
    """x*y as a rounded product and its error, exact unless a part leaves the range of doubles.

    Reference: Dekker 1971, A floating-point technique for extending the available precision.
    """
    # x*y - product is exactly representable; a fused product finds it in one instruction. Without, both factors are cut
    # into halves of 26 bits, whose four products are exact, and subtracted from the largest to the smallest.
    product = lanes.mul(x, y)
    if lanes.text.fma:
        return product, lanes.fms(x, y, product)
    (x1, x2), (y1, y2) = _halves(lanes, x), _halves(lanes, y)
    error = lanes.sub(lanes.mul(x1, y1), product)
    error = lanes.add(lanes.add(error, lanes.mul(x1, y2)), lanes.mul(x2, y1))
    return product, lanes.add(error, lanes.mul(x2, y2))


def ordered_sum(lanes: Lanes, x: str, y: str) -> tuple[str, str]:
    """x + y as a rounded sum and its error, exact, for |x| >= |y|."""
    total = lanes.add(x, y)
    return total, lanes.sub(y, lanes.sub(total, x))


def two_sum(lanes: Lanes, x: str, y: str) -> tuple[str, str]:
    """x + y as a rounded sum and its error, exact, whichever is larger."""
    total = lanes.add(x, y)
    part = lanes.sub(total, x)
    return total, lanes.add(lanes.sub(x, lanes.sub(total, part)), lanes.sub(y, part))


def _halves(lanes: Lanes, x: str) -> tuple[str, str]:
    """x as two numbers of 26 bits: times 2^27 + 1, so that the difference from that keeps the upper half (Veltkamp)."""
    big = lanes.mul(x, lanes.const(134217729.0))
    upper = lanes.sub(big, lanes.sub(big, x))
    return upper, lanes.sub(x, upper)


def polynomial(lanes: Lanes, coefficients: Sequence[float], z: str, z2: str) -> str:
    """Sum of coefficients[k] z^k by Estrin's scheme on pairs, z2 = z*z."""
    # c0 + c1 z, c2 + c3 z, ... do not need each other and run side by side; then Horner in z^2 over the pairs: half as
    # many steps that wait for one another as Horner in z.
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
