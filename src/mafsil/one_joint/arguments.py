"""The gate of this package: finite numbers, magnitudes and shares in, float64 arrays out, batches as they come."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import SMALLEST, Floats, calculable, real_array, require_finite
from mafsil.errors import InputError
from mafsil.fields import Check, check_fields


def finite(name: str, value: ArrayLike) -> Floats:
    """(*batch) finite numbers.

    Raises:
        InputError: not real numbers, or a NaN or infinity.
    """
    array = require_finite(name, real_array(name, value))
    calculable(name, array[np.abs(array) >= SMALLEST])
    return array


def magnitude(name: str, value: ArrayLike) -> Floats:
    """(*batch) finite numbers of at least zero.

    Raises:
        InputError: one is negative or not finite.
    """
    array = finite(name, value)
    if (array < 0.0).any():
        raise InputError("input.range", name=name, value=float(array.min()), low=0.0, high=np.inf)
    return array


def above_zero(name: str, value: ArrayLike) -> Floats:
    """(*batch) finite positive numbers.

    Raises:
        InputError: one is zero, negative or not finite.
    """
    array = finite(name, value)
    if (array <= 0.0).any():
        raise InputError("input.positive", name=name, value=float(array.min()))
    return calculable(name, array)


def above_zero_or_unbounded(name: str, value: ArrayLike) -> Floats:
    """(*batch) positive numbers, infinite where there is no bound.

    Raises:
        InputError: one is zero, negative or NaN.
    """
    array = real_array(name, value)
    above_zero(name, np.where(np.isposinf(array), 1.0, array))
    return array


def share(name: str, value: ArrayLike) -> Floats:
    """(*batch) numbers above 0 and at most 1.

    Raises:
        InputError: one lies outside.
    """
    array = above_zero(name, value)
    if (array > 1.0).any():
        raise InputError("input.range", name=name, value=float(array.max()), low=0.0, high=1.0)
    return array


def row(name: str, value: ArrayLike, least: int = 1) -> Floats:
    """(*batch, k) finite numbers, k at least `least`.

    Raises:
        InputError: no last dimension, or a short one; a NaN or infinity.
    """
    array = finite(name, value)
    if array.ndim == 0 or array.shape[-1] < least:
        raise InputError("input.shape", name=name, expected=f"(*batch, k), k >= {least}", got=array.shape, hint="")
    return array


def together(**values: ArrayLike) -> tuple[Floats, ...]:
    """All arrays of one shape.

    Raises:
        InputError: no real numbers, or their shapes do not go together.
    """
    arrays = {name: real_array(name, value) for name, value in values.items()}
    try:
        return tuple(np.broadcast_arrays(*arrays.values()))
    except ValueError:
        shapes = ", ".join(f"{name} {array.shape}" for name, array in arrays.items())
        raise InputError("one_joint.shapes", shapes=shapes) from None


def check_batch(**checks: Check) -> Callable[[Any], None]:
    """The `__post_init__` of a data class of batches: every field is held against what it may be, all of one shape.

    Args:
        checks: the check of each field.
    """
    check = check_fields(**checks)

    def post_init(value: Any) -> None:
        check(value)
        arrays = together(**{name: getattr(value, name) for name in checks})
        for name, array in zip(checks, arrays, strict=True):
            object.__setattr__(value, name, array)

    return post_init
