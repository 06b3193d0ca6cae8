"""What all values have in common: one frozen array, batch dimensions first, and frame letters.

Adjacent letters cancel, T_ab T_bc = T_ac, and what does not cancel is refused. Values that form a linear space within
their frame (`Linear`): free vectors, twists, wrenches.
"""

from __future__ import annotations

from abc import ABCMeta, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any, ClassVar, NoReturn, Self, TypeAlias, cast

import numpy as np

from mafsil.arrays import Floats, Truth, frozen, real_array, require_finite
from mafsil.errors import InputError, OperandError, UnknownNameError
from mafsil.geometry.tolerances import ROUNDOFF

Frames: TypeAlias = tuple[str, str]
"""(a, b) of R_ab or T_ab."""


def operands(sign: str, left: object, right: object) -> OperandError:
    """The error that says what an operator means for the left or the right operand.

    Args:
        sign: of the operator.
        left, right: what it stood between.
    """
    meant = left if isinstance(left, Value) else right
    known = {"left": type(left).__name__, "right": type(right).__name__, "sign": sign}
    return OperandError(f"geometry.operands_{type(meant).__name__.lower()}", **known)


def factor_of(sign: str, value: Value, factor: object) -> Floats:
    """A factor, or one for each row of a batch, ready to be multiplied with the value's array.

    Args:
        sign: of the operator, for the error.
        value: what is multiplied.
        factor: a number, or an array of one per row.

    Raises:
        OperandError: it is no number.
    """
    if isinstance(factor, Value | str | bytes) or factor is None:
        raise operands(sign, factor, value)
    numbers = real_array("factor", factor)  # pyright: ignore[reportArgumentType]
    return numbers.reshape((*numbers.shape, *(1,) * value.core)) if numbers.ndim else numbers


class ValueType(ABCMeta):
    """The type of value types: a name that one does not have is said as one of an object is."""

    if not TYPE_CHECKING:  # type checkers find misspelt names themselves

        def __getattr__(cls, name: str) -> NoReturn:
            raise _unknown(cls, name)


def _unknown(kind: type, name: str) -> AttributeError:
    """NumPy and others look for private names, which need no advice."""
    return AttributeError(name) if name.startswith("_") else UnknownNameError(kind.__name__, name, dir(kind))


@dataclass(frozen=True, eq=False, repr=False)
class Value(metaclass=ValueType):
    """A frozen array (*batch, *core), checked when made.

    Attributes:
        array: the numbers; read-only.
    """

    array: Floats

    __array_ufunc__ = None
    """NumPy's arrays and numbers leave operators to the value, which knows its type and frame."""
    core: ClassVar[int]
    """Number of core dimensions."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "array", frozen(require_finite(type(self).__name__, self.check_array(self.array))))

    @staticmethod
    @abstractmethod
    def check_array(array: Any) -> Floats:
        """The numbers, if they are what the type promises; otherwise InputError."""

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> NoReturn:
            raise _unknown(type(self), name)

    def __reduce__(self) -> tuple[type[Self], tuple[Any, ...]]:
        return type(self), tuple(getattr(self, f.name) for f in fields(self))

    @property
    def batch(self) -> tuple[int, ...]:
        """Leading shape; () is one value."""
        return self.array.shape[: self.array.ndim - self.core]

    def __bool__(self) -> bool:
        if not self.batch:
            raise OperandError("geometry.no_truth", kind=type(self).__name__)
        return bool(self.batch[0])

    def __len__(self) -> int:
        if not self.batch:
            raise OperandError("geometry.no_length", kind=type(self).__name__)
        return self.batch[0]

    def __getitem__(self, index: Any) -> Self:
        places: tuple[Any, ...] = cast("tuple[Any, ...]", index) if isinstance(index, tuple) else (index,)
        return replace(self, array=self.array[(*places, ...) if Ellipsis not in places else places])

    def __iter__(self) -> Iterator[Self]:
        return (self[k] for k in range(len(self)))

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Any:
        return np.array(self.array, dtype=dtype, copy=copy)

    def __matmul__(self, other: Any) -> Any:
        raise operands("@", self, other)

    def __rmatmul__(self, other: Any) -> Any:
        raise operands("@", other, self)

    def __add__(self, other: Any) -> Any:
        raise operands("+", self, other)

    def __radd__(self, other: Any) -> Any:
        raise operands("+", other, self)

    def __sub__(self, other: Any) -> Any:
        raise operands("-", self, other)

    def __rsub__(self, other: Any) -> Any:
        raise operands("-", other, self)

    def __mul__(self, other: Any) -> Any:
        raise operands("*", self, other)

    def __rmul__(self, other: Any) -> Any:
        raise operands("*", other, self)

    def close_to(self, other: Self, tolerance: float = ROUNDOFF) -> Truth:
        """(*batch) whether all numbers agree within the tolerance."""
        difference = np.abs(self.array - other.array)
        return difference.max(axis=tuple(range(-self.core, 0))) <= tolerance

    def __repr__(self) -> str:
        labels = [f"{f.name}={getattr(self, f.name)!r}" for f in fields(self) if f.name != "array"]
        known = [label for label in labels if not label.endswith("=None")]
        return f"{type(self).__name__}({', '.join([repr(self.array.tolist()), *known])})"


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
        return replace(self, array=self.array + right.array, frame=common_frame("+", self.frame, right.frame))

    def __sub__(self, other: Self) -> Self:
        right = self.match_units("-", other)
        return replace(self, array=self.array - right.array, frame=common_frame("-", self.frame, right.frame))

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


def join_frames(name: str, left: Frames | None, right: Frames | None) -> Frames | None:
    """(a, c) of (a, b) and (b, c); None where one side carries no letters.

    Args:
        name: the operation, for the error.
        left: (a, b).
        right: (b, c).

    Raises:
        InputError: the inner letters differ.
    """
    if left is None or right is None:
        return None
    require_same(name, left[1], right[0])
    return left[0], right[1]


def carry_frame(name: str, frames: Frames | None, frame: str | None) -> str | None:
    """{a} of something seen from {b}, carried by (a, b); None where one side carries no letters.

    Args:
        name: the operation, for the error.
        frames: (a, b).
        frame: b.

    Raises:
        InputError: the inner letters differ.
    """
    if frames is None or frame is None:
        return None
    require_same(name, frames[1], frame)
    return frames[0]


def reversed_frames(frames: Frames | None) -> Frames | None:
    """(b, a) of (a, b)."""
    return None if frames is None else (frames[1], frames[0])


def common_frame(name: str, left: str | None, right: str | None) -> str | None:
    """The common letter of two values, or the one that is known.

    Args:
        name: the operation, for the error.
        left: letter of one value.
        right: letter of the other.

    Raises:
        InputError: they differ.
    """
    if left is not None and right is not None:
        require_same(name, left, right)
    return left if left is not None else right


def require_same(name: str, left: str, right: str) -> None:
    """Refuse letters `left` and `right` that differ; `name` is the operation."""
    if left != right:
        raise InputError("geometry.frames", name=name, inner_left=left, inner_right=right)
