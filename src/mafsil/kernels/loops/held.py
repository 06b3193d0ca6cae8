"""What loops are asked about again and again, laid out in memory once.

A tuple that is an argument is taken apart in each call; an arm in a scene has fifty arrays. A `Held` value is taken
apart when it is made and lies in memory as the loops read it; a call hands over where.
"""

from __future__ import annotations

import ctypes
import hashlib
from collections.abc import Callable
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from mafsil.kernels.loops.kinds import BOOL, COMPLEX, REAL, Array, Kind, Tuple, held_of, kind_of, refused
from mafsil.kernels.loops.kinds import Held as HeldKind

T = TypeVar("T")


class Held(tuple[Any, ...], Generic[T]):
    """A named tuple of arrays and numbers; compiled loops read it by `opened`.

    The first item of the tuple is where it lies, for the compiled code; then the value and its memory.
    """

    __slots__ = ()
    held_kind: HeldKind
    """Of the class of its values' kind."""

    def __new__(cls, value: T) -> Held[T]:
        """Lay a value out."""
        for kind, layout, made in _LAYOUTS.get(type(value), ()):
            memory = np.empty(kind.size, np.uint8)
            place = memory.ctypes.data
            if layout(value, place) is None:
                return tuple.__new__(made, (place, value, memory))
        _LAYOUTS.setdefault(type(value), []).append(_layout_for(kind_of(value)))
        return Held(value)

    @property
    def address(self) -> int:
        """Where it lies."""
        return self[0]

    @property
    def value(self) -> T:
        """As given; it lives as long as this does."""
        return self[1]


Layout = Callable[[Any, int], object]
"""What writes a value to an address; None if it was of the kind."""
_LAYOUTS: dict[type[Any], list[tuple[Kind, Layout, type[Held[Any]]]]] = {}
_CLASSES: dict[Kind, type[Held[Any]]] = {}
makers: list[Callable[[Kind], Layout]] = []
"""What makes layouts in machine code, once it is there."""


def _layout_for(kind: Kind) -> tuple[Kind, Layout, type[Held[Any]]]:
    layout = makers[0](kind) if makers else lambda value, place: _write(kind, value, _slots(kind, place), 0) and None
    return kind, layout, class_of(held_of(kind))


def _slots(kind: Kind, place: int) -> NDArray[np.int64]:
    return np.ctypeslib.as_array((ctypes.c_int64 * (kind.size // 8)).from_address(place))


def class_of(kind: HeldKind) -> type[Held[Any]]:
    """The class of held values of a kind."""
    if kind.value not in _CLASSES:
        name = f"Held_{hashlib.blake2b(kind.name.encode(), digest_size=6).hexdigest()}"
        _CLASSES[kind.value] = type(name, (Held,), {"__slots__": (), "held_kind": kind})
    return _CLASSES[kind.value]


def _write(kind: Kind, value: Any, memory: NDArray[np.int64], slot: int) -> int:
    """Write a value from a slot on; the slot behind it."""
    if isinstance(kind, Tuple):
        for item, part in zip(kind.items, value, strict=True):
            slot = _write(item, part, memory, slot)
        return slot
    if isinstance(kind, Array):
        strides = () if kind.contiguous else value.strides
        numbers = (value.ctypes.data, *value.shape, *strides)
        memory[slot : slot + len(numbers)] = numbers
        return slot + len(numbers)
    if isinstance(kind, HeldKind):
        memory[slot] = value.address
        return slot + 1
    if kind is COMPLEX:
        memory[slot : slot + 2].view(np.float64)[:] = value.real, value.imag
        return slot + 2
    if len(kind.parts) > 1 or (kind.parts and kind.parts[0].startswith("<")):
        raise refused(f"{kind} as part of a held value")
    if kind.parts:
        if kind is REAL:
            memory[slot : slot + 1].view(np.float64)[0] = value
        else:
            memory[slot] = int(value) if kind is BOOL else value
        slot += 1
    return slot


def opened(held: Held[T]) -> T:
    """The value of a `Held`, in a compiled loop that somebody else keeps it alive for."""
    return held.value
