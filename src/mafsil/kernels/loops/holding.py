"""Values laid out in memory, for loops that are asked about them again and again."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from mafsil.kernels.loops import dispatch, loop
from mafsil.kernels.loops.definition import MISS
from mafsil.kernels.loops.held import Held, class_of
from mafsil.kernels.loops.kinds import BOOL, COMPLEX, REAL, Array, Kind, Tuple, held_of, kind_of, refused
from mafsil.kernels.loops.kinds import Held as HeldKind

T = TypeVar("T")
Layout = Callable[[Any, int], object]
"""What writes a value to an address, or returns MISS if it is of another kind."""
_LAYOUTS: dict[type[Any], list[tuple[int, Layout, type[Held[Any]]]]] = {}


def hold(value: T) -> Held[T]:
    """Lay a named tuple of arrays and numbers out; it lives as long as what is returned.

    Args:
        value: the tuple.
    """
    known = _LAYOUTS.setdefault(type(value), [])
    for size, layout, made in known:
        memory = np.empty(size, np.uint8)
        place = memory.ctypes.data
        if layout(value, place) is not MISS:
            return made.laid(place, value, memory)
    kind = kind_of(value)
    known.append((kind.size, _layout_for(kind), class_of(held_of(kind))))
    return hold(value)


def _layout_for(kind: Kind) -> Layout:
    return _in_python(kind) if loop.is_plain() else dispatch.layout_for(kind)


def _in_python(kind: Kind) -> Layout:
    """As `dispatch.layout_for`, for loops that run as Python."""

    def write(value: Any, place: int) -> object:
        if kind_of(value) is not kind:
            return MISS
        slots = np.ctypeslib.as_array((ctypes.c_int64 * (kind.size // 8)).from_address(place))
        return _write(kind, value, slots, 0)

    return write


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
