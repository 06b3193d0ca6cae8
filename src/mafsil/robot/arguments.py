"""Arguments of a robot's routines, given by position or by name."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from mafsil.errors import InputError
from mafsil.mechanics.quantities import Quantity


def arranged(row: Quantity, arrays: tuple[ArrayLike, ...], named: dict[str, ArrayLike]) -> dict[str, ArrayLike]:
    """Inputs by name in the order of the catalogue, optional ones at the end only if given.

    Args:
        row: the quantity that is asked for.
        arrays: given by position.
        named: given by name.

    Raises:
        InputError: too many, unknown, given twice, or missing.
    """
    names = (*row.inputs, *row.optional)
    if len(arrays) > len(names):
        raise InputError("robot.too_many", name=row.name, count=len(arrays), inputs=", ".join(names))
    given: dict[str, Any] = dict(zip(names, arrays, strict=False))
    for name, value in named.items():
        if name not in names or name in given:
            raise InputError("robot.unexpected", routine=row.name, name=name, inputs=", ".join(names))
        given[name] = value
    missing = [name for name in row.inputs if name not in given]
    if missing:
        raise InputError("robot.missing", name=row.name, missing=", ".join(missing), inputs=", ".join(names))
    return {name: given[name] for name in names if name in row.inputs or given.get(name) is not None}
