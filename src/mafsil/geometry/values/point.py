"""Points and free vectors with their frame and length unit: a change of frame moves points, but only turns vectors."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar, cast, overload

import numpy as np

from mafsil.arrays import Floats, Scalar, as_batch
from mafsil.errors import InputError
from mafsil.geometry.values import labels
from mafsil.geometry.values.value import Linear, Value, operands

METRES: dict[str, float] = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "km": 1e3, "in": 0.0254, "ft": 0.3048}
"""Length units in metres."""


@dataclass(frozen=True, eq=False, repr=False)
class Vector(Linear):
    """A free vector: a length and a direction, the same wherever it is drawn.

    Attributes:
        array: (*batch, 3) components in the axes of the frame, in the unit.
        frame: letter of the frame, or None.
        unit: length unit.
    """

    unit: str = "m"
    core: ClassVar[int] = 1

    @staticmethod
    def check_array(array: Any) -> Floats:
        """Three numbers each."""
        return as_batch("vector", array, (3,))

    def in_unit(self, unit: str) -> Vector:
        """The same vector with components in another length unit."""
        return replace(self, array=self.array * _factor(self.unit, unit), unit=unit)

    def length(self) -> Scalar:
        """(*batch) length, in the unit."""
        return np.linalg.norm(self.array, axis=-1)

    def dot(self, other: Vector) -> Scalar:
        """(*batch) inner product, in the unit of this vector squared."""
        right = self.match_units("dot", other)
        labels.same("dot", self.frame, right.frame)
        return np.sum(self.array * right.array, axis=-1)

    def match_units(self, sign: str, other: Any) -> Vector:
        """The other vector in the unit of this one."""
        if isinstance(other, Vector):
            return other.in_unit(self.unit)
        raise operands(sign, self, other)

    @overload
    def __add__(self, other: Vector) -> Vector: ...
    @overload
    def __add__(self, other: Point) -> Point: ...
    def __add__(  # pyright: ignore[reportIncompatibleMethodOverride]
        self, other: Vector | Point
    ) -> Vector | Point:
        """Vectors add; a vector carries a point to a point."""
        return other + self if isinstance(other, Point) else super().__add__(cast(Any, other))


@dataclass(frozen=True, eq=False, repr=False)
class Point(Value):
    """A point: the vector to it from the origin of its frame.

    Attributes:
        array: (*batch, 3) coordinates in the unit.
        frame: letter of the frame, or None.
        unit: length unit.
    """

    frame: str | None = None
    unit: str = "m"
    core: ClassVar[int] = 1

    @staticmethod
    def check_array(array: Any) -> Floats:
        """Three numbers each."""
        return as_batch("point", array, (3,))

    def in_unit(self, unit: str) -> Point:
        """The same point with coordinates in another length unit."""
        return replace(self, array=self.array * _factor(self.unit, unit), unit=unit)

    def distance(self, other: Point) -> Scalar:
        """(*batch) distance, in the unit of this point."""
        if not isinstance(cast(object, other), Point):
            raise operands("distance", self, other)
        return (self - other).length()

    def __add__(self, step: Vector) -> Point:
        """The point carried by a free vector; points themselves have no sum."""
        if not isinstance(cast(object, step), Vector):
            raise operands("+", self, step)
        frame = labels.same("+", self.frame, step.frame)
        return Point(self.array + step.in_unit(self.unit).array, frame, self.unit)

    @overload
    def __sub__(self, other: Point) -> Vector: ...
    @overload
    def __sub__(self, other: Vector) -> Point: ...
    def __sub__(self, other: Point | Vector) -> Vector | Point:
        """The vector from another point to this one, or the point carried back by a vector."""
        if not isinstance(cast(object, other), Point | Vector):
            raise operands("-", self, other)
        frame = labels.same("-", self.frame, other.frame)
        kind = Vector if isinstance(other, Point) else Point
        return kind(self.array - other.in_unit(self.unit).array, frame, self.unit)


def _factor(unit: str, target: str) -> float:
    for name in (unit, target):
        if name not in METRES:
            raise InputError("input.choice", name="unit", value=name, known=", ".join(METRES))
    return METRES[unit] / METRES[target]
