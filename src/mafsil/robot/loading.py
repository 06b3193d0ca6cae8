"""Robots by name or file."""

from __future__ import annotations

from os import PathLike, fspath
from pathlib import Path
from typing import cast

from mafsil.errors import FileError, InputError
from mafsil.model import Mechanism
from mafsil.model.diagnostics import shown
from mafsil.robot.robot import Robot


def load(source: str | PathLike[str], *, tip: str | None = None) -> Robot:
    """A robot from the library or a file.

    Args:
        source: a name of the library, or a path to a .urdf, .xml (MJCF) or .toml (DH or screws) file.
        tip: name of the link that carries the tip frame, if another than the description's default.

    Raises:
        FileError: no such file or name, or a malformed file; the sentence says where and what to do.
        ModelError: the file describes something that is no robot.
    """
    mechanism = load_mechanism(source)
    return Robot(mechanism if tip is None else mechanism.with_tip(tip))


def load_mechanism(source: str | PathLike[str]) -> Mechanism:
    """The description of a robot from the library or a file; arguments and errors as for `load`."""
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
