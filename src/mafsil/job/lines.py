"""Where in a TOML text a key stands: parsers forget it, but an error should say the line."""

from __future__ import annotations

import re
from typing import TypeAlias

Path: TypeAlias = tuple[str | int, ...]

_HEADER = re.compile(r"^\s*(\[\[?)\s*([^\[\]#]+?)\s*\]\]?\s*(?:#.*)?$")
_KEY = re.compile(r"""^\s*((?:[A-Za-z0-9_-]+|"[^"]*"|'[^']*')(?:\s*\.\s*(?:[A-Za-z0-9_-]+|"[^"]*"|'[^']*'))*)\s*=""")


def line_of(text: str, path: Path) -> int | None:
    """Line, counted from 1, of a key; of the nearest enclosing table if the key stands inside a value or is missing.

    Args:
        text: the TOML text.
        path: keys and indices, such as ("move", 2, "pose", "position").
    """
    places = _places(text)
    for length in range(len(path), 0, -1):
        if path[:length] in places:
            return places[path[:length]]
    return None


def _places(text: str) -> dict[Path, int]:
    places: dict[Path, int] = {}
    counts: dict[Path, int] = {}
    table: Path = ()
    for number, line in enumerate(text.splitlines(), start=1):
        if header := _HEADER.match(line):
            table = _table(_words(header.group(2)), header.group(1) == "[[", counts)
            places.setdefault(table, number)
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
