"""Sums and products together with their rounding errors: numbers of twice the digits.

Evaluation of polynomials on all lanes.
"""

from __future__ import annotations

from collections.abc import Sequence

from mafsil.kernels.emitter import Lanes


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
