"""What a reader has to say about a robot file: coded, placed, in both languages, with the repair it offers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from copy import copy
from dataclasses import dataclass, field
from enum import Enum

from mafsil.answer import Answer, Status
from mafsil.errors import FileError, MafsilError
from mafsil.messages import say
from mafsil.model.mechanism import Mechanism

MOST_DIAGNOSTICS = 1000
SHOWN_LENGTH = 100


class Severity(Enum):
    """How grave a diagnostic is; only errors stop a reader."""

    ERROR = "E"
    WARNING = "W"
    INFO = "I"


@dataclass(frozen=True, slots=True)
class Fault:
    """One kind of diagnostic. Further checks (plausibility, style) declare further faults in catalogues of their own.

    Attributes:
        code: stable, unique, such as `N0203`: a letter for the subject and four digits.
        severity: error, warning or information.
        key: of the sentence in the message catalogue, `area.name`.
    """

    code: str
    severity: Severity
    key: str


@dataclass(frozen=True, slots=True)
class Edit:
    """Replace the bytes start..end of the document (as UTF-8) by a text."""

    start: int
    end: int
    replacement: str


def apply_edits(data: bytes, edits: Iterable[Edit]) -> bytes:
    """The bytes after edits that do not overlap."""
    pieces: list[bytes] = []
    at = 0
    for edit in sorted(edits, key=lambda edit: (edit.start, edit.end)):
        pieces += [data[at : edit.start], edit.replacement.encode("utf-8")]
        at = edit.end
    return b"".join([*pieces, data[at:]])


@dataclass(frozen=True, slots=True)
class Repair:
    """A change of the file that removes a fault.

    Attributes:
        key: of the sentence that says what the change does, `area.name`.
        edits: the change, for a machine.
        details: values for the sentence.
        guess: whether the file could have meant something else; carried out only where its code is requested.
    """

    key: str
    edits: tuple[Edit, ...]
    details: dict[str, object] = field(default_factory=dict[str, object])
    guess: bool = False

    def sentence(self, language: str | None = None) -> str:
        """What the repair would do."""
        return say(self.key, language=language, **self.details)


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One remark about one place of a file.

    Attributes:
        fault: what kind.
        line, column: place in the file, counted from 1; 0 if the remark is about the whole file.
        details: values for the sentence.
        repair: the change that is offered, or None.
        file: the included file in which the place is; empty for the robot file itself.
    """

    fault: Fault
    line: int
    column: int
    details: dict[str, object] = field(default_factory=dict[str, object])
    repair: Repair | None = None
    file: str = ""

    @property
    def code(self) -> str:
        """Stable code of the fault, such as `N0203`."""
        return self.fault.code

    @property
    def severity(self) -> Severity:
        """Error, warning or information."""
        return self.fault.severity

    def sentence(self, language: str | None = None) -> str:
        """What is wrong and what to do."""
        return say(self.fault.key, language=language, **self.details)

    def spoken(self, language: str | None = None) -> str:
        """The sentence, as the reason inside another one."""
        return self.sentence(language)

    def line_of_text(self, language: str | None = None) -> str:
        """Place, code, sentence and offered repair on one line."""
        place = f"{self.line}:{self.column}: " if self.line else ""
        place = f"{self.file}:{place}" if self.file else place
        return f"{place}{self.code} {self.sentence(language)}{self._offer(language)}"

    def to_dict(self) -> dict[str, object]:
        """Plain data for JSON: code, severity, line, column, sentences and repair."""
        return {
            "code": self.code,
            "severity": self.severity.value,
            "file": self.file,
            "line": self.line,
            "column": self.column,
            "sentence": {code: self.sentence(code) for code in ("en", "ar")},
            "repair": self._repair_to_dict(),
        }

    def _offer(self, language: str | None) -> str:
        """The repair in brackets, if there is one; a guess says so."""
        if self.repair is None:
            return ""
        sentence = self.repair.sentence(language)
        return f" [{say('robotfile.perhaps', language=language, repair=sentence) if self.repair.guess else sentence}]"

    def _repair_to_dict(self) -> dict[str, object] | None:
        if self.repair is None:
            return None
        return {
            "sentence": {code: self.repair.sentence(code) for code in ("en", "ar")},
            "guess": self.repair.guess,
            "edits": [{"start": e.start, "end": e.end, "replacement": e.replacement} for e in self.repair.edits],
        }


class ReadingStatus(Status):
    """Whether a robot file gives a mechanism."""

    READ = ("model.file_read", True)
    """It does; warnings may stand beside it."""
    REFUSED = ("model.file_refused", False)
    """Errors stop the reader."""


@dataclass(frozen=True, repr=False)
class Report(Answer, entries="diagnostics", data="source diagnostics"):
    """All that was found in one robot file.

    Attributes:
        source: name of the file, or `<text>`.
        diagnostics: in the order of the file.
        mechanism: what was read, or None if there are errors.
    """

    source: str
    diagnostics: tuple[Diagnostic, ...] = ()
    mechanism: Mechanism | None = None

    @property
    def ok(self) -> bool:
        """Whether a mechanism could be read."""
        return self.mechanism is not None

    @property
    def errors(self) -> tuple[Diagnostic, ...]:
        """The diagnostics that stop the reader."""
        return self._of(Severity.ERROR)

    @property
    def warnings(self) -> tuple[Diagnostic, ...]:
        """What was guessed or normalised, and what looks wrong."""
        return self._of(Severity.WARNING)

    @property
    def codes(self) -> tuple[str, ...]:
        """Codes of all diagnostics, in order."""
        return tuple(diagnostic.code for diagnostic in self)

    @property
    def status(self) -> ReadingStatus:
        """Whether a mechanism could be read."""
        return ReadingStatus.READ if self.ok else ReadingStatus.REFUSED

    def __bool__(self) -> bool:
        return self.ok

    def explain(self, language: str | None = None) -> str:
        """The verdict with the counts of errors and warnings, then one line per diagnostic."""
        counts = {"errors": len(self.errors), "warnings": len(self.warnings)}
        verdict = self.status.sentence(language, source=self.source, **counts)
        return "\n".join([verdict, *self.lines(language)])

    def __format__(self, language: str) -> str:
        """The first errors as one text, in the language named by the format (`{report:ar}`)."""
        first = [diagnostic.line_of_text(language or None) for diagnostic in self.errors[:3]]
        more = len(self.errors) - len(first)
        return "; ".join([*first, f"+{more}"] if more > 0 else first)

    def lines(self, language: str | None = None) -> list[str]:
        """One line of text per diagnostic, for people."""
        return [f"{self.source}:{d.line_of_text(language)}" for d in self]

    def _of(self, severity: Severity) -> tuple[Diagnostic, ...]:
        return tuple(diagnostic for diagnostic in self if diagnostic.severity is severity)


def require_mechanism(report: Report) -> Mechanism:
    """The mechanism of a report.

    Raises:
        FileError: there are errors; the sentence holds the first three, `details["report"]` all.
    """
    if report.mechanism is None:
        raise FileError("robotfile.refused", source=shown(report.source), report=report)
    return report.mechanism


def shown(text: str) -> str:
    """Foreign text made safe for a sentence: control characters escaped, the middle cut out if it is long."""
    head, tail = SHOWN_LENGTH // 3, SHOWN_LENGTH - SHOWN_LENGTH // 3 - 1
    cut = text if len(text) <= SHOWN_LENGTH else f"{text[:head]}…{text[-tail:]}"
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in cut)


def safe(details: Mapping[str, object]) -> dict[str, object]:
    """Details of a sentence with all foreign text in them made safe; reasons of our own stay whole around it."""
    return {name: _safe(value) for name, value in details.items()}


def _safe(value: object) -> object:
    if isinstance(value, MafsilError):
        value = copy(value)
        value.details = safe(value.details)
    return shown(value) if isinstance(value, str) else value
