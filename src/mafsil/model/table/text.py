"""TOML text: in which line a key stands, which numbers a table holds, and tables written out."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, cast

import numpy as np

_HEADER = re.compile(r"^\s*\[\[?\s*([^\]]*?)\s*\]\]?")


def line_of(text: str, place: str) -> int:
    """The line, counted from 1, of a place such as `$.joint[2].limits.lower`, or of the nearest thing above it.

    Args:
        text: of the file.
        place: path from the root; only `joint` may carry an index that matters.
    """
    keys = re.findall(r"[^.\[\]$]+(?:\[\d+\])?", place)
    if not keys:
        return 1
    lines = text.splitlines()
    head, *rest = keys
    name, _, index = head.rstrip("]").partition("[")
    start, end = _section(lines, name, int(index or 0))
    line = start
    for key in rest:
        line = next((k for k in range(line, end) if _assigns(lines[k], key.partition("[")[0])), line)
    return line + 1


def numbers_of(value: Any, place: str = "$") -> Iterator[tuple[str, float]]:
    """Every number of a decoded table with its place.

    1. A number is itself. 2. A table gives its keys' numbers behind a dot, 3. a list its members' behind an index.
    """
    if isinstance(value, float):  # 1.
        yield place, value
    elif isinstance(value, Mapping):  # 2.
        for key, inner in cast("Mapping[str, Any]", value).items():
            yield from numbers_of(inner, f"{place}.{key}")
    elif isinstance(value, list | tuple):  # 3.
        for k, inner in enumerate(cast("Sequence[Any]", value)):
            yield from numbers_of(inner, f"{place}[{k}]")


def toml_text(root: Mapping[str, object], joints: Iterable[Mapping[str, object]]) -> str:
    """A robot table: keys of the root, its tables, then one `[[joint]]` each; floats keep all their digits."""
    plain = {key: value for key, value in root.items() if not isinstance(value, Mapping)}
    tables = {key: cast("Mapping[str, object]", value) for key, value in root.items() if isinstance(value, Mapping)}
    blocks = [_block("", plain), *(_block(f"[{key}]", value) for key, value in tables.items())]
    return "\n".join([*blocks, *(_block("[[joint]]", joint) for joint in joints)])


def _section(lines: list[str], name: str, index: int) -> tuple[int, int]:
    """First line of the table `name` (its `index`-th, if there are several) or of its key, and the line after it."""
    found = -1
    for start, line in enumerate(lines):
        header = _HEADER.match(line)
        if header and header[1] == name:
            found += 1
            if found == index:
                return start, _section_end(lines, start, name)
    start = next((k for k, line in enumerate(lines) if _assigns(line, name)), 0)
    return start, len(lines)


def _section_end(lines: list[str], start: int, name: str) -> int:
    """The next header that is not a part of the same table."""
    for k in range(start + 1, len(lines)):
        header = _HEADER.match(lines[k])
        if header and not header[1].startswith(f"{name}."):
            return k
    return len(lines)


def _assigns(line: str, key: str) -> bool:
    """Whether the line sets the key, or opens a table that ends in it."""
    name = re.escape(key)
    return bool(re.search(rf"(?:^|[\s{{,.])[\"']?{name}[\"']?\s*=|^\s*\[[^\]]*\b{name}\s*\]", line))


def _block(header: str, fields: Mapping[str, object]) -> str:
    lines = [header] if header else []
    return "\n".join([*lines, *(f"{key} = {_value(value)}" for key, value in fields.items()), ""])


def _value(value: object) -> str:
    """One TOML value on one line."""
    if isinstance(value, np.ndarray):
        return _value(value.tolist())
    if isinstance(value, Mapping):
        return (
            "{ "
            + ", ".join(f"{key} = {_value(inner)}" for key, inner in cast("Mapping[str, object]", value).items())
            + " }"
        )
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_value, cast("Sequence[object]", value))) + "]"
    if isinstance(value, float):
        return repr(float(value))
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
