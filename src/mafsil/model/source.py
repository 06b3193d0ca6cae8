"""From what a caller hands over (path, text or bytes) to a document in clean UTF-8, or one diagnostic."""

from __future__ import annotations

import codecs
import re
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeAlias

from mafsil.model.diagnostics import Diagnostic, Edit, Fault, Repair, shown
from mafsil.model.faults import (
    BYTE_ORDER_MARK,
    CONVERTED_ENCODING,
    EMPTY,
    ENCODING,
    FILE_MISSING,
    GUESSED_ENCODING,
    NOT_A_FILE,
    NUL_BYTE,
    TOO_LARGE,
    UNKNOWN_ENCODING,
    WRONG_ENCODING,
)
from mafsil.model.xml_tree import DEFAULT_LIMITS, ReadLimits, Refusal
from mafsil.regular_file import regular_bytes

Source: TypeAlias = str | Path | bytes
"""A path, or the document itself: bytes, or a str that begins with `<`."""

_DECLARATION = re.compile(rb"""^\s*<\?xml[^>]*?encoding\s*=\s*["']([A-Za-z0-9._-]{1,40})["']""")
_NO_ENCODINGS = ("idna", "punycode", "raw-unicode-escape", "unicode-escape")
"""Codecs of Python that write no text of files; some take time that grows with the square of what they read."""
_OF_MARKUP = "".join(map(chr, (*range(0x20, 0x5C), *range(0x5D, 0x7E))))
"""Characters that XML and numbers are written in: an encoding in which its own name can be read has them as ASCII."""
_WIDE_MARKS = ((codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16"))
_UNMARKED_WIDE = ((b"<\0", "utf-16-le"), (b"\0<", "utf-16-be"))


@dataclass(frozen=True, slots=True)
class Text:
    """A document ready for the parser.

    Attributes:
        name: of the file, or `<text>`.
        data: the document in UTF-8 without byte order mark.
        folder: where the file lies, or None for a text.
        remarks: about the encoding.
    """

    name: str
    data: bytes
    folder: Path | None
    remarks: tuple[Diagnostic, ...] = ()


def name_of(source: Source) -> str:
    """The name under which a source stands in reports."""
    return "<text>" if _is_text(source) else str(source)


def load(source: Source, limits: ReadLimits = DEFAULT_LIMITS) -> Text:
    """Read and decode a source.

    Raises:
        Refusal: no such file, not a regular file, too large, empty, a NUL byte, not in its encoding.
    """
    if isinstance(source, bytes):
        data, folder = source, None
    elif isinstance(source, str) and _is_text(source):
        data, folder = source.encode("utf-8", "surrogatepass"), None
    else:
        path = Path(source)
        data, folder = _read(path, limits), path.parent
    if len(data) > limits.bytes:
        raise _refusal(TOO_LARGE, limit=limits.bytes)
    clean, remarks = _decode(data)
    if not clean.strip():
        raise _refusal(EMPTY)
    return Text(name_of(source), clean, folder, remarks)


def _is_text(source: Source) -> bool:
    return isinstance(source, bytes) or (isinstance(source, str) and source.lstrip("\ufeff \t\r\n").startswith("<"))


def _read(path: Path, limits: ReadLimits) -> bytes:
    """At most one byte more than the limit of a regular file."""
    name = shown(str(path))
    try:
        return regular_bytes(path, limits.bytes + 1)
    except FileNotFoundError:
        raise _refusal(FILE_MISSING, path=name) from None
    except (OSError, ValueError):
        raise _refusal(NOT_A_FILE, path=name) from None


def _decode(data: bytes) -> tuple[bytes, tuple[Diagnostic, ...]]:
    """The document as UTF-8, and what had to be said about its encoding."""
    if data.startswith(codecs.BOM_UTF8):
        data = data[len(codecs.BOM_UTF8) :]
        return _check(data), (Diagnostic(BYTE_ORDER_MARK, 1, 1),)
    for mark, encoding in (*_WIDE_MARKS, *_UNMARKED_WIDE):
        if data.startswith(mark):
            return _convert(data, encoding, "UTF-16")
    declared = _DECLARATION.match(data[:200])
    if declared is None:
        return _utf8_or_guessed(data)
    name = declared.group(1).decode("ascii")
    encoding = _encoding(name)
    if encoding == "utf-8":
        return _utf8_or_guessed(data)
    if encoding is not None and _writes_markup(encoding):
        return _convert(data, encoding, name)
    fault = UNKNOWN_ENCODING if encoding is None else WRONG_ENCODING
    return _misdeclared(fault, data, name, declared.start(1), declared.end(1))


def _encoding(name: str) -> str | None:
    """Python's name of an encoding of text; None if it has none."""
    try:
        encoding = codecs.lookup(name).name
        with suppress(UnicodeError):
            b"<".decode(encoding)  # a codec of bytes, such as hex, says so by a LookupError
    except LookupError:
        return None
    if encoding in _NO_ENCODINGS:
        return None
    return "utf-8" if encoding == "ascii" else encoding


def _writes_markup(encoding: str) -> bool:
    """Whether text in this encoding could hold a declaration that names it."""
    try:
        return _OF_MARKUP.encode("ascii").decode(encoding) == _OF_MARKUP
    except UnicodeError:
        return False


def _utf8_or_guessed(data: bytes) -> tuple[bytes, tuple[Diagnostic, ...]]:
    """A document that declares no other encoding than UTF-8; where it is not UTF-8, it is read as Western text."""
    try:
        return _check(data), ()
    except Refusal as refusal:
        if refusal.diagnostic.fault is not ENCODING:
            raise
        found = refusal.diagnostic
    for encoding in ("windows-1252", "iso-8859-1"):
        with suppress(UnicodeDecodeError):
            text = data.decode(encoding)
            details = found.details | {"encoding": encoding}
            repair = Repair("robotfile.repair_save_utf8", ())
            return text.encode("utf-8"), (Diagnostic(GUESSED_ENCODING, found.line, found.column, details, repair),)
    raise Refusal(found)


def _misdeclared(fault: Fault, data: bytes, name: str, start: int, end: int) -> tuple[bytes, tuple[Diagnostic, ...]]:
    """An encoding that is unknown, or that these bytes cannot be in; the repair declares UTF-8 where they are UTF-8."""
    remark = Diagnostic(fault, 1, start + 1, {"encoding": name})
    try:
        _check(data)
    except Refusal:
        raise Refusal(replace(remark, fault=UNKNOWN_ENCODING)) from None
    return data, (replace(remark, repair=Repair("robotfile.repair_declare_utf8", (Edit(start, end, "UTF-8"),))),)


def _convert(data: bytes, encoding: str, name: str) -> tuple[bytes, tuple[Diagnostic, ...]]:
    try:
        text = data.decode(encoding)
    except UnicodeError as error:
        raise _refusal(ENCODING, encoding=name, offset=getattr(error, "start", 0)) from None
    remark = Diagnostic(CONVERTED_ENCODING, 1, 1, {"encoding": name})
    return _check(_as_utf8_declaration(text).encode("utf-8", "replace")), (remark,)


def with_readable_tags(data: bytes) -> bytes:
    """The beginning of a document, as bytes in which tags stand as in ASCII, whatever its encoding."""
    for mark, encoding in (*_WIDE_MARKS, *_UNMARKED_WIDE):
        if data.startswith(mark):
            return data.decode(encoding, "replace").encode("utf-8", "replace")
    return data


def _as_utf8_declaration(text: str) -> str:
    return re.sub(r"""(<\?xml[^>]*?encoding\s*=\s*["'])[A-Za-z0-9._-]+""", r"\1UTF-8", text, count=1)


def _check(data: bytes) -> bytes:
    """The bytes, if they are UTF-8 without NUL."""
    if (at := data.find(b"\0")) >= 0:
        raise Refusal(_at(NUL_BYTE, data, at, offset=at))
    try:
        data.decode("utf-8")
    except UnicodeDecodeError as error:
        raise Refusal(_at(ENCODING, data, error.start, encoding="UTF-8", offset=error.start)) from None
    return data


def _at(fault: Fault, data: bytes, at: int, **details: object) -> Diagnostic:
    line = data.count(b"\n", 0, at) + 1
    return Diagnostic(fault, line, at - data.rfind(b"\n", 0, at), details)


def _refusal(fault: Fault, **details: object) -> Refusal:
    return Refusal(Diagnostic(fault, 0, 0, details))
