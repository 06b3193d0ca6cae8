"""Arguments of a robot's routines, given by position or by name."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.errors import InputError
from mafsil.mechanics.quantity import Quantity

OPTIONS = ("out", "threads", "degrees")
"""What every routine takes by name."""
TIP_LETTERS = ("b", "t", "tip")
"""Letters that a wrench in the tip frame may carry, besides the name of the tip link."""


def arrange(
    row: Quantity, arrays: tuple[ArrayLike, ...], named: dict[str, ArrayLike], tip: str = "tip"
) -> dict[str, ArrayLike]:
    """Inputs by name in the order of the catalogue, optional ones at the end only if given.

    Args:
        row: the quantity.
        arrays: given by position.
        named: given by name.
        tip: name of the tip link, in whose frame a tip wrench is.

    Raises:
        InputError: too many, unknown, given twice, or missing.
    """
    names = (*row.inputs, *row.optional)
    if len(arrays) > len(names):
        raise InputError("robot.too_many", name=row.name, count=len(arrays), inputs=", ".join(names))
    given: dict[str, Any] = dict(zip(names, arrays, strict=False))
    for name, value in named.items():
        if name not in names or name in given:
            options = ", ".join(["frame", *OPTIONS] if row.framed else OPTIONS)
            details = {"name": name, "inputs": ", ".join(names), "options": options}
            raise InputError("robot.unexpected", routine=row.name, **details)
        given[name] = value
    missing = [name for name in row.inputs if name not in given]
    if missing:
        raise InputError("robot.missing", name=row.name, missing=", ".join(missing), inputs=", ".join(names))
    return {
        name: in_tip(name, given[name], tip) if name == "tip_wrench" else given[name]
        for name in names
        if name in row.inputs or given.get(name) is not None
    }


def twin_form(
    row: Quantity, count: int, named: tuple[str, ...], frame: str | None, optional: tuple[str, ...]
) -> str | int | tuple[str, ...] | None:
    """Under what a builtin for this form of a call is kept (`Evaluator.twins`); None if the form has none of its own.

    Such a form gives all inputs by position and a frame alone; or optional inputs by position, without a gap; or some
    inputs by name, whose tuple then stands for it.

    Args:
        row: the quantity.
        count: number of arguments given by position.
        named: names of those given by name, besides `frame`, in their order.
        frame: link name, or None.
        optional: which optional inputs are there (and not None).
    """
    extra = count - len(row.inputs)
    if frame is not None:
        return None if extra or named or optional else frame
    if extra > 0:
        return count if not named and optional == row.optional[:extra] else None
    return named if set(optional) <= set(named) else None


def in_tip(name: str, value: ArrayLike, tip: str) -> ArrayLike:
    """A wrench at the tip as given, if its type and frame letter (where it has one) say that it is in the tip frame.

    Args:
        name: of the argument, for the error.
        value: numbers, or a `Wrench`.
        tip: name of the tip link.

    Raises:
        InputError: a `Wrench` of another frame, or another typed value; what to do stands in the sentence.
    """
    kind, given = type(value).__name__, value
    if isinstance(value, np.ndarray | list | tuple) or not hasattr(value, "frame"):
        return given
    frame = getattr(value, "frame", None)
    if kind != "Wrench":
        raise InputError("input.kind", name=name, expected="Wrench", got=kind)
    if frame is not None and frame not in (*TIP_LETTERS, tip):
        raise InputError("robot.wrench_frame", name=name, frame=frame, known=", ".join((*TIP_LETTERS, tip)))
    return value
