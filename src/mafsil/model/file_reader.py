"""What the readers of all robot file formats do alike: load, parse, build, report, repair.

Applies the repairs that diagnostics offer to a document, round by round, and lists what was changed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeAlias

from mafsil.errors import ModelError, ModelWarning, warn
from mafsil.model.asset_path import Assets
from mafsil.model.diagnostics import Diagnostic, Repair, Report, Severity, apply_edits, require_mechanism
from mafsil.model.faults import INCONSISTENT, NO_ARGUMENTS, NO_MODELS, PARDONED
from mafsil.model.mechanism import Mechanism, Provenance
from mafsil.model.reading import Reading
from mafsil.model.source import Source, Text, load, name_of
from mafsil.model.tip import TipChoice
from mafsil.model.xacro import is_xacro
from mafsil.model.xml_tree import DEFAULT_LIMITS, ReadLimits, Refusal, parse

MOST_ROUNDS = 12
Requested: TypeAlias = Callable[[Diagnostic], bool]
"""Whether the repair of a diagnostic is requested."""
Build: TypeAlias = Callable[[Reading, Assets, str, ReadLimits], Mechanism | None]
"""Makes a mechanism of a parsed document, its assets, its name and the limits, or None after errors."""
MOST_NOTES = 50
_MOST_SHOWN = 2


@dataclass(frozen=True, slots=True)
class Format:
    """What a file format offers: its documents read, diagnosed and repaired.

    Attributes:
        build: makes the mechanism.
    """

    build: Build

    def read(
        self,
        source: Source,
        *,
        packages: Iterable[str | Path] = (),
        limits: ReadLimits = DEFAULT_LIMITS,
        repair: bool = False,
        arguments: Mapping[str, str] | None = None,
        model: str | None = None,
    ) -> Mechanism:
        """The mechanism that a file describes.

        Args:
            source: path of the file, or the document itself (bytes, or a str that begins with `<`).
            packages: further directories in which meshes and included files may lie; for URDF directories of packages,
                or that hold packages, for `package://` references.
            limits: sizes beyond which the file is refused.
            repair: carry out the repairs of errors that leave no choice before giving up; the file is not touched.
            arguments: of a xacro file, by name.
            model: name of the one that is meant, of an SDFormat file with several robots.

        Returns:
            The mechanism; what was normalised, guessed or repaired stands in its `provenance.remarks`.

        Raises:
            FileError: the file has errors; the sentence holds the first, `details["report"]` all of them.
        """
        return self.reader(packages, limits, arguments, model).read(source, repair=repair)

    def diagnose(
        self, source: Source, *, packages: Iterable[str | Path] = (), limits: ReadLimits = DEFAULT_LIMITS
    ) -> Report:
        """All that is to be said about a file, with the mechanism if there is one.

        Args:
            source, packages, limits: as for `read`.

        Returns:
            Coded diagnostics in the order of the file; never raises for what stands in the file.
        """
        return self.reader(packages, limits).diagnose(source)

    def repair(
        self, source: Source, *, packages: Iterable[str | Path] = (), limits: ReadLimits = DEFAULT_LIMITS
    ) -> tuple[str, tuple[Change, ...]]:
        """A corrected document, and what was changed in it: all repairs on offer that leave no choice.

        Args:
            source, packages, limits: as for `read`; included files are left alone.

        Returns:
            The text, with everything that needed no repair left as it was, and the list of changes.

        Raises:
            FileError: the source cannot be read at all (missing, too large, not in its encoding).
        """
        return self.reader(packages, limits).repair(source)

    def reader(
        self,
        packages: Iterable[str | Path] = (),
        limits: ReadLimits = DEFAULT_LIMITS,
        arguments: Mapping[str, str] | None = None,
        model: str | None = None,
    ) -> FileReader:
        """The reader itself, for what works on files beside reading them; arguments as for `read`."""
        return FileReader(self.build, tuple(packages), limits, dict(arguments or {}), model)


@dataclass(frozen=True, slots=True)
class FileReader:
    """One format: how a parsed document becomes a mechanism, and what else was given to read it."""

    build: Build
    packages: tuple[str | Path, ...]
    limits: ReadLimits
    arguments: dict[str, str] = field(default_factory=dict[str, str])
    model: str | None = None

    def read(self, source: Source, *, repair: bool, silent: bool = False) -> Mechanism:
        """The mechanism; after the repairs of its errors if requested; silent if the caller says the remarks."""
        report = self.diagnose(source)
        if report.ok or not repair:
            mechanism = require_mechanism(report)
            if not silent:
                warn_of(mechanism)
            return mechanism
        text, changes = apply_repairs(source, self.limits, self.report_of, of_errors)
        return note_changes(require_mechanism(self.report_of(text)), changes)

    def diagnose(self, source: Source) -> Report:
        """All that is to be said."""
        try:
            text = load(source, self.limits)
        except Refusal as refusal:
            return Report(name_of(source), (refusal.diagnostic,))
        return self.report_of(text)

    def repair(self, source: Source) -> tuple[str, tuple[Change, ...]]:
        """The corrected text and what was changed."""
        text, changes = apply_repairs(source, self.limits, self.report_of)
        return text.data.decode("utf-8"), changes

    def report_of(self, text: Text) -> Report:
        """The report about a decoded document."""
        try:
            document = parse(text.data, self.limits)
            reading = Reading(document, [*text.remarks, *document.remarks], arguments=self.arguments, model=self.model)
        except Refusal as refusal:
            return Report(text.name, (*text.remarks, refusal.diagnostic))
        mechanism = self._built(reading, text)
        ordered = tuple(sorted(reading.diagnostics, key=lambda d: (d.file, d.line, d.column)))
        if mechanism is not None:
            mechanism = replace(mechanism, provenance=_origin(mechanism, text.name, ordered))
        return Report(text.name, ordered, mechanism)

    def _built(self, reading: Reading, text: Text) -> Mechanism | None:
        root = reading.document.root
        if self.arguments and not is_xacro(root):
            reading.report(NO_ARGUMENTS, root, names=", ".join(self.arguments))
        if self.model is not None and root.tag in ("robot", "mujoco"):
            reading.report(NO_MODELS, root, model=self.model)
        try:
            mechanism = self.build(reading, Assets.of(text.folder, self.packages), text.name, self.limits)
        except Refusal as refusal:
            reading.diagnostics.append(refusal.diagnostic)
        except ModelError as error:
            reading.report(INCONSISTENT, root, reason=error)
        else:
            return None if reading.failed else mechanism
        return None


def warn_of(mechanism: Mechanism, choice: TipChoice | None = None, silent: tuple[str, ...] = ()) -> None:
    """One Python warning per load, if the file was changed or looks wrong, or its tip had to be chosen among several.

    It shows the first remark of each kind, beside a tip only the first one, and how many more there are.

    Args:
        mechanism: as it was read.
        choice: the tip, if it had to be chosen.
        silent: codes of remarks that need no warning.
    """
    source = mechanism.provenance.source
    remarks = tuple(remark for remark in mechanism.provenance.remarks if remark.code not in silent)
    kinds = list({remark.code: remark for remark in reversed(remarks)}.values())[::-1]
    kinds = kinds[: _MOST_SHOWN if choice is None else 1]
    shown = "; ".join(remark.line_of_text() for remark in kinds)
    more = len(remarks) - len(kinds)
    shown = f"{shown}; +{more}" if more > 0 else shown
    if remarks and choice is not None:
        warn(ModelWarning("model.load_tip_remarks", source=source, choice=choice, count=len(remarks), remarks=shown))
    elif remarks:
        warn(ModelWarning("model.load_remarks", source=source, count=len(remarks), remarks=shown))
    elif choice is not None:
        warn(ModelWarning("model.load_tip", source=source, choice=choice))


def _origin(mechanism: Mechanism, name: str, diagnostics: tuple[Diagnostic, ...]) -> Provenance:
    """The file, and what was chosen, guessed or normalised."""
    warnings = tuple(d for d in diagnostics if d.severity is Severity.WARNING)
    notes = (*_notes(warnings), *mechanism.provenance.notes)
    return replace(mechanism.provenance, source=name, notes=notes, remarks=warnings)


def _notes(warnings: tuple[Diagnostic, ...]) -> tuple[str, ...]:
    """What was guessed or normalised, as the notes of the mechanism."""
    notes = tuple(warning.line_of_text("en") for warning in warnings[:MOST_NOTES])
    more = len(warnings) - MOST_NOTES
    return (*notes, f"... {more} more") if more > 0 else notes


@dataclass(frozen=True, slots=True)
class Change:
    """One repair that was carried out, and the diagnostic that asked for it (place in the text of its round)."""

    diagnostic: Diagnostic
    repair: Repair

    def sentence(self, language: str | None = None) -> str:
        """Place, code and what was done."""
        return f"{self.diagnostic.line}: {self.diagnostic.code} {self.repair.sentence(language)}"


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
