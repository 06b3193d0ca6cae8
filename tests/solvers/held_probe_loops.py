"""Loops over values handed over once that only the tests call."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil.kernels.loops.entry import Held, open_held
from mafsil.kernels.loops.loop import compiled


class Inner(NamedTuple):
    """A part."""

    rows: NDArray[np.float64]
    flags: NDArray[np.bool_]
    count: int


class Outer(NamedTuple):
    """A whole."""

    inner: Inner
    share: float
    table: NDArray[np.int64]


@compiled
def weighed(held: Held[Outer], x: NDArray[np.float64]) -> float:
    """A number that everything in the value has a part in; the first row doubles."""
    value = open_held(held)
    total = value.share * value.table.sum() + value.inner.count
    for k in range(len(x)):
        if value.inner.flags[k]:
            total += x[k] * value.inner.rows[k].sum()
    value.inner.rows[0] *= 2.0
    return total
