"""Types of what stands in a job file, found from its keys: for complaints that name choices, kinds and places."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import lru_cache
from types import UnionType
from typing import Annotated, Any, Literal, Union, cast, get_args, get_origin, get_type_hints

import msgspec

from mafsil.job.description import Part
from mafsil.job.language.statements import JobFile
from mafsil.job.lines import Path
from mafsil.job.part import keys_of


def field_type(kind: type[Part], name: str) -> Any:
    """Of a key of a table, without bounds of numbers."""
    return _hints(kind)[name]


@lru_cache
def _hints(kind: type[Part]) -> dict[str, Any]:
    return get_type_hints(kind)


def tables_in(value: Any, annotation: Any, path: Path) -> Iterator[tuple[dict[str, Any], Path, type[Part]]]:
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


def path_of(text: str, data: Any) -> Path:
    """`$.move[2].pose` as ("move", 2, "pose"); msgspec leaves out names of tables: the first that is wrong is meant."""
    found = re.search(r"at `\$([^`]*)`", text)
    steps = re.findall(r"\.([^.\[\]]+)|\[(\d+)\]|(\[\.\.\.\])", found.group(1)) if found else []
    path: Path = ()
    for name, index, some in steps:
        path = (*path, _wrong_name(data, path) if some else name or int(index))
    return path


def _wrong_name(data: Any, path: Path) -> str:
    """The first name of a table of names whose value is of the wrong kind."""
    kind = next(get_args(each)[1] for each in _options(_annotation(path)) if get_origin(each) is dict)
    table = cast("dict[str, Any]", value_at(data, path))
    for name, value in table.items():
        try:
            msgspec.convert(value, kind, strict=True)
        except msgspec.ValidationError:
            return name
    return next(iter(table), "")


def _annotation(path: Path) -> Any:
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


def value_at(data: Any, path: Path) -> Any:
    """What stands at a place of the tables of a file."""
    for step in path:
        data = data[step]
    return data


def choices_at(path: Path) -> tuple[str, ...]:
    """The texts of which the key at a place takes one."""
    options = _options(_annotation(path))
    return tuple(str(x) for option in options if get_origin(option) is Literal for x in get_args(option))
