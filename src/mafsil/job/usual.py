"""Distances that are news: bodies of an arm that are always near each other are no nearer than usual."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats
from mafsil.collision import Checker, Clearance

NEAR = 0.05
"""Bodies of an arm that often come nearer to each other than this are no news, as far as they do as usual [m]."""


def without_usual(checker: Checker) -> Checker:
    """The same, where bodies of the arm that are often near each other are not looked at."""
    names, usual = [body.name for body in checker.bodies], _usual(checker)
    pairs = [k for k, (a, b) in enumerate(checker.arm.pairs.tolist()) if (names[a], names[b]) not in usual]
    return checker.checking(range(len(names)), pairs)


def _usual(checker: Checker) -> dict[tuple[str, str], float]:
    return checker.nearer_than(max(NEAR, checker.clearance))


def unusual(checker: Checker, others: Checker, q: Floats) -> Clearance:
    """Smallest distances at configurations (k, n), without those of bodies of the arm that are near as usual.

    Args:
        checker: of the arm.
        others: the same `without_usual`.
        q: configurations.
    """
    found, usual = checker.distance(q), _usual(checker)
    rows = [k for k, one in enumerate(found) if one.distance >= usual.get((one.first, one.second), np.inf)]
    if not rows:
        return found
    rest = others.distance(q[rows])
    for row, distance, first, second in zip(rows, rest.distance, rest.first, rest.second, strict=True):
        if np.isfinite(distance):
            found.distance[row], found.first[row], found.second[row] = distance, first, second
    return found
