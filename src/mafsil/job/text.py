"""Texts of job files, and of files that they include.

What is wrong with a text that is no TOML, said in the reader's language: the parser speaks English only.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from mafsil.errors import FileError
from mafsil.job.lines import BilingualFileError
from mafsil.messages.visible import visible
from mafsil.regular_file import is_folder, reason, regular_bytes
from mafsil.toml_source import parsed_toml

REASONS = (
    ("Unclosed array", "array"),
    ("Unclosed inline table", "inline"),
    ("Unterminated string", "string"),
    (r"Illegal character '\n'", "string"),
    ("Illegal character", "character"),
    ("invalid character", "character"),
    ("Invalid initial character", "key"),
    ("Expected '=' after a key", "equals"),
    ("Expected newline or end of document", "newline"),
    ("Expected ']", "header"),
    ("Expected", "string"),
    ("Cannot", "twice"),
    ("Duplicate", "twice"),
    ("Unescaped", "escape"),
    ("Escaped", "escape"),
    ("Invalid hex", "escape"),
    ("Invalid statement", "statement"),
    ("Invalid", "value"),
)
"""Words of the parser -> the sentence for it; the first that is found counts."""
LARGEST_FILE = 20_000_000
"""In bytes: some hundred thousand points."""


def text_of(path: Path, name: str | None = None) -> str:
    """The text of a job file.

    Args:
        path: of the file.
        name: how errors call it; its path if None.

    Raises:
        FileError: missing, unreadable, too large, not UTF-8.
    """
    shown = visible(str(path)) if name is None else name
    if is_folder(path):
        raise FileError("job.directory", path=shown)
    try:
        data = regular_bytes(path, LARGEST_FILE + 1)
    except FileNotFoundError:
        raise FileError("job.no_file", path=shown) from None
    except (OSError, ValueError) as error:
        raise FileError("job.unreadable", path=shown, reason=reason(error)) from None
    if len(data) > LARGEST_FILE:
        raise FileError("job.too_large", path=shown, limit=LARGEST_FILE // 1_000_000)
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise FileError("job.encoding", path=shown, position=error.start, line=line) from None


def tables_of(text: str, source: str) -> dict[str, Any]:
    """The tables of a text.

    Args:
        text: TOML.
        source: name of the file, for errors.

    Raises:
        FileError: it is no TOML.
    """
    try:
        return parsed_toml(text)
    except ValueError as error:
        raise syntax_error(visible(source), str(error)) from None


def syntax_error(source: str, complaint: str) -> FileError:
    """The error of a text that is no TOML.

    Args:
        source: name of the file.
        complaint: what the parser says.
    """
    place = re.search(r"\(at line (\d+), column (\d+)\)", complaint)
    end = "(at end of document)" in complaint
    reason = next((f"@job.toml_{name}" for text, name in REASONS if text in complaint), None)
    if reason is None or not (place or end):
        return FileError("job.syntax", source=source, reason=complaint)
    if place is None:
        return BilingualFileError("job.syntax_end", source=source, reason=reason)
    line, column = map(int, place.groups())
    return BilingualFileError("job.syntax_at", source=source, line=line, column=column, reason=reason)
