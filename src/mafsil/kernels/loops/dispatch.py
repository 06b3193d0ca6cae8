"""Entries of loops: the loop for the kinds of some arguments, and the builtin through which Python calls it."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from mafsil.kernels import runtime, target
from mafsil.kernels.compiler import _llvm  # pyright: ignore[reportPrivateUsage]
from mafsil.kernels.loops import entry, specialisation
from mafsil.kernels.loops.definition import Definition
from mafsil.kernels.loops.kinds import INTEGER, EditedError, Kind, kind_of
from mafsil.kernels.loops.specialisation import Specialisation, specialise
from mafsil.lazy_module import lazily

if TYPE_CHECKING:
    import mafsil.kernels.loops.entry_code as entry_code
else:
    entry_code = lazily("mafsil.kernels.loops.entry_code")

_ENTRIES: dict[Specialisation, Callable[..., Any]] = {}
_LOCK = threading.RLock()


def entry_for(definition: Definition, arguments: tuple[Any, ...]) -> Callable[..., Any]:
    """The builtin for arguments of such kinds, made at the first question.

    Where objects of this Python lie elsewhere than the machine code looks, loops run as the Python that they are.

    Raises:
        KernelError: the loop is not of the language, or takes no such arguments.
    """
    if not runtime.available():
        return definition.function
    kinds = tuple(kind_of(argument) for argument in arguments)
    try:
        return _entry(definition, kinds)
    except EditedError:  # Nobody knows the source of what is in memory, so it runs as the Python that it is.
        return definition.function


def _entry(definition: Definition, kinds: tuple[Kind, ...]) -> Callable[..., Any]:
    loop = specialise(definition, kinds)
    with _LOCK:
        found = _ENTRIES.get(loop)
        if found is None:
            found = _make(kinds, loop.result, loop.fails, loop.shares_region, loop.address, definition.name)
            _ENTRIES[loop] = found
        return found


def layout_for(kind: Kind) -> Callable[..., Any]:
    """What writes values of a kind to an address."""
    with _LOCK:
        return _make((kind, INTEGER), None, False, False, 0, f"layout of {kind.name[:60]}")


def _make(
    kinds: tuple[Kind, ...], result: Kind | None, fails: bool, shares: bool, address: int, name: str
) -> Callable[..., Any]:
    key = entry.key(kinds, result, fails, shares, specialisation.made_by())
    classes = entry.classes_of(kinds, result)

    def compiled() -> specialisation.Kept:
        text = entry_code.Entry(kinds, result, fails, shares).module()
        with _llvm:
            return [name], target.compile(text, target.host(), 1)

    _, code = specialisation.obtain_code(key, name, compiled)
    places = specialisation.load(code, (entry.ENTRY, entry.LINKS), {})
    table = entry.bind_entry(places[entry.LINKS], address, classes)
    return entry.builtin(places[entry.ENTRY], name, table, classes)
