"""What goes into every call of this package and what comes out of it, in batches: row by row.

In go finite numbers, magnitudes and shares, gated and made float64 arrays; out comes a status for each row of the
batch, numbers beside it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import fields, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Answer, Status
from mafsil.arrays import SMALLEST, Floats, calculable, real_array, require_finite
from mafsil.errors import InputError
from mafsil.fields import Check, check_fields
from mafsil.messages import say
from mafsil.messages.tables import number, table


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


class RowAnswer(Answer):
    """One verdict for each row; every array of it has the batch in front. True if all rows succeeded.

    Subclasses are frozen dataclasses whose first attribute is `verdict`.

    Attributes:
        statuses: what the numbers of `verdict` mean.
        verdict: (*batch) which of `statuses`.
    """

    __slots__ = ()
    statuses: ClassVar[tuple[Status, ...]]
    verdict: NDArray[np.int8]

    @property
    def status(self) -> Status | tuple[Status, ...]:
        """The status; of a batch one for each row."""
        found = tuple(self.statuses[k] for k in self.verdict.ravel().tolist())
        return found if self.verdict.ndim else found[0]

    def details(self) -> dict[str, object]:
        """Numbers that the sentence of a single answer mentions."""
        return {name: float(value) for name, value in self._columns().items()}

    def __bool__(self) -> bool:
        return self.verdict.size > 0 and all(self.statuses[k].succeeded for k in set(self.verdict.ravel().tolist()))

    def __len__(self) -> int:
        return self.verdict.size

    def __iter__(self) -> Iterator[Any]:
        arrays = self._arrays()
        for index in np.ndindex(self.verdict.shape):
            own: Any = self
            yield replace(own, **{name: value[index] for name, value in arrays.items()})

    def _table(self) -> list[str]:
        if not self.verdict.ndim:
            return []
        columns = {name: value.ravel().tolist() for name, value in self._columns().items()}
        names = [self.statuses[k].name.lower() for k in self.verdict.ravel().tolist()]
        rows = [(f"{k} {name}", *(number(column[k]) for column in columns.values())) for k, name in enumerate(names)]
        return table(("", *columns), rows)

    def explain(self, language: str | None = None) -> str:
        """The sentence; of a batch one for each status that occurs, with the number of its rows."""
        if not self.verdict.ndim:
            return self.statuses[int(self.verdict)].sentence(language, **self.details())
        flat: list[int] = self.verdict.ravel().tolist()
        kinds = sorted(set(flat))
        counts = [flat.count(kind) for kind in kinds]
        lines = [
            say(
                "one_joint.rows", language=language, count=count, of=len(self), status=say(
                    self.statuses[k].key + "_many", language=language
                )
            )
            for k, count in zip(kinds, counts, strict=True)
        ]  # fmt: skip
        return "\n".join(lines) or say("one_joint.no_rows", language=language)

    def to_dict(self) -> dict[str, Any]:
        """Plain data: names of statuses, arrays, numbers."""
        names = [self.statuses[k].name.lower() for k in self.verdict.ravel().tolist()]
        own: Any = self
        rest = {each.name: getattr(own, each.name) for each in fields(own) if each.name != "verdict"}
        return {"status": names if self.verdict.ndim else names[0], **rest}

    def _arrays(self) -> dict[str, NDArray[Any]]:
        own: Any = self
        pairs: list[tuple[str, Any]] = [(each.name, getattr(own, each.name)) for each in fields(own)]
        return {name: value for name, value in pairs if hasattr(value, "dtype")}

    def _columns(self) -> dict[str, NDArray[Any]]:
        return {
            name: value
            for name, value in self._arrays().items()
            if name != "verdict" and value.shape == self.verdict.shape and value.dtype.kind in "fiub"
        }
