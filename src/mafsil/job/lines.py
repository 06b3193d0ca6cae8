"""Where in a TOML text a key stands: parsers forget it, but an error should say the line."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

from mafsil.errors import FileError, JobError, MafsilError
from mafsil.job.description import Cell, Job
from mafsil.job.remark import detail_text
from mafsil.messages import say
from mafsil.messages.visible import visible

Path: TypeAlias = tuple[str | int, ...]

_HEADER = re.compile(r"^\s*(\[\[?)\s*([^\[\]#]+?)\s*\]\]?\s*(?:#.*)?$")
_KEY = re.compile(r"""^\s*((?:[A-Za-z0-9_-]+|"[^"]*"|'[^']*')(?:\s*\.\s*(?:[A-Za-z0-9_-]+|"[^"]*"|'[^']*'))*)\s*=""")


class BilingualJobError(JobError):
    """A complaint whose details are themselves sentences, `@area.name`, or know how to say themselves."""

    def message(self, language: str | None = None) -> str:
        """The sentence, in the given language (`en`, `ar`) or the current one."""
        return say(
            self.key, language=language, **{name: detail_text(value, language) for name, value in self.details.items()}
        )


class BilingualFileError(FileError):
    """The same of a file."""

    def message(self, language: str | None = None) -> str:
        """The sentence, in the given language (`en`, `ar`) or the current one."""
        return say(
            self.key, language=language, **{name: detail_text(value, language) for name, value in self.details.items()}
        )


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
        self, text: str, source: str = "", origins: tuple[Path, ...] = (), cells: tuple[Cell, ...] = ()
    ) -> None:
        self.source = source
        self._text = text
        self._origins = origins
        self._cells = cells

    def of(self, job: Job) -> Places:
        """The same for the moves of a job, each where the statement stands that it comes from."""
        return Places(self._text, self.source, job.origins, job.cells)

    def line(self, path: Path) -> int | None:
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

    @cached_property
    def _lines(self) -> dict[Path, int]:
        return _places(self._text)

    def error(self, key: str, path: Path, **details: object) -> JobError:
        """The complaint about a key, with its place."""
        elsewhere = self._include(path)
        if elsewhere is not None:
            places, keys = elsewhere
            return places.error(key, keys, **details)
        line = self.line(path)
        place = f"{self.source}:{line}" if line else self.source
        return BilingualJobError(key, place=place, name=dotted_path(self.as_typed(path)), line=line, **details)

    def of_file(self, fault: MafsilError, path: Path) -> FileError:
        """The complaint about another file, with the place of the key that names it.

        Args:
            fault: what is wrong with that file.
            path: of the key.
        """
        place = self.error("job.file_fault", path)
        return BilingualFileError("job.file_fault", fault=Fault(fault), **place.details)

    def _include(self, path: Path) -> tuple[Places, Path] | None:
        """The places of the included file that a key comes from, and the key in it."""
        for cell in self._cells:
            for here, there in cell.gave:
                if path[: len(here)] == here:
                    return Places(cell.text, cell.source), (*there, *path[len(here) :])
        return None

    def as_typed(self, path: Path) -> Path:
        """Keys of a move as they are typed in the file."""
        if self._origins and len(path) > 1 and path[0] == "move" and isinstance(path[1], int):
            return (*self._origins[path[1]], *path[2:])
        return path


def dotted_path(path: Path) -> str:
    """`move[3].pose`, counting from 1 as people do."""
    text = ""
    for step in path:
        text += f"[{step + 1}]" if isinstance(step, int) else f".{visible(step)}" if text else visible(step)
    return text


def _places(text: str) -> dict[Path, int]:
    places: dict[Path, int] = {}
    counts: dict[Path, int] = {}
    table: Path = ()
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


def _table(words: Path, repeated: bool, counts: dict[Path, int]) -> Path:
    """Path of a table header, with the index of each array of tables on the way."""
    path: Path = ()
    for k, word in enumerate(words):
        path = (*path, word)
        if repeated and k == len(words) - 1:
            counts[path] = counts.get(path, -1) + 1
        if path in counts:
            path = (*path, counts[path])
    return path


def _words(dotted: str) -> Path:
    return tuple(word.strip().strip("\"'") for word in dotted.split("."))
