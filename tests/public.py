"""What is public: the names on the faces of all packages, as users reach them."""

from collections.abc import Iterator
from importlib import import_module
from pkgutil import walk_packages
from types import ModuleType

import mafsil as mf

NO_PYTHON = ("mafsil.cli", "mafsil.messages", "mafsil.code_store")
"""Packages that users meet as commands and sentences."""


def faces() -> Iterator[ModuleType]:
    """The top, then every package that lists names, topics of packages included."""
    yield mf
    for found in walk_packages(mf.__path__, "mafsil."):
        if found.ispkg and not found.name.startswith(NO_PYTHON):
            package = import_module(found.name)
            if package.__all__:
                yield package


def public() -> Iterator[tuple[str, object]]:
    """Every public thing that is no module, once, by its shortest name."""
    names: dict[int, tuple[str, object]] = {}
    for face in faces():
        for name in face.__all__:
            thing = getattr(face, name)
            if not isinstance(thing, ModuleType):
                long = f"{face.__name__}.{name}"
                known = names.get(id(thing), (long, thing))
                names[id(thing)] = (min(long, known[0], key=lambda text: (len(text), text)), thing)
    yield from names.values()
