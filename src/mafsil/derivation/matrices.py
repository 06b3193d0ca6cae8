"""Vectors, matrices and poses whose entries are polynomials."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from mafsil.arrays import Floats
from mafsil.derivation.polynomial import Angle, Polynomial, Values, constant, simplify, trig
from mafsil.derivation.tolerances import ROUNDOFF

Row: TypeAlias = tuple[Polynomial, ...]
Entries: TypeAlias = tuple[Row, ...]
"""Rows of a matrix; a vector is one row."""

ZERO, ONE = constant(0.0), constant(1.0)


@dataclass(frozen=True, slots=True, eq=False)
class SymbolicPose:
    """Rotation (3, 3) and origin (3,) of a frame in another one."""

    R: Entries
    p: Row

    @property
    def entries(self) -> Entries:
        """(4, 4) homogeneous matrix."""
        return (*((*row, x) for row, x in zip(self.R, self.p, strict=True)), (ZERO, ZERO, ZERO, ONE))

    @property
    def z(self) -> Row:
        """(3,) third column of the rotation."""
        return tuple(row[2] for row in self.R)


def rotation_x(angle: Angle, quarters: int = 0) -> Entries:
    """Rot(x, angle + quarters * 90 degrees)."""
    c, s = trig(False, angle, quarters), trig(True, angle, quarters)
    return ((ONE, ZERO, ZERO), (ZERO, c, -s), (ZERO, s, c))


def rotation_z(angle: Angle, quarters: int = 0) -> Entries:
    """Rot(z, angle + quarters * 90 degrees)."""
    c, s = trig(False, angle, quarters), trig(True, angle, quarters)
    return ((c, -s, ZERO), (s, c, ZERO), (ZERO, ZERO, ONE))


def numbers(values: Floats) -> Entries:
    """A matrix of numbers, roundoff of zeros and ones removed."""
    rounded = np.where(np.abs(values - np.round(values)) < ROUNDOFF, np.round(values), values)
    return tuple(tuple(constant(float(x)) for x in row) for row in rounded)


def product(A: Entries, B: Entries) -> Entries:
    """A B, every entry simplified."""
    columns = tuple(zip(*B, strict=True))
    return tuple(tuple(dot(row, column) for column in columns) for row in A)


def transform(A: Entries, x: Row) -> Row:
    """A x."""
    return tuple(dot(row, x) for row in A)


def transpose(A: Entries) -> Entries:
    """Rows as columns."""
    return tuple(zip(*A, strict=True))


def dot(x: Row, y: Row) -> Polynomial:
    """Inner product, simplified."""
    total = ZERO
    for one, two in zip(x, y, strict=True):
        total = total + one * two
    return simplify(total)


def cross(x: Row, y: Row) -> Row:
    """Vector product, simplified."""
    return tuple(simplify(x[i] * y[j] - x[j] * y[i]) for i, j in ((1, 2), (2, 0), (0, 1)))


def plus(x: Row, y: Row) -> Row:
    """X + y, simplified."""
    return tuple(simplify(one + two) for one, two in zip(x, y, strict=True))


def minus(x: Row, y: Row) -> Row:
    """X - y, simplified."""
    return tuple(simplify(one - two) for one, two in zip(x, y, strict=True))


def scale_row(number: Polynomial, x: Row) -> Row:
    """A multiple of x, simplified."""
    return tuple(simplify(number * one) for one in x)


def evaluate(A: Entries, values: Values, count: int) -> Floats:
    """(count, rows, columns) numbers of a matrix at `count` states."""
    flat: list[Any] = [np.broadcast_to(x.evaluate(values), (count,)) for row in A for x in row]
    return np.stack(flat, axis=-1).reshape(count, len(A), len(A[0]))
