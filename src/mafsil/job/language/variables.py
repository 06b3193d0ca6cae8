"""Values with names: `"$height"` anywhere in a job file stands for what `[variables]` or the command line gives it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any, cast

from mafsil.job.language.frames import Complaint
from mafsil.job.lines import Path
from mafsil.messages.visible import visible

TABLE = "variables"
_NAME = re.compile(r"\$([A-Za-z_][A-Za-z0-9_]*)")


def fill_variables(data: dict[str, Any], given: Mapping[str, object], error: Complaint) -> dict[str, Any]:
    """The tables of a file with values for names; the table of variables with those that are given.

    Args:
        data: of the file.
        given: values instead of those in the file.
        error: makes the complaint about a key.

    Raises:
        JobError: a name without a value, or a value for no name.
    """
    table = data.get(TABLE, {})
    if not isinstance(table, dict):
        return data
    named = cast("dict[str, Any]", table)
    for name in given:
        if name not in named:
            raise error("job.no_variable", (TABLE,), given=visible(name), known=_known(named))
    values = named | dict(given)
    rest = {key: _replace(value, values, (key,), error) for key, value in data.items() if key != TABLE}
    return rest | ({TABLE: values} if TABLE in data else {})


def _replace(value: Any, values: Mapping[str, Any], path: Path, error: Complaint) -> Any:
    """A value with names replaced, in tables and lists too."""
    if isinstance(value, dict):
        table = cast("dict[str, Any]", value)
        return {key: _replace(inner, values, (*path, key), error) for key, inner in table.items()}
    if isinstance(value, list):
        return [_replace(inner, values, (*path, k), error) for k, inner in enumerate(cast("list[Any]", value))]
    found = _NAME.fullmatch(value) if isinstance(value, str) else None
    if found is None:
        return value
    if found.group(1) not in values:
        raise error("job.no_variable", path, given=visible(found.group(1)), known=_known(values))
    return values[found.group(1)]


def _known(values: Mapping[str, Any]) -> str:
    return ", ".join(map(visible, values)) or "-"
