"""Whether the tables of a file have the keys that they should: known ones, all that are needed, finite numbers.

Types of what stands in a job file, found from its keys: for complaints that name choices, kinds and places.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache, lru_cache
from types import UnionType
from typing import Annotated, Any, Literal, Union, cast, get_args, get_origin, get_type_hints

import msgspec

from mafsil.errors import JobError
from mafsil.job.language.description import Part
from mafsil.job.language.frames import Complaint
from mafsil.job.language.part import keys_of
from mafsil.job.language.statements import JobFile
from mafsil.job.language.text import Keys
from mafsil.messages import say
from mafsil.messages.visible import visible
from mafsil.other_words import JOB_KEYS

LARGEST_NUMBER = 1e9
"""Of any quantity of a job: larger than that is a slip of the unit or the exponent."""
TYPES = {
    "float": "number",
    "int": "whole",
    "str": "text",
    "bool": "truth",
    "array": "list",
    "object": "table",
    "null": "nothing",
}
"""Types of the parser -> how people call them."""
_MOST_CLOSE = 3


@dataclass(frozen=True, slots=True)
class _Types:
    """What a value may be, in the reader's language."""

    names: tuple[str, ...]

    def explain(self, *, language: str | None = None) -> str:
        """`a number or a list`."""
        words = [say(f"job.type_{name}", language=language) for name in self.names if name != "nothing"]
        return say("job.type_or", language=language).join(words)


def refuse_unknown(data: Any, kind: type[Part], path: Keys, error: Complaint) -> None:
    """Every key of every table is one that we know; close matches are offered."""
    known = keys_of(kind)
    for name, value in data.items():
        here = (*path, name)
        if name not in known:
            former = JOB_KEYS.get(str(name))
            close = [former] if former in known else get_close_matches(str(name), known, n=_MOST_CLOSE, cutoff=0.55)
            key = "job.unknown_key_close" if close else "job.unknown_key"
            raise error(key, here, close=", ".join(close), known=", ".join(known))
        for inner, place, part in tables_in(value, field_type(kind, known[name]), here):
            refuse_unknown(inner, part, place, error)


def require_keys(data: Any, kind: type[Part], path: Keys, error: Complaint) -> None:
    """Every key without a default is there."""
    for field in _fields(kind):
        name = field.encode_name
        if field.required and name not in data:
            raise error("job.missing_key", (*path, name))
        if name in data:
            for inner, place, part in tables_in(data[name], field.type, (*path, name)):
                require_keys(inner, part, place, error)


@cache
def _fields(kind: type[Part]) -> tuple[msgspec.structs.FieldInfo, ...]:
    """The fields of a table, whose types msgspec evaluates anew each time that it is asked."""
    return msgspec.structs.fields(kind)


def refuse_not_finite(value: Any, path: Keys, error: Complaint) -> None:
    """TOML knows nan and inf; a job does not, nor numbers of which nothing but overflow can come."""
    if isinstance(value, float) and not math.isfinite(value):
        raise error("job.not_finite", path, value=value)
    if isinstance(value, float | int) and abs(value) > LARGEST_NUMBER and path[-1] != "seed":
        raise error("job.too_large_number", path, value=f"{value:g}", limit=f"{LARGEST_NUMBER:g}")
    items: Iterable[tuple[str | int, Any]] = ()
    if isinstance(value, dict):
        items = cast("dict[str, Any]", value).items()
    elif isinstance(value, list):
        items = enumerate(cast("list[Any]", value))
    for name, inner in items:
        refuse_not_finite(inner, (*path, name), error)


def translate_complaint(found: msgspec.ValidationError, data: Any, error: Complaint) -> JobError:
    """Msgspec's complaint with its path, in our words."""
    text = str(found)
    path = path_of(text, data)
    value = value_at(data, path)
    details = {"got": visible(repr(value))[:60], "reason": text.split(" - at ")[0].replace("`", "")}
    if length := re.search(r"of length (\d+)", text):
        return error("job.length", path, expected=length.group(1), **details)
    if "Invalid enum value" in text:
        known = ", ".join(choices_at(path))
        return error("job.choice", path, known=known, **details)
    if bound := re.search(r"Expected `\w+` (<=|>=|<|>) (\S+)", text):
        return error("job.bound", path, relation=bound.group(1), limit=bound.group(2), **details)
    if kind := re.search(r"Expected `([^`]+)`, got `([^`]+)`", text):
        expected = _Types(tuple(TYPES[one] for one in kind.group(1).split(" | ") if one in TYPES))
        return error("job.type", path, expected=expected, **details)
    return error("job.wrong", path, **details)


def field_type(kind: type[Part], name: str) -> Any:
    """Of a key of a table, without bounds of numbers."""
    return _hints(kind)[name]


@lru_cache
def _hints(kind: type[Part]) -> dict[str, Any]:
    return get_type_hints(kind)


def tables_in(value: Any, annotation: Any, path: Keys) -> Iterator[tuple[dict[str, Any], Keys, type[Part]]]:
    """The tables inside a value, with their places and types."""
    if get_origin(annotation) is dict:
        for name, item in cast("dict[str, Any]", value).items() if isinstance(value, dict) else ():
            yield from tables_in(item, get_args(annotation)[1], (*path, name))
        return
    inner = get_args(annotation)
    for option in (annotation, *inner, *(part for one in inner for part in get_args(one))):
        if isinstance(option, type) and issubclass(option, Part):
            if isinstance(value, dict):
                yield value, path, option
            elif isinstance(value, list) and any(get_origin(one) is tuple for one in (annotation, *inner)):
                for k, item in enumerate(cast("list[Any]", value)):
                    if isinstance(item, dict):
                        yield item, (*path, k), option
            return


def path_of(text: str, data: Any) -> Keys:
    """`$.move[2].pose` as ("move", 2, "pose"); msgspec leaves out names of tables: the first that is wrong is meant."""
    found = re.search(r"at `\$([^`]*)`", text)
    steps = re.findall(r"\.([^.\[\]]+)|\[(\d+)\]|(\[\.\.\.\])", found.group(1)) if found else []
    path: Keys = ()
    for name, index, some in steps:
        path = (*path, _wrong_name(data, path) if some else name or int(index))
    return path


def _wrong_name(data: Any, path: Keys) -> str:
    """The first name of a table of names whose value is of the wrong kind."""
    kind = next(get_args(each)[1] for each in _options(_annotation(path)) if get_origin(each) is dict)
    table = cast("dict[str, Any]", value_at(data, path))
    for name, value in table.items():
        try:
            msgspec.convert(value, kind, strict=True)
        except msgspec.ValidationError:
            return name
    return next(iter(table), "")


def _annotation(path: Keys) -> Any:
    """The type of what stands at a place of a job file."""
    kind: Any = JobFile
    for step in path:
        options = _options(kind)
        if isinstance(step, int):
            rows = next(get_args(each) for each in options if get_origin(each) is tuple)
            kind = rows[0] if rows[-1] is ... else rows[min(step, len(rows) - 1)]
            continue
        named = [get_args(each)[1] for each in options if get_origin(each) is dict]
        tables = [each for each in options if isinstance(each, type) and issubclass(each, Part)]
        fields = [(each, keys_of(each)) for each in tables]
        kind = named[0] if named else next(field_type(each, keys[step]) for each, keys in fields if step in keys)
    return kind


def _options(annotation: Any) -> tuple[Any, ...]:
    """What a type allows: the members of a union, else the type itself; without bounds of numbers."""
    if get_origin(annotation) in (Union, UnionType):
        return tuple(each for member in get_args(annotation) for each in _options(member))
    return _options(get_args(annotation)[0]) if get_origin(annotation) is Annotated else (annotation,)


def value_at(data: Any, path: Keys) -> Any:
    """What stands at a place of the tables of a file."""
    for step in path:
        data = data[step]
    return data


def choices_at(path: Keys) -> tuple[str, ...]:
    """The texts of which the key at a place takes one."""
    options = _options(_annotation(path))
    return tuple(str(x) for option in options if get_origin(option) is Literal for x in get_args(option))
