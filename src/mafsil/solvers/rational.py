"""Exact judgement by rational arithmetic: cones of finitely many columns, without any rounding.

Integers throughout: a column or a row may be multiplied by a positive number without changing the question, and the
simplex method is run fraction-free (Edmonds), with Bland's rule, so that it always ends.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from fractions import Fraction
from math import gcd, lcm
from typing import TypeAlias

Rational: TypeAlias = int | float | Fraction
Columns: TypeAlias = Sequence[Sequence[Rational]]


class Location(Enum):
    """Where the origin lies relative to the convex hull of the columns."""

    INSIDE = "inside"
    BOUNDARY = "boundary"
    OUTSIDE = "outside"


@dataclass(frozen=True)
class OriginLocation:
    """Where the origin lies, exactly, and the proof.

    Attributes:
        place: of the origin; INSIDE means strictly.
        rank: of the columns.
        combination: x > 0 (every entry) with sum x_j a_j = 0 if INSIDE; x >= 0 (not zero) if BOUNDARY; else None.
        certificate: y != 0 with y . a_j >= 0 for all j unless INSIDE (all > 0 if OUTSIDE); else None.
    """

    place: Location
    rank: int
    combination: tuple[Fraction, ...] | None
    certificate: tuple[Fraction, ...] | None


def exact(value: Rational) -> Fraction:
    """A number as the fraction it prints as: 0.1 is 1/10, not the nearest binary number."""
    return Fraction(repr(float(value))) if isinstance(value, float) else Fraction(value)


def locate_origin(columns: Columns) -> OriginLocation:
    """Is the origin strictly inside the convex hull of the columns?

    Args:
        columns: n columns of m numbers; floats are read as the decimals they print as.
    """
    whole, scales = _integers(columns)
    m, n = len(whole[0]), len(whole)
    rank, normal = _rank_and_normal(whole)
    total = [-sum(column[i] for column in whole) for i in range(m)]
    x, y = nonnegative_solution(whole, total)
    if x is not None and rank == m:
        return OriginLocation(Location.INSIDE, rank, tuple((1 + v) * s for v, s in zip(x, scales, strict=True)), None)
    weights, strict = nonnegative_solution([[*column, 1] for column in whole], [0] * m + [1])
    if weights is None:
        assert strict is not None
        return OriginLocation(Location.OUTSIDE, rank, None, strict[:m])
    combination = tuple(v * s for v, s in zip(weights, scales, strict=True))
    certificate = y if y is not None else tuple(Fraction(v) for v in normal)
    assert len(combination) == n
    return OriginLocation(Location.BOUNDARY, rank, combination, certificate)


def nonnegative_solution(
    columns: Sequence[Sequence[int]], b: Sequence[int]
) -> tuple[tuple[Fraction, ...] | None, tuple[Fraction, ...] | None]:
    """Find x >= 0 with sum x_j a_j = b, or y with y . a_j >= 0 for all j and y . b < 0. One of the two is None.

    Args:
        columns: n columns of m integers.
        b: m integers.
    """
    m, n = len(b), len(columns)
    signs = [1 if value >= 0 else -1 for value in b]
    rows = [
        [signs[i] * columns[j][i] for j in range(n)] + [int(i == k) for k in range(m)] + [signs[i] * b[i]]
        for i in range(m)
    ]
    gain = [sum(row[j] for row in rows) for j in range(n)] + [0] * m + [sum(row[-1] for row in rows)]
    basis, scale = list(range(n, n + m)), 1
    while (enter := next((j for j in range(n) if gain[j] > 0), None)) is not None:
        leave = _leaving_row(rows, basis, enter)
        scale = _pivot(rows, gain, leave, enter, scale)
        basis[leave] = enter
    if gain[-1] > 0:
        return None, tuple(Fraction(-signs[i] * (gain[n + i] + scale), scale) for i in range(m))
    x = [Fraction(0)] * n
    for row, j in zip(rows, basis, strict=True):
        if j < n:
            x[j] = Fraction(row[-1], scale)
    return tuple(x), None


def _leaving_row(rows: list[list[int]], basis: list[int], enter: int) -> int:
    """Smallest ratio; among equals the variable of the smallest number (Bland). Phase one is bounded: one exists."""
    best = -1
    for i, row in enumerate(rows):
        if row[enter] > 0:
            if best < 0:
                best = i
                continue
            here, there = row[-1] * rows[best][enter], rows[best][-1] * row[enter]
            if here < there or (here == there and basis[i] < basis[best]):
                best = i
    return best


def _pivot(rows: list[list[int]], gain: list[int], leave: int, enter: int, scale: int) -> int:
    """One fraction-free step; all rows then share the new positive denominator, which is returned."""
    pivot_row, pivot = rows[leave], rows[leave][enter]
    for row in (*rows, gain):
        if row is not pivot_row:
            factor = row[enter]
            for j, value in enumerate(pivot_row):
                row[j] = (pivot * row[j] - factor * value) // scale
    return pivot


def _integers(columns: Columns) -> tuple[list[list[int]], list[Fraction]]:
    """Columns multiplied to integers without a common factor, and the (positive) factors."""
    whole: list[list[int]] = []
    scales: list[Fraction] = []
    for column in columns:
        fractions = [exact(value) for value in column]
        shared = lcm(*(value.denominator for value in fractions))
        integers = [int(value * shared) for value in fractions]
        common = gcd(*integers) or 1
        whole.append([value // common for value in integers])
        scales.append(Fraction(shared, common))
    return whole, scales


def _rank_and_normal(columns: list[list[int]]) -> tuple[int, list[int]]:
    """Rank, and (if it is below m) an integer vector normal to all columns.

    Columns are eliminated one against the other; what is left are rows of an echelon form.
    """
    m = len(columns[0])
    echelon: list[tuple[int, list[Fraction]]] = []
    for column in columns:
        rest = [Fraction(value) for value in column]
        for place, row in echelon:
            factor = rest[place]
            rest = [a - factor * b for a, b in zip(rest, row, strict=True)]
        place = next((i for i, value in enumerate(rest) if value), None)
        if place is not None:
            row = [value / rest[place] for value in rest]
            echelon = [(p, [a - other[place] * b for a, b in zip(other, row, strict=True)]) for p, other in echelon] + [
                (place, row)
            ]
        if len(echelon) == m:
            return m, []
    pivots = {place for place, _ in echelon}
    free = next(i for i in range(m) if i not in pivots)
    normal = [Fraction(0)] * m
    normal[free] = Fraction(1)
    for place, row in echelon:
        normal[place] = -row[free]
    shared = lcm(*(value.denominator for value in normal))
    return len(echelon), [int(value * shared) for value in normal]
