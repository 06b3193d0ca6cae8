"""The works that laws, measures and mathematics of the package come from, by key and by module."""

from __future__ import annotations

from mafsil.control.cited_work import Citation
from mafsil.control.works_of_robotics import WORKS_OF_ROBOTICS
from mafsil.control.works_on_control import WORKS_ON_CONTROL
from mafsil.errors import InputError

CITATIONS = WORKS_ON_CONTROL + WORKS_OF_ROBOTICS
"""All works, each with the modules that follow it or whose matter it treats."""


def citation(key: str) -> Citation:
    """A work by its key.

    Raises:
        InputError: no such work.
    """
    found = {one.key: one for one in CITATIONS}
    if not isinstance(key, str) or key not in found:  # pyright: ignore[reportUnnecessaryIsInstance] - what users give
        raise InputError("input.choice", name="key", value=key, known=", ".join(found))
    return found[key]


def citations_of(module: str) -> tuple[Citation, ...]:
    """The works that a module follows.

    Args:
        module: its full name, such as `mafsil.control.hybrid`.
    """
    return tuple(one for one in CITATIONS if module in one.modules)
