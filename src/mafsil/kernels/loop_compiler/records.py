"""Records of compiled loops: named fields of eight bytes each, in place of many arguments and of numbered columns.

    class Lane(Record):
        pose: int
        error: float
        best: Floats

A loop that is annotated `lane: Lane` reads and writes `lane.pose`; one annotated `lanes: Rows[Lane]` takes `lanes[i]`.
The annotations are the layout: whole numbers, real numbers, and addresses of arrays, of records and of rows of records.

In Python a record is a view of its memory, and keeps what its addresses lead to; its fields are read and written the
same way, so that the loops run as ordinary Python too.
"""

from __future__ import annotations

from ctypes import addressof, c_char
from typing import Any, ClassVar, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray


class Record:
    """Fields in the order of the annotations of the subclass.

    Attributes:
        memory: (fields,) int64, eight bytes for each.
        address: of the memory; what a compiled function takes.
    """

    layout: ClassVar[dict[str, str]] = {}
    """Name -> annotation of every field."""
    _dtype: ClassVar[np.dtype[np.void]]

    def __init__(self, memory: NDArray[np.int64] | None = None, **given: object) -> None:
        """A view of some memory, or of its own.

        Args:
            memory: (fields,) of a row, or None for new memory.
            given: fields and their values.
        """
        self.memory = np.zeros(len(self.layout), np.int64) if memory is None else memory
        self.address = _address(self.memory)
        self._kept: dict[str, Any] = {}
        for name, value in given.items():
            setattr(self, name, value)

    def __init_subclass__(cls) -> None:
        cls.layout = {name: str(kind) for name, kind in cls.__annotations__.items()}
        for place, (name, kind) in enumerate(cls.layout.items()):
            setattr(cls, name, _FIELDS.get(kind, _Address)(name, place))
        cls._dtype = np.dtype(
            [(name, np.float64 if kind == "float" else np.int64) for name, kind in cls.layout.items()]
        )

    def release(self, *names: str) -> None:
        """Forget arrays whose addresses were used; others are given before the next use."""
        for name in names:
            self._kept.pop(name, None)

    @classmethod
    def dtype(cls) -> np.dtype[np.void]:
        """Type of a NumPy array of such records; addresses are whole numbers there."""
        return cls._dtype


R = TypeVar("R", bound=Record)


class Rows(Generic[R]):
    """Records of one type, one after another.

    Args:
        kind: their type.
        array: (k,) NumPy array of `kind.dtype()`.
    """

    def __init__(self, kind: type[R], array: NDArray[np.void]) -> None:
        self._kind = kind
        self.memory = array.view(np.int64).reshape(len(array), len(kind.layout))

    def __getitem__(self, row: int) -> R:
        return self._kind(self.memory[row])


def _address(array: NDArray[Any]) -> int:
    """Where an array begins: five times as fast as `array.ctypes`, where the array is contiguous and may be written."""
    try:
        return addressof(c_char.from_buffer(array.data))
    except (TypeError, ValueError, BufferError):  # Read-only, strided or empty.
        return array.ctypes.data


class _Whole:
    """A field that is a whole number."""

    def __init__(self, name: str, place: int) -> None:
        self.name, self.place = name, place

    def __get__(self, record: Record, _owner: type | None = None) -> Any:
        return int(record.memory[self.place])

    def __set__(self, record: Record, value: Any) -> None:
        record.memory[self.place] = value


class _Real(_Whole):
    """A field that is a real number."""

    def __get__(self, record: Record, _owner: type | None = None) -> Any:
        return float(record.memory.view(np.float64)[self.place])

    def __set__(self, record: Record, value: Any) -> None:
        record.memory.view(np.float64)[self.place] = value


class _Address(_Whole):
    """A field that leads to an array, a record or rows, which the record keeps."""

    def __get__(self, record: Record, _owner: type | None = None) -> Any:
        return record._kept[self.name]  # pyright: ignore[reportPrivateUsage]

    def __set__(self, record: Record, value: Any) -> None:
        array = value
        if not isinstance(value, np.ndarray):
            array = value.memory
        record._kept[self.name] = value  # pyright: ignore[reportPrivateUsage]
        record.memory[self.place] = _address(array)


_FIELDS: dict[str, type[_Whole]] = {"int": _Whole, "float": _Real}
