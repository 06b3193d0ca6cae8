"""Which limit binds where: the intervals in which a coordinate moves with all that a limit allows."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from mafsil.arrays import Floats
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.messages import say
from mafsil.messages.tables import in_notebook, number, table
from mafsil.trajectory.tolerances import GIVEN

QUANTITIES = ("jerk", "acceleration", "velocity")
COLUMNS = ("coordinate", "begin", "end", "quantity", "limit")


@dataclass(frozen=True, slots=True)
class BindingLimit:
    """One limit that binds for a while.

    Attributes:
        coordinate: its index.
        begin, end: times [s].
        quantity: `velocity`, `acceleration` or `jerk`.
        limit: the bound that is reached.
    """

    coordinate: int
    begin: float
    end: float
    quantity: str
    limit: float


@dataclass(frozen=True, slots=True, repr=False)
class Bindings:
    """All limits that bind, by coordinate and time; a table when it is printed.

    Attributes:
        rows: one for each interval.
    """

    rows: tuple[BindingLimit, ...]

    def __iter__(self) -> Iterator[BindingLimit]:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def at(self, t: float) -> tuple[BindingLimit, ...]:
        """Those that bind at the time t [s]."""
        return tuple(row for row in self.rows if row.begin <= t <= row.end)

    def explain(self, language: str | None = None) -> str:
        """A sentence and a table: a row for each interval."""
        head = [say(f"jerk.column_{name}", language=language) for name in COLUMNS]
        cells = [
            [str(row.coordinate), number(row.begin), number(row.end), self._word(row, language), number(row.limit)]
            for row in self.rows
        ]
        return "\n".join([say("jerk.bindings", language=language, count=len(cells)), *table(head, cells, language)])

    def to_dict(self) -> dict[str, Any]:
        """Plain data: one record for each row."""
        return {"bindings": [asdict(row) for row in self.rows]}

    def __repr__(self) -> str:
        return self.explain()

    def _repr_html_(self) -> str:
        return in_notebook(self.explain())

    def _word(self, row: BindingLimit, language: str | None) -> str:
        return say(f"trajectory.{row.quantity}", language=language)


def bindings_of(begins: list[Floats], v: list[Floats], a: list[Floats], j: list[Floats], limits: Floats) -> Bindings:
    """The bindings of pieces of constant jerk.

    Args:
        begins: for each coordinate (pieces + 1,) times [s].
        v, a: for each coordinate (pieces + 1,) values at these times.
        j: for each coordinate (pieces,) jerks.
        limits: (n, 6).
    """
    rows: list[BindingLimit] = []
    for i, bounds in enumerate(limits):
        for k, jerk in enumerate(j[i]):
            begin, end = float(begins[i][k]), float(begins[i][k + 1])
            if end <= begin:
                continue
            values = (jerk, a[i][k : k + 2], v[i][k : k + 2])
            for quantity, value, pair in zip(QUANTITIES, values, (bounds[4:], bounds[2:4], bounds[:2]), strict=True):
                hit = _touch(np.asarray(value), pair)
                if hit is not None:
                    rows.append(BindingLimit(i, begin, end, quantity, hit))
    return Bindings(tuple(_join(rows)))


def _touch(value: Floats, pair: Floats) -> float | None:
    """The bound that the values keep to."""
    for bound in pair:
        if np.isfinite(bound) and (np.abs(value - bound) <= GIVEN * max(abs(bound), LEAST_DIVISOR)).all():
            return float(bound)
    return None


def _join(rows: list[BindingLimit]) -> Iterator[BindingLimit]:
    """Intervals of the same limit that follow each other as one."""
    last: BindingLimit | None = None
    for row in rows:
        same = last is not None and (row.coordinate, row.quantity, row.limit) == (
            last.coordinate,
            last.quantity,
            last.limit,
        )
        if last is not None and same and row.begin <= last.end:
            last = BindingLimit(last.coordinate, last.begin, row.end, last.quantity, last.limit)
            continue
        if last is not None:
            yield last
        last = row
    if last is not None:
        yield last
