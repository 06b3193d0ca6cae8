"""Texts of job files, and of files that they include."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from mafsil.errors import FileError
from mafsil.job.syntax import syntax_error
from mafsil.messages.visible import visible
from mafsil.regular_file import reason, regular_bytes
from mafsil.toml_source import parsed_toml

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
    if path.is_dir():
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
