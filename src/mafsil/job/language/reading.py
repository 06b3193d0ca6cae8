"""Job files in, checked jobs out, and the JSON Schema of such files; complaints name the key, the line, the remedy."""

from __future__ import annotations

import inspect
import json
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any

import msgspec

from mafsil.job.language import JobFile, fill_variables, in_si, require_signals, resolve, with_cells
from mafsil.job.language.description import Job, SceneFile
from mafsil.job.language.frames import Complaint
from mafsil.job.language.key_checks import refuse_not_finite, refuse_unknown, require_keys, translate_complaint
from mafsil.job.language.move_checks import check_pose, check_statements, require_grips, require_keepable, require_order
from mafsil.job.language.resolving import check_programs, other_robots
from mafsil.job.language.table_checks import check_obstacles, check_tables
from mafsil.job.language.text import Places, tables_of, text_of
from mafsil.messages.visible import visible


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
