"""Loops to convergence as Python functions: compiled for the kinds of their arguments at the first call.

    @compiled
    def total(numbers: Floats) -> float: ...

`compiled` is the usual one; `reordered` lets sums be taken in another order, so that loops along a row fill whole
vectors; `inlined` is for short functions whose arguments cost more than their work. Compiled code is kept on disk,
releases the interpreter's lock and follows IEEE rules: a division by zero is an infinity, not an exception. Values that
loops are asked about again and again are laid out in memory once (`hold`).

With MAFSIL_LOOPS=python in the environment they stay the functions of Python that they are, for a debugger.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar, cast

import numpy as np

from mafsil.errors import KernelError
from mafsil.kernels import runtime
from mafsil.kernels.loops.definition import FREE_ORDER, MISS, Definition
from mafsil.kernels.loops.entry import Held, class_of
from mafsil.kernels.loops.kinds import held_of, kind_of
from mafsil.lazy_module import lazily

if TYPE_CHECKING:
    import mafsil.kernels.loops.specialisation as dispatch
else:
    dispatch = lazily("mafsil.kernels.loops.specialisation")


MODE_VARIABLE = "MAFSIL_LOOPS"
"""Environment variable; `python` runs loops as ordinary Python."""
F = TypeVar("F", bound=Callable[..., Any])


class Loop:
    """A function that is machine code once it is called.

    Attributes:
        definition: the function, and how its code is made.
    """

    __slots__ = ("__dict__", "_entries", "definition")

    def __init__(self, definition: Definition) -> None:
        self.definition = definition
        self._entries: tuple[Callable[..., Any], ...] = ()
        for name in ("__module__", "__name__", "__qualname__", "__doc__"):
            setattr(self, name, getattr(definition.function, name))

    def __call__(self, *args: Any, **named: Any) -> Any:
        """Run it; compiled first if these kinds of arguments are new."""
        if named:
            return self(*self._in_order(args, named))
        for entry in self._entries:
            found = entry(*args)
            if found is not MISS:
                return found
        return self._first_call(args)

    def compile(self, *examples: Any) -> None:
        """Have it ready for arguments like these.

        Args:
            examples: one for each argument.
        """
        self._first_entry(examples)

    def _in_order(self, args: tuple[Any, ...], named: dict[str, Any]) -> Any:
        """The arguments in the order of the function, named ones too."""
        names = self.definition.arguments
        return (*args, *(named[name] for name in names[len(args) :]))

    def _first_call(self, args: tuple[Any, ...]) -> Any:
        """A call with arguments of kinds that are new, or that are converted first."""
        entry, converted = self._first_entry(args)
        found = entry(*converted)
        if found is MISS:
            raise KernelError("kernels.refused", reason=f"{self.definition.name}: arguments of unknown kinds")
        return found

    def _first_entry(self, args: tuple[Any, ...]) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        """The entry for arguments, and these as it takes them."""
        words = self.definition.words
        if len(args) != len(words):
            raise TypeError(f"{self.definition.function.__name__}() takes {len(words)} arguments, not {len(args)}")
        converted = tuple(_as_annotated(value, word) for value, word in zip(args, words, strict=True))
        entry = dispatch.entry_for(self.definition, converted)
        if entry not in self._entries:
            self._entries = (*self._entries, entry)
        return entry, converted


def _as_annotated(value: Any, word: str) -> Any:
    """A number as the kind that the function's annotation says; other values as they are."""
    if word == "float" and isinstance(value, _NUMBERS):
        return float(value)
    if word == "int" and isinstance(value, _WHOLE):
        return int(value)
    if isinstance(value, np.ndarray) and type(value) is not np.ndarray:  # pyright: ignore[reportUnknownArgumentType]
        return np.asarray(value)  # pyright: ignore[reportUnknownVariableType, reportUnknownArgumentType]
    return cast(Any, value)


_WHOLE: Any = (bool, np.bool_, np.integer)
_NUMBERS: Any = (int, np.integer, np.floating)


def compiled(function: F) -> F:
    """The function as machine code.

    Args:
        function: loops over arrays and numbers, of the language that `mafsil.kernels.loops` describes.
    """
    return _loop(Definition(function))


def reordered(function: F) -> F:
    """As `compiled`, but sums may be taken in another order.

    Args:
        function: loops over arrays and numbers.
    """
    return _loop(Definition(function, fast=FREE_ORDER))


def inlined(function: F) -> F:
    """As `compiled`, and part of each loop that calls it.

    Args:
        function: short.
    """
    return _loop(Definition(function, inline=True))


def is_plain() -> bool:
    """Whether loops run as the Python that they are."""
    return os.environ.get(MODE_VARIABLE) == "python"


def _loop(definition: Definition) -> Any:
    return definition.function if is_plain() else Loop(definition)


T = TypeVar("T")
Layout = Callable[[Any, int], object]
"""What writes a value to an address, or returns MISS if it is of another kind."""
_LAYOUTS: dict[type[Any], list[tuple[int, Layout, type[Held[Any]]]]] = {}


def hold(value: T) -> Held[T]:
    """Lay a named tuple of arrays and numbers out; it lives as long as what is returned.

    Args:
        value: the tuple.
    """
    if is_plain() or not runtime.available():  # Loops that run as Python read the value itself.
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
