"""Evaluation of polynomials on all lanes."""

from __future__ import annotations

from collections.abc import Sequence

from mafsil.kernels.emitter import Lanes


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
