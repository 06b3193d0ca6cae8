"""What loops are asked about again and again, laid out in memory once.

A tuple that is an argument is taken apart in each call; an arm in a scene has fifty arrays. A `Held` value is taken
apart when it is made and lies in memory as the loops read it; a call hands over where.
"""

from __future__ import annotations

import hashlib
from typing import Any, Generic, TypeVar

from mafsil.kernels.loops.kinds import Held as HeldKind
from mafsil.kernels.loops.kinds import Kind

T = TypeVar("T")


class Held(tuple[Any, ...], Generic[T]):
    """A named tuple of arrays and numbers; compiled loops read it by `open_held`.

    `holding.hold` makes it. The first item is where it lies, for the compiled code; then the value and its memory.
    """

    __slots__ = ()
    held_kind: HeldKind
    """Of the class of its values' kind."""

    @classmethod
    def from_parts(cls, *parts: Any) -> Any:
        """Of address, value and memory."""
        return tuple.__new__(cls, parts)  # pyright: ignore[reportUnknownMemberType]

    @property
    def address(self) -> int:
        """Where it lies."""
        return self[0]

    @property
    def value(self) -> T:
        """As given; it lives as long as this does."""
        return self[1]


_CLASSES: dict[Kind, type[Held[Any]]] = {}


def class_of(kind: HeldKind) -> type[Held[Any]]:
    """The class of held values of a kind."""
    if kind.value not in _CLASSES:
        name = f"Held_{hashlib.blake2b(kind.name.encode(), digest_size=6).hexdigest()}"
        _CLASSES[kind.value] = type(name, (Held,), {"__slots__": (), "held_kind": kind})
    return _CLASSES[kind.value]


def open_held(held: Held[T]) -> T:
    """The value of a `Held`, in a compiled loop that somebody else keeps it alive for."""
    return held.value
