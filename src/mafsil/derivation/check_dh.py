"""A student's Denavit-Hartenberg table against the robot: which entry is wrong, and by which mistake.

A table is right if it describes the same arm, whatever frames were chosen; it need not be our table. A wrong one is
repaired by every usual mistake in turn, and by any other single value. Of all repairs that make it right the one that
changes least is the finding: the one that leads nearest to a table with our own frames, then the likeliest.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations
from typing import TypeAlias
from warnings import catch_warnings

from numpy.typing import ArrayLike

from mafsil.arrays import not_negative
from mafsil.derivation.dh_mistakes import Repair, entry_text, other_convention, single_rows, values, whole_table
from mafsil.derivation.dh_truth import Rows, Truth, differing, distance
from mafsil.derivation.review import Finding, Mistake, Review
from mafsil.derivation.tolerances import SAME
from mafsil.errors import InputError, InputWarning
from mafsil.model.denavit_hartenberg import Convention, DHRowLike, convention_of, dh_rows
from mafsil.model.loading import RobotLike, as_mechanism
from mafsil.model.placement import checked_pose

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
    found = _repaired(given, requested, truth)
    if found is None:
        beside = _repaired(given, other.convention, truth, pairs=False)
        found = None if beside is None else replace(beside, findings=(other.finding, *beside.findings))
    return _differences(given, truth, requested) if found is None else found


def _repaired(rows: Rows, convention: Convention, truth: Truth, *, pairs: bool = True) -> Review | None:
    """The smallest repair: of one mistake, else of two."""
    single = list(single_rows(rows, convention))
    typed = values(rows, convention, truth.solved(rows, convention))
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
