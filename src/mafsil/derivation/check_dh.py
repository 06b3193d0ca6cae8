"""A student's Denavit-Hartenberg table, or list of screw axes, against the robot: what is wrong, and by which mistake.

A table is right if it describes the same arm, whatever frames were chosen; it need not be our table. A wrong one is
repaired by every usual mistake in turn, and by any other single value. Of all repairs that make it right the one that
changes least is the finding: the one that leads nearest to a table with our own frames, then the likeliest.

The usual mistakes in a Denavit-Hartenberg table, each as the table that it would have been made from.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from math import degrees, pi, radians
from typing import Literal, TypeAlias
from warnings import catch_warnings

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, Vector6, as_batch, not_negative
from mafsil.derivation.review import Finding, Mistake, Review, shown
from mafsil.derivation.same_arm import (
    ANGLES,
    FIELDS,
    Field,
    Rows,
    Solved,
    Truth,
    base_between,
    differing,
    distance,
    misfit,
    value_of,
)
from mafsil.derivation.tolerances import SAME
from mafsil.errors import InputError, InputWarning
from mafsil.model.denavit_hartenberg import Convention, DHRow, DHRowLike, convention_of, dh_rows
from mafsil.model.dh_from_axes import screws
from mafsil.model.loading import RobotLike, as_mechanism
from mafsil.model.placement import checked_pose

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


_MOST_PAIRS = 30_000
_Named: TypeAlias = tuple[Repair, tuple[Finding, ...]]
"""A repair, or two in one, and what it finds."""


def check_dh(
    rows: Sequence[DHRowLike],
    mechanism: RobotLike,
    convention: Convention | str = "modified",
    *,
    base: ArrayLike | None = None,
    tool: ArrayLike | None = None,
    tolerance: float = 1e-6,
    columns: Sequence[str] | None = None,
    degrees: bool = False,
) -> Review:
    """Whether a table describes the robot; if not, where it is wrong and why.

    Args:
        rows: the table, one for each joint of the chain: `DHRow`, plain numbers or mappings, see `dh_rows`.
        mechanism: a Robot, a Mechanism, a name of the library or a path.
        convention: in which the table is meant to be.
        base: (4, 4) pose of {0} in {s}; any if None.
        tool: (4, 4) pose of the tip in {n}; any if None.
        tolerance: of directions and of lengths [m].
        columns, degrees: of plain rows, see `dh_rows`.

    Raises:
        InputError: another number of rows, or a row that cannot be read.
        ModelError: a row that is neither R nor P or is not finite, an unknown convention, a pose that is none.
    """
    described = as_mechanism(mechanism)
    tolerance = not_negative("tolerance", tolerance)
    requested = convention_of(convention)
    with catch_warnings(action="ignore", category=InputWarning):
        # Degrees taken for radians are a finding here.
        given: Rows = dh_rows(rows, columns=columns, degrees=degrees)
    truth = Truth(
        described,
        None if base is None else checked_pose("base", base),
        None if tool is None else checked_pose("tool", tool),
        tolerance,
    )
    if len(given) != len(truth.S):
        raise InputError("derivation.rows", got=len(given), expected=len(truth.S))
    if truth.agreeing([given], requested)[0]:
        return Review()
    other = other_convention(given, requested)
    if truth.agreeing([given], other.convention)[0]:
        return Review((other.finding,))
    found = _repair(given, requested, truth)
    if found is None:
        beside = _repair(given, other.convention, truth, pairs=False)
        found = None if beside is None else replace(beside, findings=(other.finding, *beside.findings))
    return _differences(given, truth, requested) if found is None else found


def _repair(rows: Rows, convention: Convention, truth: Truth, *, pairs: bool = True) -> Review | None:
    """The smallest repair: of one mistake, else of two."""
    single = list(single_rows(rows, convention))
    typed = values(rows, convention, truth.solve_entries(rows, convention))
    alone = [(repair, (repair.finding,)) for repair in (*single, *whole_table(rows, convention), *typed)]
    best = _smallest(alone, convention, truth)
    if best is not None or not pairs:
        return best
    return _smallest([*_pairs(single), *_degrees_and_more(rows, convention)], convention, truth)


def _degrees_and_more(rows: Rows, convention: Convention) -> Iterator[_Named]:
    """Degrees everywhere, and a mistake in one row besides."""
    for whole in whole_table(rows, convention):
        if whole.finding.mistake is Mistake.DEGREES:
            for repair in single_rows(whole.rows, convention):
                yield repair, (whole.finding, repair.finding)


def _smallest(repairs: list[_Named], convention: Convention, truth: Truth) -> Review | None:
    """Of the repairs that make the table right: nearest to our own tables, then the likeliest mistake."""
    agreeing = truth.agreeing([repair.rows for repair, _ in repairs], convention)
    right = [named for named, fits in zip(repairs, agreeing, strict=True) if fits]
    if not right:
        return None
    own = truth.tables(convention)
    sizes = [tuple(distance(repair.rows, tables, truth.tolerance) for tables in (own, own[:1])) for repair, _ in right]
    order = sorted(range(len(right)), key=lambda k: (*sizes[k], right[k][0].cost))
    first, findings = right[order[0]]
    return Review(
        findings, others=tuple(_others(first, [right[k] for k in order[1:] if sizes[k][0] == sizes[order[0]][0]]))
    )


def _others(first: Repair, rivals: list[_Named]) -> Iterator[Finding]:
    """Single mistakes that explain the table as well, by another table; two at most."""
    seen = [first.rows]
    for repair, findings in rivals:
        if len(findings) == 1 and len(seen) < 3 and all(differing(repair.rows, rows, SAME) for rows in seen):
            seen.append(repair.rows)
            yield findings[0]


def _pairs(single: list[Repair]) -> Iterator[_Named]:
    """Two mistakes in two rows, the likely ones first."""
    count = 0
    for first, second in combinations(sorted(single, key=lambda repair: repair.cost), 2):
        if first.place == second.place:
            continue
        if (count := count + 1) > _MOST_PAIRS:
            return
        first, second = sorted((first, second), key=lambda repair: repair.place)
        rows = tuple(second.rows[i] if i == second.place else row for i, row in enumerate(first.rows))
        worse = max(first, second, key=lambda repair: repair.cost)
        yield Repair(rows, first.convention, worse.finding, worse.place), (first.finding, second.finding)


def _differences(rows: Rows, truth: Truth, convention: Convention) -> Review:
    """Entries that differ from the right table that is nearest to the given one: not proven, more than one mistake."""
    tables = truth.tables(convention)
    nearest = min(tables, key=lambda table: len(differing(rows, table, truth.tolerance)))
    findings: list[Finding] = []
    for i, field in differing(rows, nearest, truth.tolerance):
        if field == "kind":
            findings.append(Finding(Mistake.KIND, i + 1, None, field, rows[i].kind, nearest[i].kind))
        else:
            texts = (entry_text(row[i], field) for row in (rows, nearest))
            findings.append(Finding(Mistake.VALUE, i + 1, None, field, *texts))
    return Review(tuple(findings), proven=False)


def check_screws(
    S: ArrayLike, mechanism: RobotLike, form: Literal["space", "body"] = "space", *, tolerance: float = 1e-6
) -> Review:
    """Whether screw axes are those of the robot at q = 0; if not, which are wrong and why.

    Args:
        S: (n, 6) axes (omega, v), rows as the joints from the base.
        mechanism: a Robot, a Mechanism, a name of the library or a path.
        form: `space` if the axes are given in {s}, `body` if in the tip frame.
        tolerance: of every entry.

    Raises:
        InputError: not (n, 6) finite numbers, or an unknown form.
    """
    tolerance = not_negative("tolerance", tolerance)
    if form not in ("space", "body"):
        raise InputError("derivation.form", value=form, known="space, body")
    space, body, _ = screws(as_mechanism(mechanism))
    truth, other = (space, body) if form == "space" else (body, space)
    given = as_batch("S", S, truth.shape, finite=True)
    if given.ndim != 2:
        raise InputError("input.shape", name="S", expected=truth.shape, got=given.shape, hint="")
    if np.abs(given - truth).max() <= tolerance:
        return Review()
    if np.abs(given - other).max() <= tolerance:
        return Review((Finding(Mistake.FRAME),))
    if np.abs(np.roll(given, 3, axis=1) - truth).max() <= tolerance:
        return Review((Finding(Mistake.PARTS_SWAPPED),))
    findings = [
        _finding(i, given[i], truth, other, tolerance)
        for i in range(len(truth))
        if np.abs(given[i] - truth[i]).max() > tolerance
    ]
    proven = all(finding.mistake is not Mistake.VALUE for finding in findings)
    if not proven and _is_moved(given, truth, tolerance):
        return Review((Finding(Mistake.OTHER_BASE),))
    return Review(tuple(findings), proven=proven)


def _is_moved(given: Floats, truth: Floats, tolerance: float) -> bool:
    """Whether one change of frame makes all axes right."""
    B = base_between(given[None], truth)
    return float(np.abs(misfit(given[None], truth, B)).max(initial=0.0)) <= tolerance


def _finding(i: int, S: Vector6, truth: Floats, other: Floats, tolerance: float) -> Finding:
    for mistake, entry, right in _mistaken(i, truth, other):
        if np.abs(S - right).max() <= tolerance:
            return _name(mistake, i, entry, S, truth[i])
    wrong = truth[i]
    if np.abs(S[:3] - wrong[:3]).max() > tolerance:
        length = float(np.linalg.norm(S[:3]))
        aligned = length > 0 and np.abs(S / length - wrong).max() <= tolerance
        return _name(Mistake.NOT_UNIT if aligned else Mistake.VALUE, i, "S" if aligned else "ω", S, wrong)
    # A point q on the axis written where its moment belongs: -omega x q is then the right v.
    if wrong[:3].any() and np.abs(-np.cross(wrong[:3], S[3:]) - wrong[3:]).max() <= tolerance:
        return _name(Mistake.POINT_AS_MOMENT, i, "v", S, wrong)
    flipped = np.abs(np.abs(S[3:]) - np.abs(wrong[3:])).max() <= tolerance
    return _name(Mistake.SIGN if flipped else Mistake.VALUE, i, "v", S, wrong)


def _mistaken(i: int, truth: Floats, other: Floats) -> Iterator[tuple[Mistake, str, Vector6]]:
    """What the axis would be after each mistake."""
    omega, v = truth[i, :3], truth[i, 3:]
    revolute = bool(omega.any())
    if revolute and v.any():
        yield Mistake.CROSS_ORDER, "v", np.concatenate([omega, -v])
        yield Mistake.NO_MOMENT, "v", np.concatenate([omega, np.zeros(3)])
    yield Mistake.REVERSED, "S", -truth[i]
    if revolute:
        yield Mistake.SIGN, "ω", np.concatenate([-omega, v])
    yield Mistake.PARTS_SWAPPED, "S", np.concatenate([v, omega])
    yield Mistake.FRAME, "S", other[i]
    for k in range(len(truth)):
        if k != i:
            yield Mistake.COLUMN_SWAPPED, "S", truth[k]
    if revolute:
        yield Mistake.KIND, "S", np.concatenate([np.zeros(3), omega])
    else:
        yield Mistake.KIND, "S", np.concatenate([v, np.zeros(3)])


def _name(mistake: Mistake, i: int, entry: str, S: Vector6, right: Vector6) -> Finding:
    part = {"v": slice(3, 6), "ω": slice(0, 3)}.get(entry, slice(0, 6))
    return Finding(mistake, row=i + 1, entry=entry, given=_tuple(S[part]), expected=_tuple(right[part]))


def _tuple(values: Floats) -> str:
    return "(" + ", ".join(shown(float(x)) for x in values) + ")"
