"""What makes a function a loop of the language: the function, and how its code is made."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from mafsil.kernels.loops.kinds import Kind

MISS = object()
"""What a builtin returns where it is not made for the arguments."""
FREE_ORDER = "reassoc nsz contract "
"""Flags of arithmetic whose sums may be taken in another order."""


@dataclass(frozen=True, eq=False)
class Definition:
    """A function of the language.

    Attributes:
        function: of Python.
        inline: whether it becomes part of each of its callers.
        fast: flags of its arithmetic.
    """

    function: Callable[..., Any]
    inline: bool = False
    fast: str = ""

    @property
    def definition(self) -> Definition:
        """Itself: a loop has one too."""
        return self

    @property
    def name(self) -> str:
        """Module and name."""
        return f"{self.function.__module__}:{self.function.__qualname__}"

    @property
    def arguments(self) -> tuple[str, ...]:
        """Names of its arguments."""
        code = self.function.__code__
        return code.co_varnames[: code.co_argcount]

    @property
    def words(self) -> tuple[str, ...]:
        """Annotations of its arguments, as written; empty where there is none."""
        notes = self.function.__annotations__
        return tuple(str(notes.get(name, "")) for name in self.arguments)


class Callee(Protocol):
    """What a function that is being translated knows of one that it calls."""

    @property
    def symbol(self) -> str:
        """Its name in LLVM IR."""
        ...

    @property
    def result(self) -> Kind:
        """Kind of its result."""
        ...

    @property
    def fails(self) -> bool:
        """Whether it says at its end that memory was lacking."""
        ...

    @property
    def shares_region(self) -> bool:
        """Whether its memory joins that of its caller."""
        ...
