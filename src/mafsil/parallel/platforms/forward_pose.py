"""Poses of a platform found from a first guess, with how exactly every leg fits."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from mafsil.answer import Answer, Status
from mafsil.arrays import Booleans, Floats, Integers
from mafsil.messages.tables import on_screen


class ForwardStatus(Status):
    """How a search for poses ended."""

    FOUND = ("parallel.forward_found", True)
    SOME = ("parallel.forward_some", False)
    SINGULAR = ("parallel.forward_singular", False)
    NOT_FOUND = ("parallel.forward_not_found", False)


@dataclass(frozen=True, eq=False, repr=False)
class ForwardPoses(Answer):
    """Poses of the platform near first ones; true if all were found, iterable over the rows of the batch.

    Attributes:
        T: (*batch, 4, 4) the last poses of the search, in {s}.
        found: (*batch,) whether every leg fits.
        error: (*batch,) largest error of a leg [m].
        steps: (*batch,) Newton steps.
        pivot: (*batch,) least over largest pivot of the last step: zero at a singular pose.
    """

    T: Floats
    found: Booleans
    error: Floats
    steps: Integers
    pivot: Floats

    @property
    def status(self) -> ForwardStatus:
        """Found everywhere, somewhere, nowhere; or stopped at a singular pose."""
        if self.found.all():
            return ForwardStatus.FOUND
        if self.found.any():
            return ForwardStatus.SOME
        return ForwardStatus.SINGULAR if (self.pivot == 0.0).all() else ForwardStatus.NOT_FOUND

    def __bool__(self) -> bool:
        return self.status.succeeded

    def __len__(self) -> int:
        return int(self.found.size)

    def __iter__(self) -> Iterator[Floats]:
        return iter(self.T.reshape(-1, 4, 4))

    def __repr__(self) -> str:
        return on_screen(self.explain())

    def explain(self, language: str | None = None) -> str:
        """How many were found, and the largest error of a leg."""
        return self.status.sentence(
            language, found=int(self.found.sum()), count=self.found.size, error=float(self.error.max(initial=0.0)),
            steps=int(self.steps.max(initial=0)),
        )  # fmt: skip

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "status": self.status.name.lower(), "T": self.T, "found": np.asarray(self.found), "error": self.error,
            "steps": self.steps,
        }  # fmt: skip
