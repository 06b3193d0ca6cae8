"""Loops to convergence as Python functions: compiled for the kinds of their arguments at the first call.

    @compiled
    def total(numbers: Floats) -> float: ...

`compiled` is the usual one; `reordered` lets sums be taken in another order, so that loops along a row fill whole
vectors; `inlined` is for short functions whose arguments cost more than their work. Compiled code is kept on disk,
releases the interpreter's lock and follows IEEE rules: a division by zero is an infinity, not an exception.

With MAFSIL_LOOPS=python in the environment they stay the functions of Python that they are, for a debugger.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Generic, ParamSpec, TypeVar, cast

import numpy as np

from mafsil.errors import KernelError
from mafsil.kernels.loops.definition import FREE_ORDER, MISS, Definition
from mafsil.lazy_module import lazily

if TYPE_CHECKING:
    import mafsil.kernels.loops.dispatch as dispatch
else:
    dispatch = lazily("mafsil.kernels.loops.dispatch")

MODE_VARIABLE = "MAFSIL_LOOPS"
"""Environment variable; `python` runs loops as ordinary Python."""
P = ParamSpec("P")
R = TypeVar("R")


class Loop(Generic[P, R]):
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

    def __call__(self, *args: P.args, **named: P.kwargs) -> R:
        """Run it; compiled first if these kinds of arguments are new."""
        if named:
            return self(*self._in_order(args, named))
        for entry in self._entries:
            found = entry(*args)
            if found is not MISS:
                return found
        return cast(R, self._first_call(args))

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
    if word == "float" and isinstance(value, int | np.integer | np.floating):
        return float(value)
    if word == "int" and isinstance(value, bool | np.bool_ | np.integer):
        return int(value)
    if isinstance(value, np.ndarray) and type(value) is not np.ndarray:
        return np.asarray(value)
    return cast(Any, value)


def compiled(function: Callable[P, R]) -> Loop[P, R]:
    """The function as machine code.

    Args:
        function: loops over arrays and numbers, of the language that `mafsil.kernels.loops` describes.
    """
    return _loop(Definition(function))


def reordered(function: Callable[P, R]) -> Loop[P, R]:
    """As `compiled`, but sums may be taken in another order.

    Args:
        function: loops over arrays and numbers.
    """
    return _loop(Definition(function, fast=FREE_ORDER))


def inlined(function: Callable[P, R]) -> Loop[P, R]:
    """As `compiled`, and part of each loop that calls it.

    Args:
        function: short.
    """
    return _loop(Definition(function, inline=True))


def is_plain() -> bool:
    """Whether loops run as the Python that they are."""
    return os.environ.get(MODE_VARIABLE) == "python"


def _loop(definition: Definition) -> Any:
    if is_plain():
        return definition.function
    return Loop(definition)
