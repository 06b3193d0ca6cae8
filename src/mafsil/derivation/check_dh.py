"""A student's Denavit-Hartenberg table against the robot: which entry is wrong, and by which slip.

A table is right if it describes the same arm, whatever frames were chosen; it need not be our table. A wrong one is
repaired by every usual slip in turn, alone and in pairs, until it is right: the repair that succeeds is the finding.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import combinations
from math import pi, radians
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, PoseMatrix
from mafsil.derivation.review import Finding, Review, Slip, shown
from mafsil.derivation.same_arm import same_screws
from mafsil.errors import InputError
from mafsil.model import Mechanism
from mafsil.model.denavit_hartenberg import Convention, DHRow, convention_of, mechanism_from_dh
from mafsil.model.dh_frames import tables_of_screws
from mafsil.model.dh_from_axes import classic_from_modified
from mafsil.model.exponentials import screws
from mafsil.model.loading import RobotLike, as_mechanism
from mafsil.model.placement import checked_pose

Rows: TypeAlias = tuple[DHRow, ...]
Field: TypeAlias = Literal["a", "alpha", "d", "theta"]


@dataclass(frozen=True, slots=True)
class _Repair:
    """A changed table and the finding that it proves if the change makes it right."""

    rows: Rows
    convention: Convention
    finding: Finding
    place: int


class _Truth:
    """The robot's axes, and whether a table has the same."""

    def __init__(
        self, mechanism: Mechanism, base: PoseMatrix | None, tool: PoseMatrix | None, tolerance: float
    ) -> None:
        self.S, _, self.home = screws(mechanism)
        self.base, self.tool, self.tolerance = base, tool, tolerance

    def agrees(self, rows: Rows, convention: Convention) -> bool:
        """Whether the table is the robot."""
        S, home = _axes(rows, convention, np.eye(4) if self.base is None else self.base)
        B = same_screws(S, self.S, base_free=self.base is None, tolerance=self.tolerance)
        if B is None:
            return False
        return self.tool is None or float(np.abs(B @ home @ self.tool - self.home).max()) <= self.tolerance


def _axes(rows: Rows, convention: Convention, base: PoseMatrix) -> tuple[Floats, PoseMatrix]:
    """(n, 6) screw axes at q = 0 and the pose of {n}."""
    T, axes = base, np.zeros((len(rows), 6))
    for axis, row in zip(axes, rows, strict=True):
        before, T = T, T @ _transform(row, convention)
        frame = T if convention is Convention.MODIFIED else before
        z = frame[:3, 2]
        if row.kind == "R":
            axis[:3], axis[3:] = z, np.cross(frame[:3, 3], z)
        else:
            axis[3:] = z
    return axes, T


@lru_cache(maxsize=4096)
def _transform(row: DHRow, convention: Convention) -> PoseMatrix:
    return row.transform(convention)


def check_dh(
    rows: Sequence[DHRow],
    mechanism: RobotLike,
    convention: Convention | str = "modified",
    *,
    base: ArrayLike | None = None,
    tool: ArrayLike | None = None,
    tolerance: float = 1e-6,
) -> Review:
    """Whether a table describes the robot; if not, where it is wrong and why.

    Args:
        rows: the table, as many rows as the chain has joints.
        mechanism: the robot.
        convention: in which the table is meant to be.
        base: (4, 4) pose of {0} in {s}; any if None.
        tool: (4, 4) pose of the tip in {n}; any if None.
        tolerance: of directions and of lengths [m].

    Raises:
        InputError: another number of rows.
        ModelError: a row that is neither R nor P or is not finite, an unknown convention, a pose that is none.
    """
    mechanism = as_mechanism(mechanism)
    wanted = convention_of(convention)
    mechanism_from_dh(rows, wanted)
    given: Rows = tuple(rows)
    truth = _Truth(
        mechanism,
        None if base is None else checked_pose("base", base),
        None if tool is None else checked_pose("tool", tool),
        tolerance,
    )
    if len(given) != len(truth.S):
        raise InputError("derivation.rows", got=len(given), expected=len(truth.S))
    if truth.agrees(given, wanted):
        return Review()
    for repair in _whole_table(given, wanted):
        if truth.agrees(repair.rows, repair.convention):
            return Review((repair.finding,))
    single = list(_entries(given, wanted))
    for repair in single:
        if truth.agrees(repair.rows, wanted):
            return Review((repair.finding,))
    for first, second in combinations(single, 2):
        if first.place == second.place:
            continue
        both = tuple(second.rows[i] if i == second.place else row for i, row in enumerate(first.rows))
        if truth.agrees(both, wanted):
            return Review((first.finding, second.finding))
    return _differences(given, truth, wanted)


def _whole_table(rows: Rows, convention: Convention) -> Iterator[_Repair]:
    """Slips that concern every row."""
    other = Convention.CLASSIC if convention is Convention.MODIFIED else Convention.MODIFIED
    for fields in (("alpha", "theta"), ("alpha",), ("theta",)):
        in_radians = tuple(replace(r, **{f: radians(getattr(r, f)) for f in fields}) for r in rows)
        yield _Repair(in_radians, convention, Finding(Slip.DEGREES, entry=", ".join(fields)), -1)
    yield _Repair(rows, other, Finding(Slip.CONVENTION), -1)
    for field in ("a", "alpha"):
        for step in (1, -1):
            values = np.roll([getattr(row, field) for row in rows], step)
            shifted = tuple(replace(row, **{field: float(x)}) for row, x in zip(rows, values, strict=True))
            yield _Repair(shifted, convention, Finding(Slip.ROW_SHIFTED, entry=field), -1)


def _entries(rows: Rows, convention: Convention) -> Iterator[_Repair]:
    """Slips in one row, the likely ones first."""
    for i, row in enumerate(rows):
        for slip, entry, changed in _changes(row):
            single = entry in ("a", "alpha", "d", "theta")
            given, expected = (shown(getattr(r, entry)) if single else "" for r in (row, changed))
            finding = Finding(slip, row=i + 1, entry=entry, given=given, expected=expected)
            yield _Repair((*rows[:i], changed, *rows[i + 1 :]), convention, finding, i)


def _changes(row: DHRow) -> Iterator[tuple[Slip, str, DHRow]]:
    signed: tuple[Field, ...] = ("alpha", "a", "d", "theta")
    for field in signed:
        if getattr(row, field):
            yield Slip.SIGN, field, replace(row, **{field: -getattr(row, field)})
    if row.alpha != row.theta:
        yield Slip.ANGLES_SWAPPED, "alpha, theta", replace(row, alpha=row.theta, theta=row.alpha)
    if row.a != row.d:
        yield Slip.LENGTHS_SWAPPED, "a, d", replace(row, a=row.d, d=row.a)
    for field in ("alpha", "theta"):
        if abs(getattr(row, field)) > 2 * pi:
            yield Slip.DEGREES, field, replace(row, **{field: radians(getattr(row, field))})
    for turn in (pi / 2, -pi / 2, pi):
        yield Slip.OFFSET, "theta", replace(row, theta=row.theta + turn)
        yield Slip.OFFSET, "alpha", replace(row, alpha=row.alpha + turn)
    yield Slip.KIND, "kind", replace(row, kind="P" if row.kind == "R" else "R")


def _differences(rows: Rows, truth: _Truth, convention: Convention) -> Review:
    """Entries that differ from the right table that is nearest to the given one; one wrong value is thereby named."""
    tables = tables_of_screws(truth.S, truth.home)
    if convention is Convention.CLASSIC:
        tables = (classic_from_modified(table) for table in tables)
    options = [list(_differing(rows, table.rows, truth.tolerance)) for table in tables]
    findings = tuple(min(options, key=len))
    return Review(findings, proven=False)


def _differing(rows: Rows, right: Rows, tolerance: float) -> Iterator[Finding]:
    for i, (row, other) in enumerate(zip(rows, right, strict=True), start=1):
        if row.kind != other.kind:
            yield Finding(Slip.KIND, row=i, entry="kind", given=row.kind, expected=other.kind)
        for field in ("alpha", "a", "d", "theta"):
            x, y = float(getattr(row, field)), float(getattr(other, field))
            apart = abs(np.angle(np.exp(1j * (x - y)))) if field in ("alpha", "theta") else abs(x - y)
            if apart > tolerance:
                yield Finding(Slip.VALUE, row=i, entry=field, given=shown(x), expected=shown(y))
