"""Whether the tables of a file have the keys that they should: known ones, all that are needed, finite numbers."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from typing import Any, cast

import msgspec

from mafsil.errors import JobError
from mafsil.job.description import Part
from mafsil.job.language.frames import Complaint
from mafsil.job.language.types_of_keys import choices_at, field_type, path_of, tables_in, value_at
from mafsil.job.lines import Path
from mafsil.job.part import keys_of
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


def refuse_unknown(data: Any, kind: type[Part], path: Path, error: Complaint) -> None:
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


def require_keys(data: Any, kind: type[Part], path: Path, error: Complaint) -> None:
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


def refuse_not_finite(value: Any, path: Path, error: Complaint) -> None:
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


def translated(found: msgspec.ValidationError, data: Any, error: Complaint) -> JobError:
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
