"""What robot files contain though XML forbids it, and tinyxml2 takes: urdfdom, MuJoCo and Gazebo read by tinyxml2.

A second look at a document that expat refused. Every find is a remark with a place and the edit that mends it; what is
not found here remains for expat to refuse.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

from mafsil.model.diagnostics import Diagnostic, Edit, Fault, Repair
from mafsil.model.faults import (
    COMMENT_HYPHENS,
    DECLARATION_PARDONED,
    DOCUMENT_TYPE,
    JUNK_AFTER_END,
    NO_BLANK,
    STRAY_CHARACTER,
    STRAY_MARKUP,
    UNDEFINED_ENTITY,
)

_BLANKS = b" \t\r\n"
MOST_SINGLE = 100
"""Finds of one kind that get a remark each; those after them share one."""
_CONTROL = rb"[\x00-\x08\x0b\x0c\x0e-\x1f]|\xef\xbf[\xbe\xbf]"
_IN_TEXT = re.compile(rb"&|\]\]>|" + _CONTROL)
_IN_VALUE = re.compile(rb"&|<|" + _CONTROL)
_CONTROLS = re.compile(_CONTROL)
_BETWEEN = re.compile(rb"[\x0b\x0c]")
"""Blanks of C that are none of XML."""
_IN_COMMENT = re.compile(rb"-(?=-)|-\Z|" + _CONTROL)
_REFERENCE = re.compile(rb"&(?:(?:amp|lt|gt|quot|apos)|#([0-9]{1,7})|#x([0-9a-fA-F]{1,6}));")
_NAME = rb"[A-Za-z_:\x80-\xff][\w.:\x80-\xff-]*+"
_OPENING = re.compile(rb"<(\s*+)" + _NAME)
_CLOSING = re.compile(rb"<(\s*+)/" + _NAME + rb"([^>]*+)>")
_GIVEN = re.compile(rb"""(\s*+)""" + _NAME + rb"""\s*+=\s*+("[^"]*+"|'[^']*+')""")
_DONE = re.compile(rb"\s*+(/?)>")
_BLANK = rb"[ \t\r\n]"
_INSTRUCTION = re.compile(rb"<\?(" + _NAME + rb")(?=" + _BLANK + rb"|\?>)")
_DECLARATION = re.compile(
    rb"""<\?xml_+version_*=_*(?:"1\.[0-9]+"|'1\.[0-9]+')(?:_+encoding_*=_*(?:"[\w.-]+"|'[\w.-]+'))?"""
    rb"""(?:_+standalone_*=_*(?:"(?:yes|no)"|'(?:yes|no)'))?_*\?>""".replace(b"_", _BLANK)
)
_DOCUMENT_TYPE = re.compile(rb"""<!DOCTYPE(?:[^\[\]<>"']|"[^"<>]*"|'[^'<>]*')*>""")
"""Without declarations of its own, so that nothing is meant by it that the document says nowhere."""
_REPLACED = {ord("<"): "&lt;", ord("]"): "]]&gt;", ord("&"): "&amp;"}


class Find(NamedTuple):
    """One thing that XML forbids: what kind, the edit that mends it, and whether the file may have meant something."""

    fault: Fault
    edit: Edit
    guess: bool = False


def pardons(data: bytes) -> list[Find]:
    """Everything in a document that tinyxml2 takes and XML forbids, in order, up to where the document makes no sense.

    Args:
        data: UTF-8.
    """
    scan = _Scan(data)
    return [*scan.finds()]


def remarks_of(finds: list[Find], data: bytes) -> tuple[Diagnostic, ...]:
    """The finds as remarks with places and repairs; of a kind with many finds the last ones share a remark."""
    kinds: dict[str, list[Find]] = {}
    for find in finds:
        kinds.setdefault(find.fault.code, []).append(find)
    groups = [[find] for kind in kinds.values() for find in kind[:MOST_SINGLE]]
    groups += [kind[MOST_SINGLE:] for kind in kinds.values() if len(kind) > MOST_SINGLE]
    groups.sort(key=lambda group: group[0].edit.start)
    places = places_of(data, [group[0].edit.start for group in groups])
    return tuple(
        Diagnostic(
            group[0].fault, line, column, {},
            Repair("robotfile.repair_markup", tuple(find.edit for find in group), guess=any(f.guess for f in group)),
        )
        for group, (line, column) in zip(groups, places, strict=True)
    )  # fmt: skip


def places_of(data: bytes, offsets: list[int]) -> Iterator[tuple[int, int]]:
    """Line and column, from 1, of ascending offsets in UTF-8."""
    at, line, column = 0, 1, 1
    for offset in offsets:
        piece = data[at:offset]
        newlines = piece.count(b"\n")
        line += newlines
        column = (1 if newlines else column) + len(piece.rpartition(b"\n")[2].decode("utf-8", "ignore"))
        at = offset
        yield line, column


@dataclass(slots=True)
class _Scan:
    """One walk over a document, token by token, as tinyxml2 makes it."""

    data: bytes
    at: int = 0
    depth: int = 0
    begun: bool = False

    def finds(self) -> Iterator[Find]:
        """The finds in order; ends at what is no token."""
        data = self.data
        while self.at < len(data) and not (self.begun and self.depth == 0):
            found = data.find(b"<", self.at)
            end = len(data) if found < 0 else found
            yield from self._text(self.at, end)
            self.at = end
            if found >= 0:
                yield from self._token()
        if self.begun and self.depth == 0:
            yield from self._tail()

    def _token(self) -> Iterator[Find]:
        """What begins with `<`; the position stands behind it, or at the end where it is none."""
        data, at = self.data, self.at
        if data.startswith(b"<!--", at):
            yield from self._comment()
        elif data.startswith(b"<![CDATA[", at):
            self._pass(b"]]>")
        elif data.startswith(b"<!DOCTYPE", at):
            found = _DOCUMENT_TYPE.match(data, at)
            self.at = len(data) if found is None else found.end()
            if found is not None:
                yield Find(DOCUMENT_TYPE, Edit(at, self.at, ""))
        elif data.startswith(b"<!", at):
            if self._pass(b">"):
                yield Find(STRAY_MARKUP, Edit(at, self.at, ""))
        elif data.startswith(b"<?", at):
            yield from self._instruction()
        elif closing := _CLOSING.match(data, at):
            yield from self._closing(closing)
        elif opening := _OPENING.match(data, at):
            yield from self._opening(opening)
        else:
            self.at = len(data)

    def _pass(self, end: bytes) -> bool:
        """Go behind the next `end`; to the end of the document if there is none."""
        found = self.data.find(end, self.at)
        self.at = len(self.data) if found < 0 else found + len(end)
        return found >= 0

    def _comment(self) -> Iterator[Find]:
        start = self.at + 4
        if self.data.find(b"-->", start) < 0:
            self.at = len(self.data)
            return
        self.at = start
        self._pass(b"-->")
        inner = self.data[start : self.at - 3]
        if _IN_COMMENT.search(inner):
            clean = _IN_COMMENT.sub(lambda found: b"- " if found[0] == b"-" else b" ", inner)
            yield Find(COMMENT_HYPHENS, Edit(start, self.at - 3, clean.decode("utf-8")))

    def _instruction(self) -> Iterator[Find]:
        """An instruction; a declaration of XML must be the first thing of all, and whole."""
        at = self.at
        if not self._pass(b"?>"):
            return
        found = _INSTRUCTION.match(self.data, at)
        if found is None:
            yield Find(STRAY_MARKUP, Edit(at, self.at, ""))
            return
        if found[1].lower() != b"xml":
            yield from self._odd(_CONTROLS, at, self.at)
            return
        first = not self.data[:at].strip(_BLANKS)
        if at > 0 or not _DECLARATION.fullmatch(self.data, at, self.at):
            start = 0 if first else at
            yield Find(DECLARATION_PARDONED, Edit(start, self.at, '<?xml version="1.0"?>' if first else ""))

    def _closing(self, found: re.Match[bytes]) -> Iterator[Find]:
        for stray in (1, 2):
            if found[stray].strip(_BLANKS) or (stray == 1 and found[1]):
                yield Find(STRAY_MARKUP, Edit(*found.span(stray), ""))
        self.depth -= 1
        self.at = found.end()

    def _opening(self, found: re.Match[bytes]) -> Iterator[Find]:
        if found[1]:
            yield Find(STRAY_MARKUP, Edit(found.start(1), found.end(1), ""))
        at = found.end()
        while given := _GIVEN.match(self.data, at):
            if not given[1]:
                yield Find(NO_BLANK, Edit(at, at, " "))
            yield from self._odd(_BETWEEN, at, given.start(2))
            yield from self._odd(_IN_VALUE, given.start(2) + 1, given.end() - 1)
            at = given.end()
        done = _DONE.match(self.data, at)
        if done is None:
            self.at = len(self.data)
            return
        yield from self._odd(_BETWEEN, at, done.end())
        self.begun = True
        self.depth += not done[1]
        self.at = done.end()

    def _text(self, start: int, end: int) -> Iterator[Find]:
        """Text between tags; before the root only blanks are allowed."""
        if self.begun:
            yield from self._odd(_IN_TEXT, start, end)
        elif self.data[start:end].strip(_BLANKS):
            yield Find(STRAY_CHARACTER, Edit(start, end, ""))

    def _odd(self, pattern: re.Pattern[bytes], start: int, end: int) -> Iterator[Find]:
        """Characters that may not stand there as they are."""
        for found in pattern.finditer(self.data, start, end):
            first = found[0][0]
            if first != ord("&"):
                yield Find(STRAY_CHARACTER, Edit(found.start(), found.end(), _REPLACED.get(first, " ")))
            elif not _is_reference(_REFERENCE.match(self.data, found.start(), end)):
                yield Find(UNDEFINED_ENTITY, Edit(found.start(), found.end(), "&amp;"))

    def _tail(self) -> Iterator[Find]:
        """What stands behind the root: comments and instructions alone may."""
        rest = self.data[self.at :]
        if re.fullmatch(rb"(?:[ \t\r\n]++|<!--(?:(?!--).)*+-->|<\?(?:(?!\?>).)*+\?>)*+", rest, re.DOTALL):
            return
        only_ends = re.fullmatch(rb"(?:\s++|</[^<>]*+>)*+", rest) is not None
        yield Find(JUNK_AFTER_END, Edit(self.at, len(self.data), "\n"), guess=not only_ends)


def _is_reference(found: re.Match[bytes] | None) -> bool:
    """Whether it is a reference that XML defines, to a character that XML has."""
    if found is None:
        return False
    code = int(found[1]) if found[1] else int(found[2], 16) if found[2] else 0x20
    return code in (0x9, 0xA, 0xD) or 0x20 <= code <= 0xD7FF or 0xE000 <= code <= 0xFFFD or 0x10000 <= code <= 0x10FFFF
