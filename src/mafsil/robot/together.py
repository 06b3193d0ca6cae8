"""The call of several quantities at once: what editors show and type checkers read."""

from __future__ import annotations

from typing import Protocol

from numpy.typing import ArrayLike

from mafsil.arrays import Floats


class Together(Protocol):
    """Several quantities of one state: inputs in the order of `kernel.signature`, one result for each quantity."""

    def __call__(
        self, *inputs: ArrayLike, out: tuple[Floats, ...] | None = None, threads: int | None = None
    ) -> tuple[Floats, ...]: ...
