"""What the readers of all robot file formats do alike: load, parse, build, report, repair."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeAlias

from mafsil.errors import ModelError
from mafsil.model.asset_path import Assets
from mafsil.model.diagnostics import Diagnostic, Report, Severity, require_mechanism
from mafsil.model.faults import INCONSISTENT
from mafsil.model.mechanism import Mechanism, Provenance
from mafsil.model.reading import Reading
from mafsil.model.repairing import Change, mended, noted
from mafsil.model.source import Source, Text, load, name_of
from mafsil.model.xml_tree import ReadLimits, Refusal, parse

Build: TypeAlias = Callable[[Reading, Assets, str, ReadLimits], Mechanism | None]
"""Makes a mechanism of a parsed document, its assets, its name and the limits, or None after errors."""
MOST_NOTES = 50


@dataclass(frozen=True, slots=True)
class FileReader:
    """One format: how a parsed document becomes a mechanism, and what else was given to read it."""

    build: Build
    packages: tuple[str | Path, ...]
    limits: ReadLimits

    @classmethod
    def of(cls, build: Build, packages: Iterable[str | Path], limits: ReadLimits) -> FileReader:
        """For one call of a public function."""
        return cls(build, tuple(packages), limits)

    def read(self, source: Source, *, repair: bool) -> Mechanism:
        """The mechanism; after the repairs of its errors if asked for."""
        report = self.diagnose(source)
        if report.ok or not repair:
            return require_mechanism(report)
        text, changes = mended(source, self.limits, self.report_of, only_errors=True)
        return noted(require_mechanism(self.report_of(text)), changes)

    def diagnose(self, source: Source) -> Report:
        """All that is to be said."""
        try:
            text = load(source, self.limits)
        except Refusal as refusal:
            return Report(name_of(source), (refusal.diagnostic,))
        return self.report_of(text)

    def repair(self, source: Source) -> tuple[str, tuple[Change, ...]]:
        """The corrected text and what was changed."""
        text, changes = mended(source, self.limits, self.report_of)
        return text.data.decode("utf-8"), changes

    def report_of(self, text: Text) -> Report:
        """The report about a decoded document."""
        try:
            reading = Reading(parse(text.data, self.limits), list(text.remarks))
        except Refusal as refusal:
            return Report(text.name, (*text.remarks, refusal.diagnostic))
        mechanism = self._built(reading, text)
        ordered = tuple(sorted(reading.diagnostics, key=lambda d: (d.file, d.line, d.column)))
        if mechanism is not None:
            mechanism = replace(mechanism, provenance=Provenance(text.name, notes=_notes(ordered)))
        return Report(text.name, ordered, mechanism)

    def _built(self, reading: Reading, text: Text) -> Mechanism | None:
        try:
            mechanism = self.build(reading, Assets.of(text.folder, self.packages), text.name, self.limits)
        except Refusal as refusal:
            reading.diagnostics.append(refusal.diagnostic)
        except ModelError as error:
            reading.report(INCONSISTENT, reading.document.root, reason=str(error))
        else:
            return None if reading.failed else mechanism
        return None


def _notes(diagnostics: tuple[Diagnostic, ...]) -> tuple[str, ...]:
    """What was guessed or normalised, as the notes of the mechanism."""
    warnings = [d.line_of_text("en") for d in diagnostics if d.severity is Severity.WARNING]
    more = len(warnings) - MOST_NOTES
    return (*warnings[:MOST_NOTES], f"... {more} more") if more > 0 else tuple(warnings)
