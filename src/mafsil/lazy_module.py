"""Modules and public names that are loaded at their first use, so that a start from the cache stays quick.

The public names of a package stand in its stub `__init__.pyi`, once, as imports that type checkers and editors read:

    from mafsil.planning.arm_planning import plan as plan

Its `__init__.py` holds the docstring and `__all__ = face(__name__)`: a name is imported when it is first asked for.

A module that needs another one late says so at its top, where people, type checkers and the contracts of layers look:

    if TYPE_CHECKING:
        import mafsil.ik.numerical as numerical
    else:
        numerical = lazily("mafsil.ik.numerical")

No import statement then stands inside a function (a test of the house looks for them). Names are always looked up in
the module itself, never copied: what a test replaces there is replaced here too.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from importlib import import_module
from types import ModuleType
from typing import Any, TypeVar, cast

T = TypeVar("T")
_PUBLIC = re.compile(r"^from (\S+) import (\w+) as \2$", re.MULTILINE)


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
            _gate_loaded_classes()
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


def load_module(module: T) -> T:
    """The module itself that a `LazyModule` stands for, for a call that needs several of its names.

    Args:
        module: made by `lazily`, or a test's replacement of it.
    """
    return cast("T", module._itself()) if isinstance(module, LazyModule) else module  # pyright: ignore[reportPrivateUsage]


class Package(ModuleType):
    """A package that knows its public names; one that a module of it has too, as `control.citation`, stays."""

    _homes: dict[str, str]

    def __setattr__(self, name: str, value: object) -> None:
        """Python's import sets every loaded module in its package; it does not replace a public name."""
        if not isinstance(value, ModuleType) or self._homes.get(name, self.__name__) == self.__name__:
            super().__setattr__(name, value)

    def __call__(self, *_: object, **__: object) -> Any:
        """`mf.ik(robot, T)`: the package has no such call, and the error says which one is meant."""
        raise _strangers[0](self, self.__name__.rpartition(".")[2])


def face(package: str) -> tuple[str, ...]:
    """Public names of a package, from its stub; each is imported at its first use, and so is every module of it.

    Args:
        package: its `__name__`, while its `__init__.py` runs.
    """
    module = sys.modules[package]
    homes, names = public_names(module), vars(module)
    for name, home in homes.items():
        _waiting.setdefault(home, set()).add(name)

    def __getattr__(name: str) -> Any:
        home = homes.get(name, package)
        if home == package:
            names[name] = value = _module_of(package, name)
        else:
            names[name] = value = _through_the_gate(import_module(home), name)
        _gate_loaded_classes()
        return value

    names |= {"__getattr__": __getattr__, "__dir__": lambda: list(homes), "_homes": homes}
    module.__class__ = Package
    return tuple(name for name in homes if not name.startswith("_"))


_gates: list[Callable[[Any], Any]] = []
_strangers: list[Callable[[ModuleType, str], AttributeError]] = []
_waiting: dict[str, set[str]] = {}
"""Public names by the module that defines them, until their classes have passed the gate."""


def stand_before_public_names(
    gate: Callable[[Any], Any], stranger: Callable[[ModuleType, str], AttributeError]
) -> None:
    """Let every public name pass a gate when it is first asked for, a class when its module is loaded.

    Args:
        gate: gives back what it gets, a class itself, or what stands for it.
        stranger: the error for a name that a package does not have.
    """
    _gates.append(gate)
    _strangers.append(stranger)


def _through_the_gate(home: ModuleType, name: str) -> Any:
    """A name of a module, behind the gate; its modules have it so from then on: they show one thing under one name."""
    value = inside = getattr(home, name)
    for gate in _gates:
        value = gate(value)
    if value is not inside:
        for module in (home, sys.modules.get(inside.__module__, home)):
            if getattr(module, name, None) is inside:
                setattr(module, name, value)
    return value


def _gate_loaded_classes() -> None:
    """Every public class of the modules loaded so far, behind the gate: functions give back what nobody asked for."""
    for home in _waiting.keys() & sys.modules.keys():
        defined, names = vars(sys.modules[home]), _waiting.get(home, set())
        if names <= defined.keys():  # Otherwise the module is still being loaded.
            _waiting.pop(home, None)
            for value in map(defined.get, names):
                for gate in _gates if isinstance(value, type) else ():
                    gate(value)


def public_names(package: ModuleType) -> dict[str, str]:
    """The module of each public name, by the package's stub.

    Args:
        package: with a file `__init__.pyi` beside its `__init__.py`.
    """
    loader: Any = package.__loader__
    stub = loader.get_data(f"{package.__path__[0]}/__init__.pyi").decode()
    return {name: home for home, name in _PUBLIC.findall(stub)}


_extensions: dict[str, str] = {}


def extend(name: str, package: str) -> None:
    """Register a package whose public functions a class of a lower layer has as methods, or a module that it asks.

    Args:
        name: of the class, or of what `registered` is asked for.
        package: with a face, or the module.
    """
    _extensions[name] = package


def registered(name: str) -> Any:
    """The module that a higher layer registered under a name by `extend`; None without one.

    Args:
        name: of what a lower layer leaves to it.
    """
    return import_module(_extensions[name]) if name in _extensions else None


def extension(name: str) -> type:
    """A base class with the methods that a higher layer registered; each is imported at its first use.

    Args:
        name: of the class that inherits them.
    """
    packages = [_extensions[name]] if name in _extensions else []
    methods = {method: _Method(package, method) for package in packages for method in import_module(package).__all__}
    return type(f"{name}Extension", (), methods)


class _Method:
    """Stands for a method until it is first used."""

    def __init__(self, package: str, name: str) -> None:
        self._package, self._name = package, name

    def __get__(self, instance: object, owner: type) -> Any:
        function = getattr(import_module(self._package), self._name)
        for kind in owner.__mro__:
            if vars(kind).get(self._name) is self:
                setattr(kind, self._name, function)
        return function.__get__(instance, owner)


def _module_of(package: str, name: str) -> ModuleType:
    """A module of a package.

    Raises:
        AttributeError: there is none of that name.
    """
    full = f"{package}.{name}"
    try:
        if not name.startswith("_"):
            return import_module(full)
    except ModuleNotFoundError as error:
        if error.name != full:
            raise
    raise _strangers[0](sys.modules[package], name)
