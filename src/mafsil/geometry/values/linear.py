"""Values that form a linear space within their frame: free vectors, twists, wrenches."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Self

from mafsil.geometry.values import labels
from mafsil.geometry.values.value import Value, factor_of, operands


@dataclass(frozen=True, eq=False, repr=False)
class Linear(Value):
    """A value that adds to its own kind in its own frame, and scales.

    Attributes:
        array: the numbers; read-only.
        frame: letter of the frame, or None.
    """

    frame: str | None = None

    def match_units(self, sign: str, other: Any) -> Self:
        """The other value, if it is of this kind; in the unit of this one where there are units.

        Raises:
            OperandError: it is something else.
        """
        if type(other) is not type(self):
            raise operands(sign, self, other)
        return other

    def __add__(self, other: Self) -> Self:
        right = self.match_units("+", other)
        return replace(self, array=self.array + right.array, frame=labels.same("+", self.frame, right.frame))

    def __sub__(self, other: Self) -> Self:
        right = self.match_units("-", other)
        return replace(self, array=self.array - right.array, frame=labels.same("-", self.frame, right.frame))

    def __neg__(self) -> Self:
        return replace(self, array=-self.array)

    def __pos__(self) -> Self:
        return self

    def __mul__(self, factor: Any) -> Self:
        return replace(self, array=self.array * factor_of("*", self, factor))

    def __rmul__(self, factor: Any) -> Self:
        return self * factor

    def __truediv__(self, divisor: Any) -> Self:
        return replace(self, array=self.array / factor_of("/", self, divisor))
