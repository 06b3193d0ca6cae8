"""Applies the repairs that diagnostics offer to a document, round by round, and lists what was changed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeAlias

from mafsil.model.diagnostics import Diagnostic, Repair, Report, Severity, apply_edits, require_mechanism
from mafsil.model.faults import PARDONED
from mafsil.model.mechanism import Mechanism
from mafsil.model.source import Source, Text, load, name_of
from mafsil.model.xml_tree import ReadLimits, Refusal

MOST_ROUNDS = 12


@dataclass(frozen=True, slots=True)
class Change:
    """One repair that was carried out, and the diagnostic that asked for it (place in the text of its round)."""

    diagnostic: Diagnostic
    repair: Repair

    def sentence(self, language: str | None = None) -> str:
        """Place, code and what was done."""
        return f"{self.diagnostic.line}: {self.diagnostic.code} {self.repair.sentence(language)}"


Requested: TypeAlias = Callable[[Diagnostic], bool]
"""Whether the repair of a diagnostic is requested."""


def certain(diagnostic: Diagnostic) -> bool:
    """Every repair that leaves no choice."""
    return diagnostic.repair is not None and not diagnostic.repair.guess


def of_errors(diagnostic: Diagnostic) -> bool:
    """Repairs that leave no choice of what stops a reader, ours or another."""
    return certain(diagnostic) and (diagnostic.severity is Severity.ERROR or diagnostic.fault in PARDONED)


def apply_repairs(
    source: Source, limits: ReadLimits, report_of: Callable[[Text], Report], requested: Requested = certain
) -> tuple[Text, tuple[Change, ...]]:
    """The document with the offered repairs carried out that are requested.

    Args:
        source, limits: what to read.
        report_of: the reader of its format.
        requested: which; by default all that leave no choice.

    Returns:
        The corrected document and the changes. What has no such repair remains.

    Raises:
        FileError: the source cannot be read.
    """
    try:
        text = load(source, limits)
    except Refusal as refusal:
        require_mechanism(Report(name_of(source), (refusal.diagnostic,)))
        raise
    text = replace(text, remarks=tuple(remark for remark in text.remarks if remark.repair is not None))
    changes: list[Change] = []
    for _ in range(MOST_ROUNDS):
        report = report_of(text)
        chosen = _apart(_offers(report, requested))
        if not chosen:
            break
        edits = [edit for change in chosen for edit in change.repair.edits]
        text = replace(text, data=apply_edits(text.data, edits), remarks=())
        changes.extend(chosen)
    return text, tuple(changes)


def note_changes(mechanism: Mechanism, changes: tuple[Change, ...]) -> Mechanism:
    """The mechanism with the changes among the notes of its provenance."""
    provenance = mechanism.provenance
    notes = (*(change.sentence("en") for change in changes), *provenance.notes)
    return replace(mechanism, provenance=replace(provenance, notes=notes))


def _offers(report: Report, requested: Requested) -> list[Change]:
    """The repairs on offer that are requested; those of errors first."""
    offers = [Change(d, d.repair) for d in report.diagnostics if d.repair is not None and requested(d)]
    return sorted(offers, key=lambda change: change.diagnostic.severity is not Severity.ERROR)


def _apart(offers: list[Change]) -> list[Change]:
    """As many as can be carried out at once; those that touch the same bytes wait for the next round."""
    chosen: list[Change] = []
    taken: list[tuple[int, int]] = []
    for change in offers:
        spans = [(edit.start, edit.end) for edit in change.repair.edits]
        if not any(start <= end_ and start_ <= end for start, end in spans for start_, end_ in taken):
            chosen.append(change)
            taken.extend(spans)
    return chosen
