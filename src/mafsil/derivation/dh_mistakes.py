"""The usual mistakes in a Denavit-Hartenberg table, each as the table that it would have been made from."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import degrees, pi, radians

import numpy as np

from mafsil.derivation.dh_truth import ANGLES, FIELDS, Field, Rows, Solved, value_of
from mafsil.derivation.review import Finding, Mistake, shown
from mafsil.derivation.tolerances import SAME
from mafsil.model.denavit_hartenberg import Convention, DHRow

_COST = {
    Mistake.CONVENTION: 0.5,
    Mistake.SIGN: 1.0, Mistake.ANGLES_SWAPPED: 1.0, Mistake.LENGTHS_SWAPPED: 1.0, Mistake.DEGREES: 1.0,
    Mistake.OFFSET: 1.2, Mistake.ROW_SHIFTED: 1.4, Mistake.KIND: 1.4, Mistake.VALUE: 2.0,
}  # fmt: skip
"""How unlikely a mistake is, besides what it changes: typing any other value explains everything and is asked last."""
_WHOLE = 0.1
"""Added to mistakes of whole columns: one row is less than all."""


@dataclass(frozen=True, slots=True)
class Repair:
    """A changed table and the finding that it proves if the change makes it right.

    Attributes:
        rows, convention: the changed table.
        finding: what was changed and why.
        place: the row changed, from 0; -1 for the whole table.
    """

    rows: Rows
    convention: Convention
    finding: Finding
    place: int

    @property
    def cost(self) -> float:
        """How unlikely the mistake is."""
        return _COST[self.finding.mistake] + (_WHOLE if self.place < 0 else 0.0)


def whole_table(rows: Rows, convention: Convention) -> Iterator[Repair]:
    """Mistakes that concern every row."""
    choices: tuple[tuple[Field, ...], ...] = (("alpha",), ("theta",), ("alpha", "theta"))
    for fields in choices:
        typed = [value for row in rows for value in (value_of(row, f) for f in fields) if value]
        if len(typed) > 1:
            in_radians = tuple(replace(r, **{f: radians(getattr(r, f)) for f in fields}) for r in rows)
            yield Repair(in_radians, convention, Finding(Mistake.DEGREES, entry=", ".join(fields)), -1)
    for field in ("a", "alpha"):
        for step in (1, -1):
            values = np.roll([getattr(row, field) for row in rows], step)
            shifted = tuple(replace(row, **{field: float(x)}) for row, x in zip(rows, values, strict=True))
            if shifted != rows:
                before, after = (_column(table, field) for table in (rows, shifted))
                yield Repair(shifted, convention, Finding(Mistake.ROW_SHIFTED, None, None, field, before, after), -1)


def other_convention(rows: Rows, convention: Convention) -> Repair:
    """The same rows meant in the other convention."""
    other = Convention.CLASSIC if convention is Convention.MODIFIED else Convention.MODIFIED
    return Repair(rows, other, Finding(Mistake.CONVENTION, given=convention.value, expected=other.value), -1)


def single_rows(rows: Rows, convention: Convention) -> Iterator[Repair]:
    """Mistakes in one row."""
    for i, row in enumerate(rows):
        for mistake, fields, changed in _changes(row):
            yield _in_row(rows, convention, i, mistake, fields, changed)


def values(rows: Rows, convention: Convention, solved: list[Solved]) -> Iterator[Repair]:
    """Single values typed wrong."""
    for i, field, value in solved:
        row = rows[i]
        changed = replace(row, **{field: getattr(row, field) + value - value_of(row, field)})
        yield _in_row(rows, convention, i, Mistake.VALUE, (field,), changed)


def entry_text(row: DHRow, field: Field) -> str:
    """An entry for people: lengths [m], angles in radians with the degrees beside them."""
    value = float(getattr(row, field))
    if field not in ANGLES or not value:
        return shown(value)
    return f"{shown(value)} ({shown(round(degrees(value), 9))}°)"


def _in_row(
    rows: Rows, convention: Convention, i: int, mistake: Mistake, fields: tuple[Field, ...], changed: DHRow
) -> Repair:
    before, after = (", ".join(entry_text(row, field) for field in fields) for row in (rows[i], changed))
    entry = ", ".join(fields) or "kind"
    if not fields:
        before, after = rows[i].kind, changed.kind
    finding = Finding(mistake, row=i + 1, entry=entry, given=before, expected=after)
    return Repair((*rows[:i], changed, *rows[i + 1 :]), convention, finding, i)


def _column(rows: Rows, field: Field) -> str:
    return "(" + ", ".join(entry_text(row, field) for row in rows) + ")"


def _changes(row: DHRow) -> Iterator[tuple[Mistake, tuple[Field, ...], DHRow]]:
    for field in FIELDS:
        # 270 degrees are half a turn too many, not minus 270.
        if getattr(row, field) and not (field in ANGLES and pi + SAME < abs(getattr(row, field)) < 2 * pi):
            yield Mistake.SIGN, (field,), replace(row, **{field: -getattr(row, field)})
    if row.alpha != row.theta:
        yield Mistake.ANGLES_SWAPPED, ("alpha", "theta"), replace(row, alpha=row.theta, theta=row.alpha)
    if row.a != row.d:
        yield Mistake.LENGTHS_SWAPPED, ("a", "d"), replace(row, a=row.d, d=row.a)
    for field in ("alpha", "theta"):
        if abs(getattr(row, field)) > 2 * pi:
            yield Mistake.DEGREES, (field,), replace(row, **{field: radians(getattr(row, field))})
    for turn in (pi / 2, -pi / 2, pi):
        for field in ("theta", "alpha"):
            yield Mistake.OFFSET, (field,), replace(row, **{field: _within_half_turn(getattr(row, field) + turn)})
    yield Mistake.KIND, (), replace(row, kind="P" if row.kind == "R" else "R")


def _within_half_turn(angle: float) -> float:
    if abs(angle) <= pi + SAME:
        return angle
    return angle - 2 * pi * round(angle / (2 * pi))
