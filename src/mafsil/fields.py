"""Numbers in the fields of values that users write: declared once for a class, checked whenever one is made."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np

from mafsil.arrays import Floats, frozen, real_array, require_finite, single
from mafsil.errors import InputError

Check: TypeAlias = Callable[[str, Any], Any]
"""What a field may hold: of its name and what was given, what is kept; raises InputError. Such as `arrays.positive`."""


def check_fields(**fields: Check) -> Callable[[Any], None]:
    """The `__post_init__` of a data class, or its first step: every field is held against what it may be.

    Args:
        fields: the check of each.
    """

    def check(value: Any) -> None:
        for name, each in fields.items():
            object.__setattr__(value, name, each(name, getattr(value, name)))

    return check


def or_none(check: Check) -> Check:
    """The same, and None stays None."""
    return lambda name, value: None if value is None else check(name, value)


def real(name: str, value: object) -> float:
    """One real number of any size, NaN and infinities too: for classes with a rule of their own about these.

    Raises:
        InputError: it is none, or several.
    """
    array = real_array(name, value)  # type: ignore[arg-type]
    if array.ndim:
        raise InputError("input.shape", name=name, expected="()", got=array.shape, hint="")
    return float(array)


def between(low: float, high: float) -> Check:
    """A number from `low` to `high`."""

    def check(name: str, value: object) -> float:
        given = real(name, value)
        if not low <= given <= high:
            raise InputError("input.range", name=name, value=value, low=low, high=high)
        return given

    return check


def vector(*shape: int) -> Check:
    """A read-only array of this very shape, finite."""
    return lambda name, value: frozen(single(name, value, shape))


def square(name: str, value: Any) -> Floats:
    """(*batch, n, n) a read-only array of finite numbers."""
    array = require_finite(name, real_array(name, value))
    if array.ndim < 2 or array.shape[-1] != array.shape[-2]:
        raise InputError("input.shape", name=name, expected="(*batch, n, n)", got=array.shape, hint="")
    return frozen(array)


def numbers(*dimensions: int, unbounded: bool = False) -> Check:
    """An array of finite numbers, not copied: for values that are made in the middle of computations.

    Args:
        dimensions: how many it may have; any if none is given.
        unbounded: whether infinities have a meaning.
    """

    def check(name: str, value: Any) -> Floats:
        array = real_array(name, value)
        require_finite(name, np.where(np.isinf(array), 0.0, array) if unbounded else array)
        if dimensions and array.ndim not in dimensions:
            expected = " | ".join("(" + "k, " * count + ")" for count in dimensions)
            raise InputError("input.shape", name=name, expected=expected, got=array.shape, hint="")
        return array

    return check


def finite(*dimensions: int, low: float = -np.inf, high: float = np.inf) -> Check:
    """A read-only array of finite numbers.

    Args:
        dimensions: how many it may have; any if none is given.
        low, high: bounds of every number.
    """
    kept = numbers(*dimensions)

    def check(name: str, value: Any) -> Floats:
        array = kept(name, value)
        if (array < low).any() or (array > high).any():
            worst = float(array.min() if (array < low).any() else array.max())
            raise InputError("input.range", name=name, value=worst, low=low, high=high)
        return frozen(array)

    return check
