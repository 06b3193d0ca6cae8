"""Values laid out in memory, for loops that are asked about them again and again."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from mafsil.kernels import runtime
from mafsil.kernels.loops import loop
from mafsil.kernels.loops.definition import MISS
from mafsil.kernels.loops.held import Held, class_of
from mafsil.kernels.loops.kinds import held_of, kind_of
from mafsil.lazy_module import lazily

if TYPE_CHECKING:
    import mafsil.kernels.loops.specialisation as dispatch
else:
    dispatch = lazily("mafsil.kernels.loops.specialisation")

T = TypeVar("T")
Layout = Callable[[Any, int], object]
"""What writes a value to an address, or returns MISS if it is of another kind."""
_LAYOUTS: dict[type[Any], list[tuple[int, Layout, type[Held[Any]]]]] = {}


def hold(value: T) -> Held[T]:
    """Lay a named tuple of arrays and numbers out; it lives as long as what is returned.

    Args:
        value: the tuple.
    """
    if loop.is_plain() or not runtime.available():  # Loops that run as Python read the value itself.
        return class_of(held_of(kind_of(value))).from_parts(0, value)
    known = _LAYOUTS.setdefault(type(value), [])
    for size, layout, made in known:
        memory = np.empty(size, np.uint8)
        place = memory.ctypes.data
        if layout(value, place) is not MISS:
            return made.from_parts(place, value, memory)
    kind = kind_of(value)
    known.append((kind.size, dispatch.layout_for(kind), class_of(held_of(kind))))
    return hold(value)
