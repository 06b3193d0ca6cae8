"""Places of a point that rods from ends of cranks hold: both, any of a circle, or how far the rods are from meeting."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from mafsil.answer import Answer, Status
from mafsil.arrays import Booleans, Floats, Integers
from mafsil.messages import say
from mafsil.messages.tables import number, on_screen, table
from mafsil.parallel.nearest_lengths import LegEnds, NearestLengths


class PlatformPointsStatus(Status):
    """Whether the rods meet."""

    ALL = ("parallel.points_all", True)
    SOME = ("parallel.points_some", False)
    NONE = ("parallel.points_none", False)
    FREE = ("parallel.points_free", True)


@dataclass(frozen=True, eq=False, repr=False)
class PlatformPoints(Answer):
    """Places for angles of the motors; true if the rods meet in every row, iterable over them, of a batch over rows.

    Attributes:
        x: (*batch, 2, d) both places, equal ones where the rods just meet; NaN where there are none [m].
        free: (*batch,) whether any place of a circle or sphere will do, because ends of cranks coincide.
        legs: the rods.
    """

    x: Floats
    free: Booleans
    legs: LegEnds

    @property
    def count(self) -> Integers:
        """(*batch,) number of places: two or none."""
        return np.isfinite(self.x).all(axis=-1).sum(axis=-1)

    @cached_property
    def nearest(self) -> NearestLengths:
        """The nearest lengths of the rods with which they meet: of rows with places their own; and where they meet."""
        return self.legs.nearest()

    @property
    def status(self) -> PlatformPointsStatus:
        """Of all rows together."""
        meets = (self.count > 0) | self.free
        if meets.all():
            return PlatformPointsStatus.FREE if self.free.any() else PlatformPointsStatus.ALL
        return PlatformPointsStatus.SOME if meets.any() else PlatformPointsStatus.NONE

    def __bool__(self) -> bool:
        return self.status.succeeded

    def __len__(self) -> int:
        return int(self.count) if self.free.ndim == 0 else len(self.x)

    def __iter__(self) -> Iterator[Any]:
        if self.free.ndim == 0:
            return iter(self.x[: int(self.count)])
        return (PlatformPoints(self.x[k], self.free[k, ...], self.legs[k]) for k in range(len(self.x)))

    def __repr__(self) -> str:
        if self.free.ndim or not self.count:
            return on_screen(self.explain())
        head = (say("mobility.mode_head"), *(f"{axis} [m]" for axis in "xyz"[: self.x.shape[-1]]))
        rows = [(str(k + 1), *map(number, place.tolist())) for k, place in enumerate(self)]
        return "\n".join([on_screen(self.explain()), *table(head, rows)])

    def explain(self, language: str | None = None) -> str:
        """In how many rows the rods meet; of one row without places how far their lengths are off."""
        details: dict[str, object] = {
            "rows": self.free.size, "reached": int(((self.count > 0) | self.free).sum()), "free": int(self.free.sum())
        }  # fmt: skip
        status = self.status
        if status is PlatformPointsStatus.NONE:
            if self.free.ndim == 0:
                details |= self.nearest.details()
            else:
                status = PlatformPointsStatus.SOME
        return status.sentence(language, **details)

    def to_dict(self) -> dict[str, Any]:
        """Plain data; of one row without any the nearest lengths too."""
        found: dict[str, Any] = {
            "status": self.status.name.lower(),
            "x": self.x,
            "count": self.count,
            "free": self.free,
        }
        if self.free.ndim == 0 and self.status is PlatformPointsStatus.NONE:
            found["nearest"] = self.nearest.to_dict()
        return found
