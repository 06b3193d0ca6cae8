"""Modules of this package that are loaded at their first use, so that a start from the cache stays quick.

A module that needs another one late says so at its top, where people, type checkers and the contracts of layers look:

    if TYPE_CHECKING:
        import mafsil.ik.numerical as numerical
    else:
        numerical = lazily("mafsil.ik.numerical")

No import statement then stands inside a function (a test of the house looks for them). Names are always looked up in
the module itself, never copied: what a test replaces there is replaced here too.
"""

from __future__ import annotations

from importlib import import_module
from types import ModuleType
from typing import Any, TypeVar, cast

T = TypeVar("T")


class LazyModule:
    """Stands for a module until one of its names is used; threads that meet here wait at Python's own import lock.

    It is no `ModuleType`: a module looks for a missing name four times as long, in every call of a loop.
    """

    __slots__ = ("_loaded", "_name")
    _loaded: ModuleType | None
    _name: str

    def __init__(self, name: str) -> None:
        object.__setattr__(self, "_name", name)
        object.__setattr__(self, "_loaded", None)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._loaded or self._itself(), name)

    def _itself(self) -> ModuleType:
        if self._loaded is None:
            object.__setattr__(self, "_loaded", import_module(self._name))
        assert self._loaded is not None
        return self._loaded

    def __setattr__(self, name: str, value: object) -> None:
        setattr(import_module(self._name), name, value)

    def __delattr__(self, name: str) -> None:
        delattr(import_module(self._name), name)

    def __dir__(self) -> list[str]:
        return dir(import_module(self._name))

    def __repr__(self) -> str:
        return f"<{self._name}, loaded at its first use>"

    def __reduce__(self) -> tuple[Any, tuple[str]]:
        return lazily, (self._name,)


def lazily(name: str) -> LazyModule:
    """The module of this name, loaded when the first of its names is used.

    Args:
        name: full, as "mafsil.ik.numerical"; an ImportError comes at the first use.
    """
    return LazyModule(name)


def loaded(module: T) -> T:
    """The module itself that a `LazyModule` stands for, for a call that needs several of its names.

    Args:
        module: made by `lazily`, or a test's replacement of it.
    """
    return cast("T", module._itself()) if isinstance(module, LazyModule) else module  # pyright: ignore[reportPrivateUsage]
