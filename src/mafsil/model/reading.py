"""The state of one reading: the document, the diagnostics so far, and strict access to numbers and names.

Numbers have the strict decimal grammar of robot files; what only looks like one is named (`_kind_of_nonsense`).
"""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from mafsil.model.diagnostics import MOST_DIAGNOSTICS, Diagnostic, Edit, Fault, Repair, Severity, safe, shown
from mafsil.model.faults import (
    DECIMAL_COMMA,
    HEXADECIMAL,
    LOCAL_DIGITS,
    MISSING_ATTRIBUTE,
    MORE_REMARKS,
    NO_NAME,
    NOT_A_NUMBER,
    NOT_FINITE,
    OVERFLOW,
    REPEATED_ELEMENT,
    STRANGE_NAME,
    TOO_BIG,
    TOO_MANY_ERRORS,
    UNDERFLOW,
    WITH_UNIT,
    WRONG_COUNT,
)
from mafsil.model.source import Text
from mafsil.model.xml_tree import Document, Element, Refusal

LARGEST = 1e15
"""Beyond this no mass, length or inertia in SI units is meant; joint limits may be larger."""
LONGEST = 400
_DECIMAL = re.compile(r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_HEXADECIMAL = re.compile(r"[+-]?0[xX][0-9a-fA-F]+")
_COMMA = re.compile(r"([+-]?[0-9]+),([0-9]+(?:[eE][+-]?[0-9]+)?)")
_UNIT = re.compile(r"([+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)\s*(kg|m|rad|N|Nm|s|kgm2|kg\.m2)")
_NOT_FINITE = {"nan", "inf", "infinity"}
_SEPARATORS = {"٫": ".", "٬": "", "−": "-"}
FORBIDDEN_IN_NAMES = re.compile(r"[\x00-\x1f\x7f-\x9f\u061c\u200b-\u200f\u202a-\u202e\u2060-\u2069\ufeff\ud800-\udfff]")
LONGEST_NAME = 500
LONGEST_LIST = 20_000
"""Characters of an attribute that are looked at for numbers; the longest list has seven."""
NAMING = frozenset({"name", "link", "joint", "joint1", "joint2", "body", "body1", "body2", "reference"})
"""Attributes that give or repeat names of links and joints."""


def is_writable(text: str) -> bool:
    """Whether XML holds a name as it is and no xacro would expand it."""
    return not FORBIDDEN_IN_NAMES.search(text) and text == text.strip() and "${" not in text and "$(" not in text


@dataclass(slots=True)
class Reading:
    """Collects diagnostics while a document is read; the reader goes on after an error to find the next one.

    Attributes:
        document: the robot file.
        diagnostics: so far.
        included: names and documents of included files, whose elements carry their number from 1.
        arguments: given with the file, for xacro.
        model: given with the file: name of the one that is meant of several.
        in_shape: while a shape or its appearance is read: what is wrong there stops no mechanics and is a warning.
        dropped: number of errors that were made warnings so far.
    """

    document: Document
    diagnostics: list[Diagnostic] = field(default_factory=list[Diagnostic])
    included: list[tuple[str, Document]] = field(default_factory=list[tuple[str, Document]])
    arguments: Mapping[str, str] = field(default_factory=dict[str, str])
    model: str | None = None
    in_shape: bool = False
    dropped: int = 0
    _errors: int = 0
    _remarks: int = 0
    _names: dict[str, list[tuple[Element, str]]] = field(default_factory=dict[str, list[tuple[Element, str]]])

    @property
    def failed(self) -> bool:
        """Whether an error was reported."""
        return any(diagnostic.severity is Severity.ERROR for diagnostic in self.diagnostics)

    def report(
        self,
        fault: Fault,
        element: Element,
        attribute: str | None = None,
        repair: Repair | None = None,
        /,
        **details: object,
    ) -> None:
        """Add a diagnostic at an element or one of its attributes."""
        if self.in_shape and fault.severity is Severity.ERROR:
            fault = replace(fault, severity=Severity.WARNING)
            self.dropped += 1
        if not self._may_report(fault, element):
            return
        line, column = self._document_of(element).place(element, attribute)
        included = self.included[element.file - 1][0] if element.file else ""
        repair = None if element.file else repair
        self.diagnostics.append(Diagnostic(fault, line, column, safe(details), repair, included))

    def include(self, name: str, text: Text, document: Document) -> Element:
        """Take an included file in: its elements carry its number, and what was pardoned in it is said.

        Args:
            name: under which it stands in reports.
            text, document: as they were read.

        Returns:
            Its root.
        """
        name = shown(name)
        self.included.append((name, document))
        for element in document.root.walk():
            element.file = len(self.included)
        remarks = (*text.remarks, *document.remarks)
        self.diagnostics += [replace(remark, file=name, repair=None) for remark in remarks]
        return document.root

    def withdraw(self, remarks: list[Diagnostic]) -> None:
        """Take back what was reported about a part that turned out not to matter."""
        gone = {id(remark) for remark in remarks}
        kept = [diagnostic for diagnostic in self.diagnostics if id(diagnostic) not in gone]
        self._errors -= sum(remark.severity is Severity.ERROR for remark in remarks)
        self._remarks -= sum(remark.severity is not Severity.ERROR for remark in remarks)
        self.diagnostics[:] = kept

    def _may_report(self, fault: Fault, element: Element) -> bool:
        """Whether a diagnostic is still recorded: remarks end with a remark about that, errors with a refusal."""
        error = fault.severity is Severity.ERROR
        self._errors += error
        self._remarks += not error
        if self._errors > MOST_DIAGNOSTICS:
            raise Refusal(Diagnostic(TOO_MANY_ERRORS, element.line, element.column, {"limit": MOST_DIAGNOSTICS}))
        if self._remarks == MOST_DIAGNOSTICS and not error:
            more = Diagnostic(MORE_REMARKS, element.line, element.column, {"limit": MOST_DIAGNOSTICS})
            self.diagnostics.append(more)
        return error or self._remarks < MOST_DIAGNOSTICS

    def name(self, element: Element, attribute: str = "name") -> str:
        """A name; reported if it is missing, empty or holds characters that do not show."""
        value = element.get(attribute)
        if not value.strip() or len(value) > LONGEST_NAME:
            self.report(NO_NAME, element, attribute, element=element.tag, attribute=attribute)
            return ""
        clean = FORBIDDEN_IN_NAMES.sub("", value).strip()
        if clean != value:
            repair = self._rename(value, clean)
            self.report(STRANGE_NAME, element, attribute, repair, name=value)
        return value

    def reference(self, element: Element, attribute: str) -> str:
        """A name of something else; reported only if it is missing."""
        value = element.get(attribute)
        if not value.strip():
            self.report(MISSING_ATTRIBUTE, element, element=element.tag, attribute=attribute)
        return value

    def one(self, element: Element, tag: str) -> Element | None:
        """The first child with a tag, or None; a second one is reported and ignored."""
        found = element.all(tag)
        for extra in found[1:]:
            self.report(REPEATED_ELEMENT, extra, None, self.remove(extra), element=tag, parent=element.tag)
        return found[0] if found else None

    def number(
        self,
        element: Element,
        attribute: str,
        default: float | None = None,
        *,
        fallback: Repair | None = None,
        largest: float = LARGEST,
    ) -> float | None:
        """One number.

        Args:
            element, attribute: where it stands.
            default: taken if the attribute is missing; None makes that an error.
            fallback: the repair to offer if none is obvious.
            largest: magnitude beyond which it is refused.

        Returns:
            The number, or None after an error.
        """
        values = self.vector(
            element, attribute, 1, None if default is None else (default,), fallback=fallback, largest=largest
        )
        return values[0] if values else None

    def vector(
        self,
        element: Element,
        attribute: str,
        count: int,
        default: tuple[float, ...] | None = None,
        *,
        fallback: Repair | None = None,
        largest: float = LARGEST,
    ) -> tuple[float, ...] | None:
        """`count` numbers separated by blanks, as `number`."""
        fallback = None if fallback is None else replace(fallback, guess=True)
        if attribute not in element.attributes:
            if default is None:
                self.report(MISSING_ATTRIBUTE, element, None, fallback, element=element.tag, attribute=attribute)
            return default
        text = element.attributes[attribute]
        words = text[:LONGEST_LIST].split()
        if count == 1 and len(words) > 1 and proposal(text) is not None:
            words = [text.strip()]
        if len(words) != count:
            self._wrong_count(element, attribute, words, count, fallback)
            return None
        return self._decimals(element, attribute, words, fallback, largest)

    def set_attribute(self, element: Element, attribute: str, value: str, *, guess: bool = False) -> Repair:
        """The repair that writes a value."""
        edit = self._document_of(element).set_attribute(element, attribute, value)
        return Repair("robotfile.repair_set", (edit,), {"attribute": attribute, "value": shown(value)}, guess)

    def swap_attributes(self, element: Element, first: str, second: str) -> Repair:
        """The repair that exchanges two values."""
        edits = (
            self._document_of(element).set_attribute(element, first, element.get(second)),
            self._document_of(element).set_attribute(element, second, element.get(first)),
        )
        return Repair("robotfile.repair_swap", edits, {"first": first, "second": second})

    def remove_attribute(self, element: Element, attribute: str) -> Repair:
        """The repair that removes an attribute."""
        edit = self._document_of(element).remove_attribute(element, attribute)
        return Repair("robotfile.repair_remove_attribute", (edit,), {"attribute": attribute})

    def rename_attribute(self, element: Element, attribute: str, name: str, *, guess: bool = False) -> Repair:
        """The repair that gives an attribute another name."""
        document = self._document_of(element)
        span = document.attribute_span(element, attribute)
        start = element.start if span is None else span[0]
        edit = Edit(start, start + (0 if span is None else len(attribute.encode())), "" if span is None else name)
        return Repair("robotfile.repair_respell", (edit,), {"old": shown(attribute), "new": shown(name)}, guess)

    def remove(self, element: Element, *, guess: bool = False) -> Repair:
        """The repair that removes an element."""
        edit = self._document_of(element).remove(element)
        return Repair("robotfile.repair_remove", (edit,), {"element": shown(element.tag)}, guess)

    def append(self, element: Element, text: str) -> Repair:
        """The repair that adds a child."""
        edit: Edit = self._document_of(element).append(element, text)
        return Repair("robotfile.repair_add", (edit,), {"text": shown(text), "element": shown(element.tag)})

    def _document_of(self, element: Element) -> Document:
        """The document in which an element stands: the robot file or an included one."""
        return self.included[element.file - 1][1] if element.file else self.document

    def _rename(self, old: str, new: str) -> Repair | None:
        """The repair that gives a name and all references to it another spelling, if that is free."""
        if not self._names:
            for element in self.document.root.walk():
                for key in NAMING.intersection(element.attributes):
                    self._names.setdefault(element.get(key), []).append((element, key))
        if not new or new in self._names or old not in self._names:
            return None
        edits = tuple(self._document_of(e).set_attribute(e, key, new) for e, key in self._names[old])
        return Repair("robotfile.repair_rename", edits, {"old": shown(old), "new": shown(new)})

    def _decimals(
        self, element: Element, attribute: str, words: list[str], fallback: Repair | None, largest: float
    ) -> tuple[float, ...] | None:
        read = [decimal(word, largest=largest) for word in words]
        faults = [(word, fault) for word, (_, fault) in zip(words, read, strict=True) if fault is not None]
        if not faults:
            return tuple(value for value, _ in read)
        proposals = [word if fault is None else proposal(word) for word, (_, fault) in zip(words, read, strict=True)]
        mended = [word for word in proposals if word is not None]
        repair = self.set_attribute(element, attribute, " ".join(mended)) if len(mended) == len(words) else fallback
        word, fault = next(((w, f) for w, f in faults if f is not UNDERFLOW), faults[0])
        if fault is UNDERFLOW:
            repair = self.set_attribute(
                element, attribute, " ".join(w if f is None else "0" for w, (_, f) in zip(words, read, strict=True))
            )
        self.report(
            fault, element, attribute, repair,
            element=element.tag, attribute=attribute, text=word, limit=largest,
        )  # fmt: skip
        return tuple(value for value, _ in read) if fault is UNDERFLOW else None

    def _wrong_count(
        self, element: Element, attribute: str, words: list[str], count: int, fallback: Repair | None
    ) -> None:
        clean = all(decimal(word)[1] is None for word in words)
        repair = fallback
        if fallback is None and clean and words:
            repair = self.set_attribute(element, attribute, " ".join((words + ["0"] * count)[:count]), guess=True)
        self.report(
            WRONG_COUNT, element, attribute, repair,
            element=element.tag, attribute=attribute, expected=count, got=len(words), text=" ".join(words),
        )  # fmt: skip


def decimal(text: str, *, largest: float = LARGEST) -> tuple[float, Fault | None]:
    """The number a word stands for, and what is wrong with it.

    Args:
        text: one word without blanks.
        largest: magnitude beyond which it is refused.

    Returns:
        The value (0.0 if it has none) and the fault, or None.
    """
    if len(text) > LONGEST or not _DECIMAL.fullmatch(text):
        return 0.0, _kind_of_nonsense(text)
    value = float(text)
    if math.isinf(value):
        return 0.0, OVERFLOW
    if abs(value) > largest:
        return 0.0, TOO_BIG
    if value == 0.0 and any(c in "123456789" for c in re.split("[eE]", text)[0]):
        return 0.0, UNDERFLOW
    return value, None


def proposal(text: str) -> str | None:
    """The plain decimal that a faulty word most probably means, or None."""
    word = text.strip()
    if len(word) > LONGEST:
        return None
    if found := _COMMA.fullmatch(word):
        return f"{found[1]}.{found[2]}"
    if _HEXADECIMAL.fullmatch(word):
        return str(int(word, 16))
    if found := _UNIT.fullmatch(word):
        return found[1]
    western = _with_western_digits(word)
    return western if western != word and _DECIMAL.fullmatch(western) else None


def written(value: float) -> str:
    """The shortest decimal that reads back as the same double."""
    text = repr(float(value))
    return text.removesuffix(".0")


def _kind_of_nonsense(text: str) -> Fault:
    word = text.strip().lower()
    if len(word) > LONGEST:
        return NOT_A_NUMBER
    if word.lstrip("+-") in _NOT_FINITE:
        return NOT_FINITE
    if _HEXADECIMAL.fullmatch(word):
        return HEXADECIMAL
    if _COMMA.fullmatch(word):
        return DECIMAL_COMMA
    if _UNIT.fullmatch(text.strip()):
        return WITH_UNIT
    return LOCAL_DIGITS if any(c.isdecimal() and c > "\x7f" for c in word) else NOT_A_NUMBER


def _with_western_digits(word: str) -> str:
    return "".join(_SEPARATORS.get(c, str(unicodedata.decimal(c)) if c.isdecimal() else c) for c in word)
