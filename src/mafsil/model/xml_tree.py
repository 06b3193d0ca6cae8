"""XML as a small tree with positions, read by expat under limits; document types that declare something are refused."""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from xml.parsers import expat

from mafsil.model.diagnostics import Diagnostic, Edit, Fault, Repair, apply_edits, shown
from mafsil.model.faults import (
    CUT_SHORT,
    DOCTYPE,
    DUPLICATE_ATTRIBUTE,
    EMPTY,
    MALFORMED,
    MISMATCHED_TAG,
    TOO_DEEP,
    TOO_MANY_ATTRIBUTES,
    TOO_MANY_ELEMENTS,
    TOO_MANY_LINKS,
)
from mafsil.model.xml_pardons import Find, pardons, places_of, remarks_of

_BY_EXPAT_CODE = {
    3: CUT_SHORT,
    5: CUT_SHORT,
    7: MISMATCHED_TAG,
    8: DUPLICATE_ATTRIBUTE,
    20: CUT_SHORT,
}
_NAMED = re.compile(rb"<\s*+[^\s/>]++")
_START_TAG = re.compile(rb"""<\s*+[^\s/>]++(?:\s*+[^\s=/>"']++\s*+=\s*+(?:"[^"]*+"|'[^']*+'))*+\s*+/?>""")
_DOCTYPE = re.compile(rb"<!DOCTYPE(?:[^\[\]<>\"']|\"[^\"]*\"|'[^']*')*(?:\[(?:[^\]\"']|\"[^\"]*\"|'[^']*')*\]\s*)?>")
_ENTITY = re.compile(rb"&(?!(?:amp|lt|gt|quot|apos|#[0-9]+|#x[0-9a-fA-F]+);)[^;\s&]{1,64};")
_ATTRIBUTE = re.compile(rb"""\s*([^\s=/>"'<]+)\s*=\s*("[^"]*"|'[^']*')""")


@dataclass(frozen=True, slots=True)
class ReadLimits:
    """Sizes beyond which a file is refused while it is being read.

    Attributes:
        bytes: of the file.
        links: `link` or `body` elements.
        depth: of nesting.
        elements: in all.
        attributes: of one element.
    """

    bytes: int = 32 << 20
    links: int = 10_000
    depth: int = 64
    elements: int = 250_000
    attributes: int = 100


DEFAULT_LIMITS = ReadLimits()


@dataclass(slots=True, eq=False)
class Element:
    """One XML element: tag, attributes, place in the file, children, text, number of the file it stands in."""

    tag: str
    attributes: dict[str, str]
    line: int
    column: int
    start: int
    close: int = -1
    children: list[Element] = field(default_factory=list["Element"])
    text: str = ""
    file: int = 0

    def get(self, name: str, default: str = "") -> str:
        """An attribute's text."""
        return self.attributes.get(name, default)

    def all(self, tag: str) -> list[Element]:
        """The children with this tag."""
        return [child for child in self.children if child.tag == tag]

    def first(self, tag: str) -> Element | None:
        """The first child with this tag."""
        return next((child for child in self.children if child.tag == tag), None)

    def walk(self) -> Iterator[Element]:
        """The element and all below it, in document order."""
        waiting: list[Element] = [self]
        while waiting:
            element = waiting.pop()
            yield element
            waiting.extend(reversed(element.children))


class Refusal(Exception):
    """Ends the reading at once; holds the diagnostic. Never leaves the readers."""

    def __init__(self, diagnostic: Diagnostic) -> None:
        super().__init__(diagnostic.code)
        self.diagnostic = diagnostic


@dataclass(frozen=True, slots=True, eq=False)
class Document:
    """A parsed document: its bytes (UTF-8) and its root element; finds places for diagnostics and edits.

    Attributes:
        remarks: what XML forbids and was pardoned.
    """

    data: bytes
    root: Element
    remarks: tuple[Diagnostic, ...] = ()

    def place(self, element: Element, attribute: str | None = None) -> tuple[int, int]:
        """Line and column, from 1, of an element or of one of its attributes."""
        span = self.attribute_span(element, attribute) if attribute else None
        if span is None:
            return element.line, element.column
        before = self.data[element.start : span[0]].decode("utf-8")
        lines = before.count("\n")
        last = before.rpartition("\n")[2]
        return element.line + lines, (0 if lines else element.column - 1) + len(last) + 1

    def attribute_span(self, element: Element, attribute: str) -> tuple[int, int] | None:
        """Byte range `name="value"` of an attribute, or None if it is not there."""
        tag = _START_TAG.match(self.data, element.start)
        if tag is None:
            return None
        for found in _ATTRIBUTE.finditer(self.data, element.start, tag.end()):
            if found.group(1).decode("utf-8") == attribute:
                return found.start(1), found.end(2)
        return None

    def set_attribute(self, element: Element, attribute: str, value: str) -> Edit:
        """The edit that gives an attribute a value, adding it if it is not there."""
        text = f'{attribute}="{escape(value)}"'
        span = self.attribute_span(element, attribute)
        if span is not None:
            return Edit(*span, text)
        named = _NAMED.match(self.data, element.start)
        at = element.start if named is None else named.end()
        return Edit(at, at, " " + text)

    def remove_attribute(self, element: Element, attribute: str) -> Edit:
        """The edit that removes an attribute and the blank before it."""
        span = self.attribute_span(element, attribute)
        if span is None:
            return Edit(element.start, element.start, "")
        return Edit(span[0] - self.data[span[0] - 1 : span[0]].isspace(), span[1], "")

    def remove(self, element: Element) -> Edit:
        """The edit that removes an element with all it holds."""
        return Edit(element.start, self.end(element), "")

    def append(self, element: Element, text: str) -> Edit:
        """The edit that adds text as the last child of an element."""
        tag = _START_TAG.match(self.data, element.start)
        if tag is not None and tag.group().endswith(b"/>"):
            return Edit(tag.end() - 2, tag.end(), f">{text}</{element.tag}>")
        return Edit(element.close, element.close, text)

    def end(self, element: Element) -> int:
        """Offset of the byte after the element."""
        tag = _START_TAG.match(self.data, element.start)
        if tag is not None and tag.group().endswith(b"/>"):
            return tag.end()
        return self.data.index(b">", element.close) + 1


class _Builder:
    """Handlers of one parse."""

    def __init__(self, limits: ReadLimits) -> None:
        self.limits = limits
        self.open: list[Element] = []
        self.texts: list[list[str]] = []
        self.root: Element | None = None
        self.elements = 0
        self.links = 0
        self.parser = expat.ParserCreate("utf-8")
        self.parser.buffer_text = True
        self.parser.StartElementHandler = self.start
        self.parser.EndElementHandler = self.end
        self.parser.CharacterDataHandler = self.characters
        self.parser.StartDoctypeDeclHandler = self.doctype

    def refuse(self, fault: Fault, **details: object) -> Refusal:
        line, column = self.parser.CurrentLineNumber, self.parser.CurrentColumnNumber + 1
        return Refusal(Diagnostic(fault, line, column, details))

    def doctype(self, _name: str, _system: str | None, _public: str | None, declares: bool) -> None:
        refusal = self.refuse(DOCTYPE)
        raise refusal if declares else _Malformed(refusal.diagnostic, self.parser.CurrentByteIndex)

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        self.elements += 1
        self.links += tag in ("link", "body")
        if self.elements > self.limits.elements:
            raise self.refuse(TOO_MANY_ELEMENTS, limit=self.limits.elements)
        if self.links > self.limits.links:
            raise self.refuse(TOO_MANY_LINKS, limit=self.limits.links)
        if len(self.open) >= self.limits.depth:
            raise self.refuse(TOO_DEEP, limit=self.limits.depth)
        if len(attributes) > self.limits.attributes:
            raise self.refuse(TOO_MANY_ATTRIBUTES, element=shown(tag), limit=self.limits.attributes)
        parser = self.parser
        element = Element(
            tag, attributes, parser.CurrentLineNumber, parser.CurrentColumnNumber + 1, parser.CurrentByteIndex
        )
        if self.open:
            self.open[-1].children.append(element)
        else:
            self.root = element
        self.open.append(element)
        self.texts.append([])

    def end(self, _tag: str) -> None:
        element = self.open.pop()
        element.close = self.parser.CurrentByteIndex
        element.text = "".join(self.texts.pop()).strip()

    def characters(self, text: str) -> None:
        self.texts[-1].append(text)


def parse(data: bytes, limits: ReadLimits = DEFAULT_LIMITS) -> Document:
    """The tree of a document.

    Args:
        data: the document in UTF-8, without byte order mark; an encoding declaration is ignored.
        limits: enforced while streaming.

    Raises:
        Refusal: not well formed, a document type with declarations, a limit passed.
    """
    try:
        return Document(data, _root(data, limits))
    except _Malformed:
        if not (finds := pardons(data)):
            raise
    return _forgive(data, finds, limits)


def _root(data: bytes, limits: ReadLimits) -> Element:
    """The root of a document that is XML."""
    builder = _Builder(limits)
    try:
        builder.parser.Parse(data, True)  # in one piece: expat rescans an unfinished token with every piece
    except Refusal as refusal:
        if refusal.diagnostic.fault is not DOCTYPE or isinstance(refusal, _Malformed):
            raise
        raise Refusal(replace(refusal.diagnostic, repair=_without_doctype(data))) from None
    except expat.ExpatError as error:
        fault = _BY_EXPAT_CODE.get(error.code, MALFORMED)
        raise _Malformed(Diagnostic(fault, error.lineno, error.offset + 1), builder.parser.ErrorByteIndex) from None
    if builder.root is None:
        raise Refusal(Diagnostic(EMPTY, 0, 0))
    return builder.root


class _Malformed(Refusal):
    """What expat refuses, with the offset."""

    def __init__(self, diagnostic: Diagnostic, offset: int) -> None:
        super().__init__(diagnostic)
        self.offset = offset


def _forgive(data: bytes, finds: list[Find], limits: ReadLimits) -> Document:
    """A document whose finds are mended before it is parsed; its elements stand where they stand in the file."""
    original = _offsets([find.edit for find in finds])
    try:
        root = _root(apply_edits(data, [find.edit for find in finds]), limits)
    except _Malformed as refusal:
        ((line, column),) = places_of(data, [original(refusal.offset)])
        raise Refusal(replace(refusal.diagnostic, line=line, column=column)) from None
    elements = [*root.walk()]
    for element in elements:
        element.start, element.close = original(element.start), original(element.close)
    places = places_of(data, [element.start for element in elements])
    for element, (line, column) in zip(elements, places, strict=True):
        element.line, element.column = line, column
    return Document(data, root, remarks_of(finds, data))


def _offsets(edits: list[Edit]) -> Callable[[int], int]:
    """From offsets in an edited document to those in the document before."""
    ends: list[int] = []
    shifts = [0]
    for edit in edits:
        size = len(edit.replacement.encode("utf-8"))
        ends.append(edit.start + shifts[-1] + size)
        shifts.append(shifts[-1] + size - (edit.end - edit.start))
    return lambda offset: offset - shifts[bisect_right(ends, offset)]


def _without_doctype(data: bytes) -> Repair | None:
    """The repair that removes the document type declaration, unless the document uses entities that it declares."""
    found = _DOCTYPE.match(data, max(data.find(b"<!DOCTYPE"), 0))
    if found is None or _ENTITY.search(data, found.end()):
        return None
    return Repair("robotfile.repair_remove_doctype", (Edit(found.start(), found.end(), ""),))


def escape(value: str) -> str:
    """Text as it stands between double quotes in an attribute."""
    table = {"&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;", "\n": "&#10;", "\t": "&#9;", "\r": "&#13;"}
    return "".join(table.get(c, c) for c in value)
