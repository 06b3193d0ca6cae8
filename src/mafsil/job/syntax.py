"""What is wrong with a text that is no TOML, said in the reader's language: the parser speaks English only."""

from __future__ import annotations

import re

from mafsil.errors import FileError
from mafsil.job.lines import BilingualFileError

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
