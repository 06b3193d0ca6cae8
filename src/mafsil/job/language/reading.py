"""Job files in, checked jobs out, and the JSON Schema of such files; complaints name the key, the line, the remedy.

Tables have the keys that they should: known ones, all that are needed, finite numbers. The types that complaints name
are found from the keys.
"""

from __future__ import annotations

import inspect
import json
import math
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache, lru_cache
from os import PathLike
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Literal, Union, cast, get_args, get_origin, get_type_hints

import msgspec

from mafsil.errors import JobError
from mafsil.job.language.cells import fill_variables, with_cells
from mafsil.job.language.description import Job, Part, SceneFile
from mafsil.job.language.frames import Complaint
from mafsil.job.language.move_checks import check_pose, check_statements, require_grips, require_keepable, require_order
from mafsil.job.language.part import keys_of
from mafsil.job.language.resolving import check_programs, other_robots, resolve
from mafsil.job.language.statements import JobFile
from mafsil.job.language.table_checks import check_obstacles, check_tables, require_signals
from mafsil.job.language.text import Keys, Places, tables_of, text_of
from mafsil.job.language.units import in_si
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


def read_job(path: str | PathLike[str]) -> Job:
    """The job in a file.

    Args:
        path: a TOML file.

    Raises:
        FileError: it cannot be read, or is no TOML.
        JobError: a key is unknown, missing, of the wrong type or out of range.
    """
    place = Path(path)
    return parse_job(text_of(place), source=place.name, folder=place.parent)


def parse_job(
    text: str,
    source: str = "<text>",
    variables: Mapping[str, object] | None = None,
    *,
    folder: str | PathLike[str] | None = None,
) -> Job:
    """The job in a text.

    Args:
        text: TOML.
        source: name of the file, for errors.
        variables: values by name, instead of those of the file.
        folder: to which paths of included files are relative; the present one if None.

    Raises:
        FileError: it is no TOML, or includes a file that cannot be read.
        JobError: a key is unknown, missing, of the wrong type or out of range; a variable is unknown.
    """
    data = tables_of(text, source)
    place = Path(folder or "")
    data, cells = with_cells(data, place, Places(text, visible(source)))
    places = Places(text, visible(source), cells=cells)
    data = fill_variables(data, variables or {}, places.error)
    file = _check(data, places.error)
    metric = in_si(file, data)
    others = other_robots(metric.other_robot, places.error)
    job = msgspec.structs.replace(resolve(metric, others, place, places.error), cells=cells)
    if not job.move:
        raise places.error("job.no_moves", ("move",))
    require_order(job, places.of(job).error)
    require_keepable(job, places.of(job).error)
    require_grips(job, places.error)
    return job


def parse_scene(text: str, source: str = "<text>") -> SceneFile:
    """Obstacles from a text: `[[obstacle]]` tables as in job files; arguments and errors as `parse_job`."""
    data, places = tables_of(text, source), Places(text, visible(source))
    refuse_unknown(data, SceneFile, (), places.error)
    require_keys(data, SceneFile, (), places.error)
    try:
        found = msgspec.convert(data, SceneFile, strict=True)
    except msgspec.ValidationError as error:
        raise translate_complaint(error, data, places.error) from None
    refuse_not_finite(data, (), places.error)
    check_obstacles(found.obstacle, data["obstacle"], places.error)
    return in_si(found, data)


def _check(data: dict[str, Any], error: Complaint) -> JobFile:
    """The checked statements of a file."""
    refuse_unknown(data, JobFile, (), error)
    require_keys(data, JobFile, (), error)
    try:
        file = msgspec.convert(data, JobFile, strict=True)
    except msgspec.ValidationError as found:
        raise translate_complaint(found, data, error) from None
    refuse_not_finite(data, (), error)
    for name in ("frame", "pose", "pattern"):
        for each, placed in getattr(file, name).items():
            check_pose(placed, (name, each), data[name][each], error)
    check_statements(file.move, ("move",), data["move"], error)
    for name, moves in file.group.items():
        check_statements(moves, ("group", name), data["group"][name], error)
    check_tables(file, data, error)
    check_programs(file.other_robot, error)
    require_signals(file, error)
    return file


def schema() -> dict[str, Any]:
    """JSON Schema (2020-12) of a job file: every key with its type, range and choices."""
    head = {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": "mafsil job"}
    text = msgspec.json.encode(msgspec.json.schema(JobFile))
    return head | json.loads(text, object_hook=_without_margin)


def _without_margin(node: dict[str, Any]) -> dict[str, Any]:
    """The node with its docstring as read by people: msgspec 0.23 cuts the margin, 0.22 kept it."""
    words = node.get("description")
    return node | {"description": inspect.cleandoc(words)} if isinstance(words, str) else node


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
