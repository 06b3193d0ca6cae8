"""Texts before they are jobs: the cells that a file includes, and values for names.

What a cell says counts as if it stood in the job. What the job says itself wins: key by key in tables such as
`[limits]`, whole entries in tables of names such as `[frame.NAME]`; lists of tables such as `[[obstacle]]` go on after
the job's own. `"$height"` anywhere in a job stands for what `[variables]` or the command line gives it.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

from mafsil.errors import FileError
from mafsil.job.language.description import Cell
from mafsil.job.language.frames import Complaint
from mafsil.job.language.surrounding_tables import FILE_KEYS
from mafsil.job.language.text import Keys, Places, tables_of, text_of
from mafsil.messages.visible import visible
from mafsil.regular_file import is_file, whole_path

VARIABLES = "variables"
_NAME = re.compile(r"\$([A-Za-z_][A-Za-z0-9_]*)")
TABLE = "include"
FILES: dict[str, Sequence[str]] = {
    "robot": (), "pattern": ("file",), "other_robot": ("robot", "srdf"), "obstacle": FILE_KEYS, "collision": ("srdf",),
}  # fmt: skip
"""Keys that name files, and for tables which of their keys do."""
BY_NAME = ("pattern",)
"""Of these the tables that have names."""
DEEPEST = 8
"""Files that include files."""
MOST_CELLS = 100
UNITS = ("angles", "lengths")
"""Keys that a cell and its job cannot say differently."""
OF_THE_JOB = ("move", "start", "title")
"""What only a job has."""


def with_cells(data: dict[str, Any], folder: Path, places: Places) -> tuple[dict[str, Any], tuple[Cell, ...]]:
    """The tables of a job file and of all that it includes, and which key comes from which file.

    Args:
        data: of the job file.
        folder: to which its paths are relative.
        places: of the keys of the job file.

    Raises:
        FileError: a cell that cannot be read or is no TOML.
        JobError: a cell that includes itself, has moves, or says angles or lengths in another unit.
    """
    merging = _Merging(dict(data), [])
    merging.include(data.get(TABLE, ()), folder, (whole_path(folder / places.source),), places)
    return merging.data, tuple(merging.cells)


def _with_paths(given: dict[str, Any], folder: Path) -> dict[str, Any]:
    """The same tables, where files that lie beside the cell are named so that the job finds them.

    Args:
        given: tables of a cell in another folder than the job's.
        folder: of the cell.
    """
    found = dict(given)
    for key, names in FILES.items():
        value = given.get(key)
        if isinstance(value, str):
            found[key] = _beside(value, folder)
        elif isinstance(value, dict | list):
            if key in BY_NAME and isinstance(value, dict):
                by_name = cast("dict[str, object]", value)
                found[key] = {name: _name(each, names, folder) for name, each in by_name.items()}
                continue
            tables = cast("list[object]", value if isinstance(value, list) else [value])
            named = [_name(each, names, folder) for each in tables]
            found[key] = named if isinstance(value, list) else named[0]
    return found


def _name(given: object, names: Sequence[str], folder: Path) -> object:
    """A table with the files that some keys name; what is none is refused later."""
    if not isinstance(given, dict):
        return given
    table = cast("dict[str, Any]", given)
    return table | {name: _beside(table[name], folder) for name in names if isinstance(table.get(name), str)}


def _beside(name: str, folder: Path) -> str:
    """The path of a file beside a cell; what lies elsewhere, or is no file, stays as it is."""
    path = folder / name
    return str(path) if Path(name).suffix and is_file(path) else name


@dataclass(frozen=True, slots=True)
class _Merging:
    """The job so far.

    Attributes:
        data: its tables.
        cells: what was included.
    """

    data: dict[str, Any]
    cells: list[Cell]

    def include(self, names: object, folder: Path, above: tuple[Path, ...], above_places: Places) -> None:
        """The cells of one file, each followed by those that it includes itself."""
        # What is neither a text nor a list of them is refused with the types of all other keys.
        listed = cast("list[object]", names) if isinstance(names, list) else [names]
        for k, name in enumerate(listed):
            keys: Keys = (TABLE,) if isinstance(names, str) else (TABLE, k)
            if not isinstance(name, str):
                continue
            path = whole_path(folder / name)
            if path in above or len(above) >= DEEPEST or len(self.cells) >= MOST_CELLS:
                raise above_places.error("job.include_circle", keys, cell=visible(name), most=DEEPEST)
            source = visible(name)
            try:
                text = text_of(folder / name, source)
                given = tables_of(text, source)
            except FileError as fault:
                raise above_places.of_file(fault, keys) from None
            places = Places(text, source)
            self._require_cell(given, places)
            if path.parent != above[0].parent:
                given = _with_paths(given, path.parent)
            self.cells.append(Cell(source=source, text=text, gave=tuple(self._merge(given))))
            self.include(given.get(TABLE, ()), path.parent, (*above, path), places)

    def _require_cell(self, given: dict[str, Any], places: Places) -> None:
        for name in OF_THE_JOB:
            if name in given:
                here: Keys = (name, 0) if isinstance(given[name], list) else (name,)
                raise places.error("job.include_own", here, own=", ".join(OF_THE_JOB))
        for name in UNITS:
            if name in given and given[name] != self.data.get(name, given[name]):
                raise places.error("job.include_units", (name,), unit=name, own=visible(str(self.data[name])))

    def _merge(self, given: dict[str, Any]) -> list[tuple[Keys, Keys]]:
        """Takes what is new; where it stands then, and where it stood."""
        taken: list[tuple[Keys, Keys]] = []
        for key, value in given.items():
            own = self.data.get(key)
            if key == TABLE:
                continue
            if key not in self.data:
                self.data[key] = value
                taken.append(((key,), (key,)))
            elif isinstance(own, dict) and isinstance(value, dict):
                table, more = cast("dict[str, Any]", own), cast("dict[str, Any]", value)
                new = [name for name in more if name not in table]
                self.data[key] = table | {name: more[name] for name in new}
                taken += [((key, name), (key, name)) for name in new]
            elif isinstance(own, list) and isinstance(value, list):
                rows, added = cast("list[Any]", own), cast("list[Any]", value)
                self.data[key] = [*rows, *added]
                taken += [((key, len(rows) + k), (key, k)) for k in range(len(added))]
        return taken


def fill_variables(data: dict[str, Any], given: Mapping[str, object], error: Complaint) -> dict[str, Any]:
    """The tables of a file with values for names; the table of variables with those that are given.

    Args:
        data: of the file.
        given: values instead of those in the file.
        error: makes the complaint about a key.

    Raises:
        JobError: a name without a value, or a value for no name.
    """
    table = data.get(VARIABLES, {})
    if not isinstance(table, dict):
        return data
    named = cast("dict[str, Any]", table)
    for name in given:
        if name not in named:
            raise error("job.no_variable", (VARIABLES,), given=visible(name), known=_known(named))
    values = named | dict(given)
    rest = {key: _replace(value, values, (key,), error) for key, value in data.items() if key != VARIABLES}
    return rest | ({VARIABLES: values} if VARIABLES in data else {})


def _replace(value: Any, values: Mapping[str, Any], path: Keys, error: Complaint) -> Any:
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
