"""Texts of job files and of files that they include: read, parsed, and where in them each key stands.

What is wrong with a text that is no TOML is said in the reader's language, for the parser speaks English only; and it
forgets where keys stand, but an error should say the line.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, TypeAlias

from mafsil.errors import FileError, JobError, MafsilError
from mafsil.job.language.description import Cell, Job
from mafsil.job.remark import say_with
from mafsil.messages.visible import visible
from mafsil.regular_file import is_folder, reason, regular_bytes
from mafsil.toml_source import parsed_toml

Keys: TypeAlias = tuple[str | int, ...]
_HEADER = re.compile(r"^\s*(\[\[?)\s*([^\[\]#]+?)\s*\]\]?\s*(?:#.*)?$")
_KEY = re.compile(r"""^\s*((?:[A-Za-z0-9_-]+|"[^"]*"|'[^']*')(?:\s*\.\s*(?:[A-Za-z0-9_-]+|"[^"]*"|'[^']*'))*)\s*=""")
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


class BilingualJobError(JobError):
    """A complaint whose details are themselves sentences, `@area.name`, or know how to say themselves."""

    def message(self, language: str | None = None) -> str:
        """The sentence, in the given language (`en`, `ar`) or the current one."""
        return say_with(self.key, self.details, language)


class BilingualFileError(FileError):
    """The same of a file."""

    def message(self, language: str | None = None) -> str:
        """The sentence, in the given language (`en`, `ar`) or the current one."""
        return say_with(self.key, self.details, language)


@dataclass(frozen=True, slots=True)
class Fault:
    """A complaint inside another one."""

    error: MafsilError

    def explain(self, *, language: str | None = None) -> str:
        """Its sentence."""
        return self.error.message(language)


class Places:
    """Where the keys of a text stand.

    Args:
        text: TOML.
        source: name of the file, for errors.
        origins: for each move the keys of the statement that it comes from.
        cells: files that it includes.
    """

    def __init__(
        self, text: str, source: str = "", origins: tuple[Keys, ...] = (), cells: tuple[Cell, ...] = ()
    ) -> None:
        self.source = source
        self._text = text
        self._origins = origins
        self._cells = cells

    def of(self, job: Job) -> Places:
        """The same for the moves of a job, each where the statement stands that it comes from."""
        return Places(self._text, self.source, job.origins, job.cells)

    def line(self, path: Keys) -> int | None:
        """Line, counted from 1, of a key; of the nearest enclosing table if the key stands in a value or is missing.

        None of what stands nowhere, or in an included file.

        Args:
            path: keys and indices, such as ("move", 2, "pose", "position").
        """
        path = self.as_typed(path)
        if self._include(path) is not None:
            return None
        for length in range(len(path), 0, -1):
            if path[:length] in self._lines:
                return self._lines[path[:length]]
        return None

    def has_line(self, path: Keys) -> bool:
        """Whether a key stands at the beginning of a line of this text."""
        typed = self.as_typed(path)
        return typed in self._lines and self._include(typed) is None

    @cached_property
    def _lines(self) -> dict[Keys, int]:
        return _places(self._text)

    def error(self, key: str, path: Keys, **details: object) -> JobError:
        """The complaint about a key, with its place."""
        elsewhere = self._include(path)
        if elsewhere is not None:
            places, keys = elsewhere
            return places.error(key, keys, **details)
        line = self.line(path)
        place = f"{self.source}:{line}" if line else self.source
        return BilingualJobError(key, place=place, name=dotted_path(self.as_typed(path)), line=line, **details)

    def of_file(self, fault: MafsilError, path: Keys) -> FileError:
        """The complaint about another file, with the place of the key that names it.

        Args:
            fault: what is wrong with that file.
            path: of the key.
        """
        place = self.error("job.file_fault", path)
        return BilingualFileError("job.file_fault", fault=Fault(fault), **place.details)

    def _include(self, path: Keys) -> tuple[Places, Keys] | None:
        """The places of the included file that a key comes from, and the key in it."""
        for cell in self._cells:
            for here, there in cell.gave:
                if path[: len(here)] == here:
                    return Places(cell.text, cell.source), (*there, *path[len(here) :])
        return None

    def as_typed(self, path: Keys) -> Keys:
        """Keys of a move as they are typed in the file."""
        if self._origins and len(path) > 1 and path[0] == "move" and isinstance(path[1], int):
            return (*self._origins[path[1]], *path[2:])
        return path


def dotted_path(path: Keys) -> str:
    """`move[3].pose`, counting from 1 as people do."""
    text = ""
    for step in path:
        text += f"[{step + 1}]" if isinstance(step, int) else f".{visible(step)}" if text else visible(step)
    return text


def _places(text: str) -> dict[Keys, int]:
    places: dict[Keys, int] = {}
    counts: dict[Keys, int] = {}
    table: Keys = ()
    for number, line in enumerate(text.splitlines(), start=1):
        if header := _HEADER.match(line):
            table = _table(_words(header.group(2)), header.group(1) == "[[", counts)
            places.setdefault(table, number)
            if isinstance(table[-1], int):
                places.setdefault(table[:-1], number)
        elif key := _KEY.match(line):
            words = _words(key.group(1))
            for length in range(1, len(words) + 1):
                places.setdefault((*table, *words[:length]), number)
    return places


def _table(words: Keys, repeated: bool, counts: dict[Keys, int]) -> Keys:
    """Path of a table header, with the index of each array of tables on the way."""
    path: Keys = ()
    for k, word in enumerate(words):
        path = (*path, word)
        if repeated and k == len(words) - 1:
            counts[path] = counts.get(path, -1) + 1
        if path in counts:
            path = (*path, counts[path])
    return path


def _words(dotted: str) -> Keys:
    return tuple(word.strip().strip("\"'") for word in dotted.split("."))
