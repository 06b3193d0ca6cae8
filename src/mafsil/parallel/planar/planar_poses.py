"""All poses of a planar platform as an answer: its assembly modes, or the sentence why there are none."""

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
from mafsil.parallel.platforms.nearest_lengths import LegEnds, NearestLengths


class PlanarPosesStatus(Status):
    """Whether the platform can be put together, and whether it stays movable then."""

    ALL = ("parallel.planar_all", True)
    SOME = ("parallel.planar_some", False)
    NONE = ("parallel.planar_none", False)
    MOVABLE = ("parallel.planar_movable", True)


@dataclass(frozen=True, eq=False, repr=False)
class PlanarPoses(Answer, data="x count there multiplicity movable error"):
    """All real poses of a planar platform; true if every row has one, iterable over the poses, of a batch over rows.

    Attributes:
        x: (*batch, n, 3) isolated poses (x, y, phi), by ascending phi in (-pi, pi]; of a batch NaN beyond their number,
            where `there` is false [m, rad].
        count: (*batch,) number of them, that differ.
        multiplicity: (*batch, n) of each: 1 of a simple pose, 2 of a double one; zero beyond their number.
        movable: (*batch,) whether there is a curve of poses besides: the platform moves with its actuators locked.
        error: largest error of a length [m].
        legs: whose poses they are.
    """

    x: Floats
    count: Integers
    multiplicity: Integers
    movable: Booleans
    error: float
    legs: LegEnds

    @property
    def there(self) -> Booleans:
        """(*batch, n) which places of `x` hold a pose."""
        return np.asarray(np.arange(self.x.shape[-2]) < self.count[..., None], dtype=np.bool_)

    @cached_property
    def nearest(self) -> NearestLengths:
        """The nearest lengths that the platform can have: of rows with a pose their own, else how far they are off."""
        first = self.x[..., 0, :] if self.x.shape[-2] else np.zeros((*self.count.shape, 3))
        return self.legs.nearest_unless(np.asarray(self.count > 0), first)

    @property
    def missing(self) -> Floats:
        """(*batch,) distance of the lengths from the nearest ones that a pose has; zero where there is a pose [m]."""
        return self.nearest.distance

    @property
    def status(self) -> PlanarPosesStatus:
        """Of all rows together."""
        if self.movable.any():
            return PlanarPosesStatus.MOVABLE
        if self.count.all():
            return PlanarPosesStatus.ALL
        return PlanarPosesStatus.SOME if self.count.any() else PlanarPosesStatus.NONE

    def __len__(self) -> int:
        return int(self.count) if self.count.ndim == 0 else int(self.count.shape[0])

    def __iter__(self) -> Iterator[Any]:
        if self.count.ndim == 0:
            return iter(self.x[: int(self.count)])
        return (self[k] for k in range(len(self)))

    def __getitem__(self, row: int) -> PlanarPoses:
        """The poses of one row of a batch."""
        return PlanarPoses(
            self.x[row], self.count[row, ...], self.multiplicity[row], self.movable[row, ...], self.error,
            self.legs[row],
        )  # fmt: skip

    def _table(self) -> list[str]:
        if self.count.ndim:
            return []
        head = (say("mobility.mode_head"), "x [m]", "y [m]", "phi [deg]", say("parallel.multiplicity_head"))
        rows = [
            (str(k + 1), *map(number, [*x[:2].tolist(), float(np.degrees(x[2]))]), str(self.multiplicity[k]))
            for k, x in enumerate(self)
        ]
        return table(head, rows) if rows else []

    def explain(self, language: str | None = None) -> str:
        """How many poses there are, and how exactly the lengths fit; of one row without any how far they are off."""
        if self.status is PlanarPosesStatus.NONE and self.count.ndim == 0:
            return self.status.sentence(language, **self.nearest.details())
        status = PlanarPosesStatus.SOME if self.status is PlanarPosesStatus.NONE else self.status
        low, high = int(self.count.min(initial=99)), int(self.count.max(initial=0))
        return status.sentence(
            language, count=str(high) if low >= high else f"{low}-{high}", most=high, rows=self.count.size,
            reached=int((self.count > 0).sum()), movable=int(self.movable.sum()), error=self.error,
        )  # fmt: skip

    def to_dict(self) -> dict[str, Any]:
        """Plain data; if rows have no pose, the nearest lengths too."""
        found = Answer.to_dict(self)
        if not (self.count.all() or self.movable.any()):
            found["nearest"] = self.nearest.to_dict()
        return found
