"""What a name of the library or a file says of a robot, whatever its format.

Which format a robot file has: its root element says it, whatever the file is called; TOML goes by its suffix.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from importlib import import_module
from importlib.util import find_spec
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from mafsil.errors import FileError, InputError
from mafsil.lazy_module import lazily, registered
from mafsil.model import library, table
from mafsil.model.diagnostics import shown
from mafsil.model.faults import LOOP_CLOSED
from mafsil.model.mechanism import Mechanism
from mafsil.model.tip import TipChoice
from mafsil.regular_file import regular_bytes
from mafsil.toml_source import read_toml

if TYPE_CHECKING:
    import mafsil.model.file_reader as file_reader
    import mafsil.model.loop_file as loop_file
    import mafsil.model.mjcf.reader as reader
    import mafsil.model.sdf as sdf
    import mafsil.model.source as source_text
    import mafsil.model.urdf as urdf
    from mafsil.model.file_reader import FileReader
else:
    file_reader = lazily("mafsil.model.file_reader")
    loop_file = lazily("mafsil.model.loop_file")
    source_text = lazily("mafsil.model.source")
    reader = lazily("mafsil.model.mjcf.reader")
    sdf = lazily("mafsil.model.sdf")
    urdf = lazily("mafsil.model.urdf")


_BY_SUFFIX = {
    ".urdf": "robot",
    ".xacro": "robot",
    ".xml": "mujoco",
    ".mjcf": "mujoco",
    ".sdf": "sdf",
    ".world": "sdf",
}
"""Root elements that are expected where a file cannot be read as XML."""
PROLOGUE = 1 << 16
"""Bytes in which the root element begins."""
_ROOT = re.compile(rb"(?:[^<]++|<!--.*?-->|<\?.*?\?>|<!(?!--)[^>]*+>)*+<\s*+([A-Za-z_][\w.:-]*+)", re.DOTALL)
"""The first element, behind comments, instructions and declarations, in documents that XML refuses too."""
DESCRIPTIONS = "robot_descriptions"
"""A package of other people's robots by name, which fetches their files at the first use."""
LOGS = frozenset({".csv", ".npz", ".mcap", ".parquet"})
"""Endings of files of recorded motion, which the functions that take a log want after the robot."""


def read_source(
    source: str | PathLike[str], arguments: dict[str, str], dimensions: Mapping[str, ArrayLike], model: str | None
) -> tuple[Mechanism, bool]:
    """The description as the library or the file gives it, and whether a file did.

    Args:
        source: a name of the library, or a path.
        arguments: of a xacro file.
        dimensions: of an arm of the library.
        model: the one that is meant of several in a file.

    Raises:
        InputError: neither a name nor a path, arguments for something other than a file.
        FileError: no such file or name, or a malformed file; the sentence says where and what to do.
        ModelError: the file describes something that is no robot.
    """
    path = Path(source)
    if str(source).lstrip().startswith("<"):
        raise FileError("robot.text", source=shown(str(source)))
    if not path.suffix and not _exists(path):
        name = str(source)
        known = library.library_name(name)
        installed = _installed_description(name) if known is None else None
        if installed is not None:
            return _read(*installed, arguments, model), True
        if known is None:
            close = library.close_names(name)
            key = "robot.no_file_close" if close else "robot.no_file"
            raise FileError(key, source=shown(name), close=", ".join(close), known=", ".join(library.robots()))
        _require_choices(arguments, model, name)
        return library.load(known, **dimensions), False
    if dimensions:
        raise InputError("robot.no_dimensions", source=shown(str(source)), names=", ".join(dimensions))
    if path.suffix.lower() == ".toml":
        _require_choices(arguments, model, str(path))
        return _of_toml(path), True
    if path.suffix.lower() in LOGS:
        raise FileError("robot.log", source=shown(str(source)))
    mechanism, beside = _read(path, (), arguments, model), loop_file.loop_file_of(path)
    return (mechanism if beside is None else loop_file.with_loops(mechanism, beside)), True


def _of_toml(path: Path) -> Mechanism:
    """A table of joints, or a robot of a kind that a higher layer knows: a parallel one."""
    kinds = registered("kinds of robots")
    try:
        data = {} if kinds is None else read_toml(path)
    except FileError:
        data = {}  # The reader of tables says what is wrong, with the line.
    return table.read(path) if kinds is None or "kind" not in data else kinds.described(data, path.name)


def _read(path: Path, packages: Iterable[Path], arguments: dict[str, str], model: str | None) -> Mechanism:
    reader = reader_of(path, packages, arguments, model)
    if reader is None:
        raise FileError("robot.kind", source=shown(str(path)), suffix=path.suffix)
    return reader.read(path, repair=False, silent=True)


def _installed_description(name: str) -> tuple[Path, list[Path]] | None:
    """The file of a robot in the package `robot_descriptions`, if that is installed, and where its meshes are.

    Raises:
        FileError: the package knows the robot and could not fetch it.
    """
    if not name.isidentifier() or find_spec(DESCRIPTIONS) is None:
        return None
    for ending in ("", "_description", "_mj_description"):
        full = f"{DESCRIPTIONS}.{name}{ending}"
        if find_spec(full) is None:
            continue
        try:
            described = vars(import_module(full))
        except Exception as error:
            raise FileError("robot.not_fetched", source=shown(name), package=DESCRIPTIONS, reason=str(error)) from None
        paths = [described[key] for key in ("URDF_PATH", "MJCF_PATH", "XACRO_PATH") if key in described]
        if paths:
            folders = [Path(described[key]) for key in ("PACKAGE_PATH", "REPOSITORY_PATH") if key in described]
            return Path(paths[0]), [*folders, *(folder.parent for folder in folders)]
    return None


def warn_of_file(mechanism: Mechanism, choice: TipChoice | None) -> None:
    """One Python warning, if the file was changed or looks wrong, or its tip had to be chosen among several.

    Loops need none: what does not keep them closed refuses the robot.

    Args:
        mechanism: as it was read.
        choice: the tip, if it had to be chosen.
    """
    file_reader.warn_of(mechanism, choice, silent=(LOOP_CLOSED.code,))


def _require_choices(arguments: dict[str, str], model: str | None, source: str) -> None:
    """Arguments belong to xacro files, models to SDFormat."""
    if model is not None:
        raise InputError("robot.no_models", source=shown(source), model=shown(model))
    if arguments:
        raise InputError("robot.no_xacro", source=shown(source), names=", ".join(arguments))


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError):
        return False


def reader_of(
    path: Path,
    packages: Iterable[str | Path] = (),
    arguments: Mapping[str, str] | None = None,
    model: str | None = None,
) -> FileReader | None:
    """The reader for an XML file, or None if neither its root element nor its suffix is one of a robot.

    Args:
        path: of the file, which need not exist: the reader says so.
        packages: directories in which meshes and included files may lie.
        arguments: of a xacro file.
        model: the one that is meant of several in an SDFormat file.
    """
    tag = root_tag(path)
    expected = _BY_SUFFIX.get(path.suffix.lower())
    match tag if tag in ("robot", "mujoco", "sdf", "gazebo") else expected:
        case "robot":
            return urdf.file_reader(packages, arguments=arguments, model=model)
        case "mujoco":
            return reader.file_reader(packages, arguments=arguments, model=model)
        case "sdf" | "gazebo":
            return sdf.file_reader(packages, arguments=arguments, model=model)
        case _:
            return None


def root_tag(path: Path) -> str:
    """The tag of the first element of a file; empty if there is none."""
    try:
        data = source_text.with_readable_tags(regular_bytes(path, PROLOGUE))
    except (OSError, ValueError):
        return ""
    found = _ROOT.match(data)
    return "" if found is None else found[1].decode("ascii")
