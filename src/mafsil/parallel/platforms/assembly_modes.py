"""Assembly modes: all poses that a platform can be put together in for given lengths of its legs."""

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


class AssemblyModesStatus(Status):
    """Whether all poses were found, and whether there are real ones."""

    ALL = ("parallel.modes_all", True)
    SOME = ("parallel.modes_some", False)
    NONE = ("parallel.modes_none", False)
    INCOMPLETE = ("parallel.modes_incomplete", True)
    INCOMPLETE_NONE = ("parallel.modes_incomplete_none", False)
    NOT_ISOLATED = ("parallel.modes_not_isolated", False)
    MOVABLE = ("parallel.modes_movable", True)
    ON_SET = ("parallel.modes_on_set", False)


@dataclass(frozen=True, eq=False, repr=False)
class PlatformModes(Answer, data="T count finite there expected error orientation"):
    """All poses of a platform for given lengths; true if there is a real one, iterable over the real ones.

    Of a batch: true if each row has one, iterable over the rows.

    Attributes:
        T: (*batch, n, 4, 4) real poses in {s}, higher ones first; of a batch NaN beyond their number, where `there` is
            false.
        count: (*batch,) number of real poses that differ.
        finite: (*batch,) number of isolated poses that differ, complex ones included.
        paths: (*batch,) the same, double ones counted twice, and ends of paths on sets of poses.
        on_set: (*batch,) number of paths that ended on sets of poses, along which the legs keep their lengths.
        through: (*batch, 4, 4) a real pose on such a set; NaN where there is none or none was found.
        expected: number of isolated poses of this geometry with general lengths; 40 if general.
        error: largest error of a leg over all real poses [m].
        orientation: (*batch, n) sign of det G of each, zero beyond their number: from + to - a platform passes a
            singular pose.
        legs: whose modes they are.
    """

    T: Floats
    count: Integers
    finite: Integers
    paths: Integers
    on_set: Integers
    through: Floats
    expected: int
    error: float
    orientation: Floats
    legs: LegEnds

    @property
    def there(self) -> Booleans:
        """(*batch, n) which places of `T` hold a pose."""
        return np.asarray(np.arange(self.T.shape[-3]) < self.count[..., None], dtype=np.bool_)

    @cached_property
    def nearest(self) -> NearestLengths:
        """The nearest lengths that the platform can have: of rows with a pose their own, else how far they are off."""
        first = self.T[..., 0, :, :] if self.T.shape[-3] else np.zeros((*self.count.shape, 4, 4))
        return self.legs.nearest_unless(np.asarray(self.count > 0), first)

    @property
    def missing(self) -> Floats:
        """(*batch,) distance of the lengths from the nearest ones that a pose has; zero where there is a pose [m]."""
        return self.nearest.distance

    @property
    def movable(self) -> Booleans:
        """(*batch,) whether a set of real poses was found: the platform moves with its legs locked."""
        return np.asarray(np.isfinite(self.through[..., 0, 0]), dtype=np.bool_)

    @property
    def status(self) -> AssemblyModesStatus:
        """Of all rows together."""
        complete, some = bool((self.paths >= self.expected).all()), bool(self.count.all())
        if not self.expected:
            return AssemblyModesStatus.NOT_ISOLATED
        if self.on_set.any():
            return AssemblyModesStatus.MOVABLE if self.movable.any() else AssemblyModesStatus.ON_SET
        if complete and self.count.any():
            return AssemblyModesStatus.ALL if some else AssemblyModesStatus.SOME
        if complete:
            return AssemblyModesStatus.NONE if self.count.size else AssemblyModesStatus.ALL
        return AssemblyModesStatus.INCOMPLETE if some else AssemblyModesStatus.INCOMPLETE_NONE

    def __bool__(self) -> bool:
        return self.status.succeeded or (self.status is AssemblyModesStatus.ON_SET and bool(self.count.all()))

    def __len__(self) -> int:
        return int(self.count) if self.count.ndim == 0 else int(self.count.shape[0])

    def __iter__(self) -> Iterator[Any]:
        if self.count.ndim == 0:
            return iter(self.T[: int(self.count)])
        return (self[k] for k in range(len(self)))

    def __getitem__(self, row: int) -> PlatformModes:
        """The modes of one row of a batch."""
        return PlatformModes(
            self.T[row], self.count[row, ...], self.finite[row, ...], self.paths[row, ...],
            self.on_set[row, ...], self.through[row], self.expected, self.error, self.orientation[row], self.legs[row],
        )  # fmt: skip

    def _table(self) -> list[str]:
        if self.count.ndim:
            return []
        head = (say("mobility.mode_head"), "x [m]", "y [m]", "z [m]", "det G")
        rows = [
            (str(k + 1), *map(number, T[:3, 3].tolist()), "+" if self.orientation[k] > 0 else "-")
            for k, T in enumerate(self)
        ]
        return table(head, rows) if rows else []

    def explain(self, language: str | None = None) -> str:
        """How many poses there are, real and complex, how exactly the legs fit; of one row without any how far off."""
        real, finite, status = self.count.reshape(-1), self.finite.reshape(-1), self.status
        if status is AssemblyModesStatus.NONE and self.count.ndim:
            status = AssemblyModesStatus.SOME
        sentence = status.sentence(
            language, real=_span(real), finite=_span(finite), expected=self.expected, error=self.error,
            missing=int((self.expected - self.paths).max(initial=0)), rows=self.count.size,
            reached=int((real > 0).sum()), most=int(real.max(initial=0)), on_set=int(self.on_set.sum()),
            movable=int(self.movable.sum()), place=self._place(),
        )  # fmt: skip
        if self.count.ndim or self.count or not self.expected or self.on_set:
            return sentence
        return sentence + say("parallel.nearest_lengths", language=language, **self.nearest.details())

    def _place(self) -> str:
        """Where the platform stands in the first pose on a set of real ones."""
        places = self.through[..., :3, 3].reshape(-1, 3)[self.movable.reshape(-1)]
        return ", ".join(map(number, places[0].tolist())) if len(places) else "-"

    def to_dict(self) -> dict[str, Any]:
        """Plain data; if rows have no pose, the nearest lengths too."""
        found = Answer.to_dict(self)
        if self.on_set.any():
            found |= {"on_set": self.on_set, "movable": self.movable, "through": self.through}
        elif not self.count.all() and self.expected:
            found["nearest"] = self.nearest.to_dict()
        return found


def _span(counts: Integers) -> str:
    if not counts.size:
        return "0"
    low, high = int(counts.min()), int(counts.max())
    return str(low) if low == high else f"{low}-{high}"
