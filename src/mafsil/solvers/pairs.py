"""The adaptive methods by the names that users type."""

from __future__ import annotations

from collections.abc import Callable

from mafsil.errors import InputError
from mafsil.solvers.dormand_prince_853 import dormand_prince_853
from mafsil.solvers.embedded import EmbeddedPair, bogacki_shampine, dormand_prince

PAIRS: dict[str, Callable[[], EmbeddedPair]] = {
    "bs23": bogacki_shampine,
    "dp45": dormand_prince,
    "dop853": dormand_prince_853,
}
"""Made, and checked, when they are first asked for."""


def pair(name: str) -> EmbeddedPair:
    """The pair of that name.

    Raises:
        InputError: there is none; the sentence lists the names.
    """
    if name not in PAIRS:
        raise InputError("input.choice", name="method", value=name, known=", ".join(PAIRS))
    return PAIRS[name]()
