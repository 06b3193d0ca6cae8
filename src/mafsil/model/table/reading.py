"""Robot tables from files: size, encoding, form, then numbers.

Their text is TOML: in which line a key stands, which numbers a table holds, and tables written out (`toml_text`).
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from difflib import get_close_matches
from functools import cache
from pathlib import Path
from typing import Any, cast, get_args

import msgspec
import numpy as np

from mafsil.errors import FileError
from mafsil.model.inertia_check import warned_of_impossible
from mafsil.model.mechanism import Mechanism
from mafsil.model.table.building import KEYS, RobotTable, mechanism_of
from mafsil.regular_file import reason, regular_bytes
from mafsil.toml_source import parsed_toml

_HEADER = re.compile(r"^\s*\[\[?\s*([^\]]*?)\s*\]\]?")
JOB_KEYS = ("robot", "move", "start", "controller", "title")
"""Keys of job files that no robot table has."""
SIZE_LIMIT = 1_000_000
"""Largest file that is read [bytes]; a table of a hundred joints has 30 000."""


def read(path: str | Path) -> Mechanism:
    """The robot of a TOML file.

    Args:
        path: of the file; at most SIZE_LIMIT bytes, UTF-8.

    Raises:
        FileError: the file is missing, too large, not UTF-8, not TOML, or a key has the wrong type, is unknown or does
            not belong to the convention; the sentence names the line.
        ModelError: the numbers describe no mechanism.
    """
    file = Path(path)
    try:
        data = regular_bytes(file, SIZE_LIMIT + 1)
    except (OSError, ValueError) as error:
        raise FileError("table.open", path=str(file), reason=reason(error)) from None
    if len(data) > SIZE_LIMIT:
        raise FileError("table.size", path=str(file), limit=SIZE_LIMIT)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise FileError("table.utf8", path=str(file), line=data[: error.start].count(b"\n") + 1) from None
    return parse(text, str(file))


def parse(text: str, path: str = "<text>") -> Mechanism:
    """The robot of a TOML text; `path` is named in errors.

    Raises:
        FileError, ModelError: as `read`.
    """
    return warned_of_impossible(mechanism_of(decode(text, path)))


def decode(text: str, path: str) -> RobotTable:
    """The text as a table of the right form, or the line where it is not."""
    try:
        found = parsed_toml(text)
    except ValueError as error:
        raise FileError("table.toml", path=path, reason=str(error)) from None
    return table_of(found, text, path)


def table_of(found: dict[str, Any], text: str, path: str) -> RobotTable:
    """Parsed TOML as a table of the right form; `text`, where it is known, gives the lines of errors."""
    _require_robot(found, path)
    _require_known(found, RobotTable, "$", text, path)
    try:
        table = msgspec.convert(found, RobotTable)
    except msgspec.ValidationError as error:
        reason, _, place = str(error).partition(" - at ")
        named = re.search(r"field `(\w+)`", reason)
        where = (place.strip("`") or "$") + (f".{named[1]}" if named else "")
        raise FileError("table.form", path=path, line=line_of(text, where), place=where, reason=reason) from None
    _require_finite(table, text, path)
    _require_moments(table, text, path)
    _require_own_keys(table, text, path)
    return table


def _require_robot(found: dict[str, Any], path: str) -> None:
    """A job file is distinguished from a robot table, as both are TOML."""
    of_job = sorted(key for key in JOB_KEYS if key in found)
    if of_job and "joint" not in found and "convention" not in found:
        raise FileError("table.job", path=path, keys=", ".join(of_job))


def _require_known(found: Mapping[str, Any], form: type[msgspec.Struct], place: str, text: str, path: str) -> None:
    """Every key of every table is known; what looks like a misspelt one is offered."""
    fields = _fields_of(form)
    for key, value in found.items():
        here = f"{place}.{key}"
        if key not in fields:
            close = get_close_matches(key, fields, n=3, cutoff=0.55)
            sentence = "table.unknown_close" if close else "table.unknown"
            details = {"close": ", ".join(close), "known": ", ".join(fields)}
            raise FileError(sentence, path=path, line=line_of(text, here), place=here, **details)
        inner = fields[key]
        tables = cast("list[Any]", value) if isinstance(value, list) else [value]
        for k, table in enumerate(tables if inner is not None else []):
            if inner is not None and isinstance(table, Mapping):
                step = f"{here}[{k}]" if isinstance(value, list) else here
                _require_known(cast("Mapping[str, Any]", table), inner, step, text, path)


@cache
def _fields_of(form: type[msgspec.Struct]) -> dict[str, type[msgspec.Struct] | None]:
    """Its keys, each with the table that stands under it, or None."""
    return {
        field.name: next((part for part in _parts_of(field.type) if issubclass(part, msgspec.Struct)), None)
        for field in msgspec.structs.fields(form)
    }


def _parts_of(annotation: Any) -> Iterator[type]:
    """The plain types in an annotation."""
    if isinstance(annotation, type) and not get_args(annotation):
        yield annotation
    for part in get_args(annotation):
        yield from _parts_of(part)


def _require_finite(table: RobotTable, text: str, path: str) -> None:
    """No NaN anywhere, and infinities in limits alone."""
    for place, value in numbers_of(msgspec.to_builtins(table)):
        if not np.isfinite(value) and (np.isnan(value) or ".limits." not in place):
            raise FileError("table.finite", path=path, line=line_of(text, place), place=place, value=value)


def _require_moments(table: RobotTable, text: str, path: str) -> None:
    """An inertia has three numbers or six."""
    for k, joint in enumerate(table.joint):
        if joint.inertial is not None and len(joint.inertial.inertia) not in (3, 6):
            place = f"$.joint[{k}].inertial.inertia"
            raise FileError(
                "table.moments", path=path, line=line_of(text, place), place=place, got=len(joint.inertial.inertia)
            )


def _require_own_keys(table: RobotTable, text: str, path: str) -> None:
    """Every joint has the keys of the file's convention and no others; `home` belongs to screws."""
    own = KEYS[table.convention]
    for k, joint in enumerate(table.joint):
        for key in sorted({key for keys in KEYS.values() for key in keys}):
            place = f"$.joint[{k}].{key}"
            if getattr(joint, key) is not None and key not in own:
                raise FileError(
                    "table.foreign", path=path, line=line_of(text, place), field=key, convention=table.convention
                )
        if "screw" in own and joint.screw is None:
            place = f"$.joint[{k}]"
            raise FileError(
                "table.missing", path=path, line=line_of(text, place), field="screw", convention=table.convention
            )
    if ("screw" in own) != (table.home is not None):
        key = "table.missing" if table.home is None else "table.foreign"
        raise FileError(key, path=path, line=line_of(text, "$.home"), field="home", convention=table.convention)


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
