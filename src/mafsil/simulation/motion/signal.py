"""What acts over time: nothing, a constant, a function of time or state, or samples that are held or joined."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import (
    Floats,
    JointVector,
    as_batch,
    frozen,
    positive,
    real_array,
    require_finite,
    require_function,
    single,
)
from mafsil.errors import InputError

Source: TypeAlias = "ArrayLike | Sampled | Callable[..., ArrayLike] | None"
"""None, an array, `Sampled`, f(t) or f(t, q, qd)."""
Signal: TypeAlias = Callable[[float, JointVector, JointVector], Floats]
"""Value at a time and state."""


ROUNDING = 8 * 2.0**-52
"""Relative error of a time that is still the time of a sample; less than `solvers.adaptive.EDGE`."""


@dataclass(frozen=True, eq=False)
class Sampled:
    """Values on an even time grid that begins at zero; before and after it the first and last value hold.

    Attributes:
        values: (k, *batch, m) at the times 0, step, 2 step, ...
        step: of the grid [s].
        joined: straight lines between the samples; otherwise each value holds until the next (zero-order hold).

    Raises:
        InputError: no samples, a number that is not finite, a step that is not positive.
    """

    values: ArrayLike
    step: float
    joined: bool = False

    def __post_init__(self) -> None:
        values = require_finite("values", real_array("values", self.values))
        if values.ndim < 2 or not len(values):
            raise InputError("input.shape", name="values", expected="(k, *batch, m)", got=values.shape, hint="")
        object.__setattr__(self, "values", frozen(values))
        positive("step", self.step)

    def at(self, t: float) -> Floats:
        """Value (*batch, m) at a time."""
        values, t = cast(Floats, self.values), float(single("t", t, ()))
        place = min(max(t / self.step, 0.0), len(values) - 1.0)
        if not self.joined:
            # A time that rounding puts just before a sample belongs to it.
            return values[int(place * (1.0 + ROUNDING))]
        k = min(int(place), len(values) - 2) if len(values) > 1 else 0
        share = place - k
        return (1.0 - share) * values[k] + share * values[min(k + 1, len(values) - 1)]

    @property
    def breaks(self) -> Floats:
        """Times at which the value or its slope jumps [s]."""
        return np.arange(1.0, len(cast(Floats, self.values))) * self.step


def signal(name: str, source: Source, width: int) -> Signal | None:
    """A source as a function of time and state, checked at every call; None for none.

    Args:
        name: of the argument, for errors.
        source: what the user gave.
        width: length of the last axis.

    Raises:
        InputError: a wrong shape or kind.
    """
    if source is None:
        return None
    if isinstance(source, Sampled):
        as_batch(name, cast(Floats, source.values), (width,))
        return lambda t, q, qd: source.at(t)
    if callable(source):
        function = _of_time_and_state(name, source)
        return lambda t, q, qd: as_batch(name, function(t, q, qd), (width,))
    constant = require_finite(name, as_batch(name, source, (width,)))
    return lambda t, q, qd: constant


def breaks_of(*sources: Source) -> tuple[float, ...]:
    """All times at which samples jump."""
    found: set[float] = set()
    for source in sources:
        if isinstance(source, Sampled):
            found.update(source.breaks.tolist())
    return tuple(sorted(found))


def _of_time_and_state(name: str, function: Callable[..., Any]) -> Callable[..., Any]:
    """f(t, q, qd), also of a function that takes the time alone."""
    try:
        parameters = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):
        return function
    needed = [p for p in parameters if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD) and p.default is p.empty]
    alone = len(needed) <= 1 and not any(p.kind is p.VAR_POSITIONAL for p in parameters)
    require_function(name, function, "function of t or of (t, q, qd)", 1 if alone else 3)
    if not alone:
        return function

    def of_time(t: float, q: Any, qd: Any) -> Any:
        return function(t)

    return of_time
