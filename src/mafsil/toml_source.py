"""TOML from strangers: what would take the parser minutes is refused before it sees it."""

from __future__ import annotations

import re
import tomllib
from os import PathLike
from pathlib import Path
from typing import Any, cast

from mafsil.errors import FileError
from mafsil.messages import say
from mafsil.regular_file import reason, whole_text

LARGEST_FILE = 1_000_000
"""Bytes of a file of a mechanism, by far more than any needs."""

LONGEST_KEY = 32
"""Most parts of a dotted key: the parser's time and memory grow with their square."""

_PART = r"""(?:(?<![\w-])[\w-]++|"[^"\n]*+"|'[^'\n]*+')"""
_LONG_KEY = re.compile(rf"{_PART}(?:[ \t]*+\.[ \t]*+(?:[\w-]++|\"[^\"\n]*+\"|'[^'\n]*+')){{{LONGEST_KEY}}}")


def parsed_toml(text: str) -> dict[str, Any]:
    """The tables of a TOML text.

    Args:
        text: of a file whose size the caller has bounded.

    Raises:
        ValueError: it is no TOML, or a key has more than LONGEST_KEY parts, or it nests too deeply; the sentence says
            where.
    """
    found = _LONG_KEY.search(text)
    if found:
        line = text.count("\n", 0, found.start()) + 1
        raise ValueError(say("input.toml_key", line=line, limit=LONGEST_KEY))
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise ValueError(say("input.toml_depth")) from None


def own_tables(module: str, name: str = "") -> dict[str, Any]:
    """The tables of a TOML file of this package.

    Args:
        module: path of the module beside which it lies, its `__file__`.
        name: of the file; that of the module if empty.
    """
    place = Path(module)
    return tomllib.loads((place.with_name(name) if name else place.with_suffix(".toml")).read_text("utf-8"))


def read_toml(path: str | PathLike[str]) -> dict[str, Any]:
    """The tables of a file of a mechanism.

    Args:
        path: of the file.

    Raises:
        FileError: missing, unreadable, larger than LARGEST_FILE, or no TOML.
    """
    if not isinstance(cast("object", path), (str, PathLike)):
        raise FileError("input.kind", name="path", expected="text or a path", got=type(path).__name__)
    file = Path(path)
    try:
        text = whole_text(file, LARGEST_FILE)
    except (OSError, ValueError) as fault:
        raise FileError("mobility.file_unreadable", path=str(path), reason=reason(fault)) from None
    try:
        return parsed_toml(text)
    except ValueError as error:
        raise FileError("mobility.file_malformed", path=str(path), reason=str(error)) from None
