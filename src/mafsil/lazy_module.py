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
from typing import Any


class LazyModule(ModuleType):
    """Stands for a module until one of its names is used; threads that meet here wait at Python's own import lock."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.__dict__["_loaded"] = None

    def __getattr__(self, name: str) -> Any:
        loaded = self.__dict__["_loaded"]
        if loaded is None:
            loaded = self.__dict__["_loaded"] = import_module(self.__name__)
        return getattr(loaded, name)

    def __setattr__(self, name: str, value: object) -> None:
        setattr(import_module(self.__name__), name, value)

    def __dir__(self) -> list[str]:
        return dir(import_module(self.__name__))

    def __repr__(self) -> str:
        return f"<{self.__name__}, loaded at its first use>"

    def __reduce__(self) -> tuple[Any, tuple[str]]:
        return lazily, (self.__name__,)


def lazily(name: str) -> LazyModule:
    """The module of this name, loaded when the first of its names is used.

    Args:
        name: full, as "mafsil.ik.numerical"; an ImportError comes at the first use.
    """
    return LazyModule(name)
