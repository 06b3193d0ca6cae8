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
from mafsil.messages.tables import number, table
from mafsil.parallel.planar.planar_poses import STARTS, nearest_places
from mafsil.parallel.platforms.nearest_lengths import LegEnds, NearestLengths


class PlatformPointsStatus(Status):
    """Whether the rods meet."""

    ALL = ("parallel.points_all", True)
    SOME = ("parallel.points_some", False)
    NONE = ("parallel.points_none", False)
    FREE = ("parallel.points_free", True)


@dataclass(frozen=True, eq=False, repr=False)
class PlatformPoints(Answer, data="x count free missing"):
    """Places for angles of the motors; true if the rods meet in every row, iterable over them, of a batch over rows.

    Attributes:
        ends: (*batch, 2, d) both places, equal ones where the rods just meet; of no meaning elsewhere [m].
        meets: (*batch,) whether the rods meet.
        free: (*batch,) whether any place of a circle or sphere will do, because ends of cranks coincide: `ends` holds
            two that are opposite.
        legs: the rods.
    """

    ends: Floats
    meets: Booleans
    free: Booleans
    legs: LegEnds

    @cached_property
    def x(self) -> Floats:
        """(*batch, 2, d) both places; where the rods do not meet twice the point that they come nearest to [m]."""
        if self.meets.all():
            return self.ends
        found = self.ends.copy()
        missed = ~self.meets
        if self.legs.lengths.shape[-1] > 2:
            found[missed] = nearest_places(self.legs.base[missed], self.legs.lengths[missed])[:, None]
        return found

    @property
    def count(self) -> Integers:
        """(*batch,) number of places: two or none, none where any of a circle will do."""
        return np.where(self.meets & ~self.free, 2, 0)

    @cached_property
    def nearest(self) -> NearestLengths:
        """The nearest lengths of the rods with which they meet, and where: of rows that meet their own."""
        place = self.x[..., 0, :]
        apart = np.linalg.norm(place[..., None, :] - self.legs.base, axis=-1)
        misfit = np.where(self.meets[..., None], 0.0, apart - self.legs.lengths)
        return NearestLengths(place, misfit, STARTS if self.legs.lengths.shape[-1] > 2 else 1)

    @property
    def missing(self) -> Floats:
        """(*batch,) distance of the rods' lengths from the nearest with which they meet; zero where they do [m]."""
        return self.nearest.distance

    @property
    def status(self) -> PlatformPointsStatus:
        """Of all rows together."""
        meets = self.meets
        if meets.all():
            return PlatformPointsStatus.FREE if self.free.any() else PlatformPointsStatus.ALL
        return PlatformPointsStatus.SOME if meets.any() else PlatformPointsStatus.NONE

    def __len__(self) -> int:
        return int(self.count) if self.free.ndim == 0 else len(self.ends)

    def __iter__(self) -> Iterator[Any]:
        if self.free.ndim == 0:
            return iter(self.x[: int(self.count)])
        return (self[k] for k in range(len(self.ends)))

    def __getitem__(self, row: int) -> PlatformPoints:
        """The places of one row of a batch."""
        return PlatformPoints(self.ends[row], self.meets[row, ...], self.free[row, ...], self.legs[row])

    def _table(self) -> list[str]:
        if self.free.ndim or not self.count:
            return []
        head = (say("mobility.mode_head"), *(f"{axis} [m]" for axis in "xyz"[: self.x.shape[-1]]))
        rows = [(str(k + 1), *map(number, place.tolist())) for k, place in enumerate(self)]
        return table(head, rows)

    def explain(self, language: str | None = None) -> str:
        """In how many rows the rods meet; of one row without places how far their lengths are off."""
        details: dict[str, object] = {
            "rows": self.free.size, "reached": int(self.meets.sum()), "free": int(self.free.sum())
        }  # fmt: skip
        status = self.status
        if status is PlatformPointsStatus.NONE:
            if self.free.ndim == 0:
                details |= self.nearest.details()
            else:
                status = PlatformPointsStatus.SOME
        if status is PlatformPointsStatus.SOME:
            missed = self.missing[~self.meets]
            details |= {"least": float(missed.min(initial=np.inf)), "most": float(missed.max(initial=0.0))}
        return status.sentence(language, **details)

    def to_dict(self) -> dict[str, Any]:
        """Plain data; of one row without any places the nearest lengths too."""
        found = Answer.to_dict(self)
        if self.free.ndim == 0 and self.status is PlatformPointsStatus.NONE:
            found["nearest"] = self.nearest.to_dict()
        return found
