"""Descriptions of robots by name or file, and the gate for functions that want one."""

from __future__ import annotations

from os import PathLike, fspath
from pathlib import Path
from typing import Protocol, TypeAlias, cast

from mafsil.errors import FileError, InputError
from mafsil.model.diagnostics import shown
from mafsil.model.mechanism import Mechanism


class Described(Protocol):
    """What carries the description of a robot: a Robot does."""

    @property
    def mechanism(self) -> Mechanism:
        """The description."""
        ...


RobotLike: TypeAlias = Described | Mechanism | str | PathLike[str]
"""Whatever names a robot: a Robot, a Mechanism, a name of the library, the path of a file."""


def as_mechanism(robot: RobotLike) -> Mechanism:
    """The description behind whatever names a robot.

    Args:
        robot: a Robot, a Mechanism, a name of the library or the path of a file.

    Raises:
        InputError: something else.
        FileError, ModelError: no such name or file, a malformed one; as `load_mechanism` says.
    """
    if isinstance(robot, Mechanism):
        return robot
    described = getattr(cast(object, robot), "mechanism", None)
    if isinstance(described, Mechanism) and not isinstance(robot, type):
        return described
    return load_mechanism(cast("str | PathLike[str]", robot))


def load_mechanism(source: str | PathLike[str]) -> Mechanism:
    """The description of a robot from the library or a file.

    Args:
        source: a name of the library, or a path to a .urdf, .xml (MJCF) or .toml (DH or screws) file.

    Raises:
        InputError: neither a name nor a path.
        FileError: no such file or name, or a malformed file; the sentence says where and what to do.
        ModelError: the file describes something that is no robot.
    """
    from mafsil.model import library

    if not isinstance(cast(object, source), str | PathLike) or isinstance(cast(object, fspath(source)), bytes):
        raise InputError("robot.source", got=type(source).__name__)
    path = Path(source)
    if not path.suffix and not _exists(path):
        name = str(source)
        if name != "default" and name not in library.names():
            close = library.close_names(name)
            key = "robot.no_file_close" if close else "robot.no_file"
            raise FileError(key, source=shown(name), close=", ".join(close), known=", ".join(library.names()))
        return library.load(name)
    match path.suffix.lower():
        case ".urdf":
            from mafsil.model import urdf

            return urdf.read(path)
        case ".xml" | ".mjcf":
            from mafsil.model import mjcf

            return mjcf.read(path)
        case ".toml":
            from mafsil.model import table

            return table.read(path)
        case _:
            raise FileError("robot.kind", source=shown(str(source)), suffix=path.suffix)


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError):
        return False
