"""Elementary functions on all lanes at once, in IR arithmetic alone; ULP says how far each may be from the truth.

All are branch-free (but for the reduction of huge angles) and pass NaN on. A row's result does not depend on the lanes
beside it. On targets without fused multiply-add the same bounds hold.

References: Muller et al., Handbook of Floating-Point Arithmetic, 2018; Muller, Elementary Functions, 2016.
"""

from __future__ import annotations

from collections.abc import Sequence

from mafsil.kernels import coefficients as table
from mafsil.kernels.argument import reduced
from mafsil.kernels.emitter import Lanes

ULP = {"sin": 1.0, "cos": 1.0, "tan": 2.0}
"""Largest distance from the exact value, in units of its last place; proven by samples against mpmath in the tests."""


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
        sine = _signed(lanes, lanes.select(odd, large, small), turns)
    if "cos" in wanted:
        after = lanes.integer_op("add", turns, lanes.whole(1))
        cosine = _signed(lanes, lanes.select(odd, small, large), after)
    return sine, cosine


def _signed(lanes: Lanes, x: str, turns: str) -> str:
    """-x if bit 1 of `turns` is set."""
    sign = lanes.integer_op("and", lanes.integer_op("shl", turns, lanes.whole(62)), lanes.whole(1 << 63))
    return lanes.from_bits(lanes.integer_op("xor", lanes.bits(x), sign))
