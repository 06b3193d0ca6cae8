"""A robot written to a file; the ending of its name says the format."""

from __future__ import annotations

from collections.abc import Collection
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from mafsil.errors import FileError
from mafsil.lazy_module import lazily
from mafsil.model.loading import RobotLike, as_mechanism
from mafsil.model.losses import Document, Loss, deliver
from mafsil.model.mechanism import Mechanism

if TYPE_CHECKING:
    import mafsil.model.mjcf.writer as mjcf_writer
    import mafsil.model.sdf.writer as sdf_writer
    import mafsil.model.table.writing as table_writer
    import mafsil.model.urdf.writer as urdf_writer
else:
    mjcf_writer = lazily("mafsil.model.mjcf.writer")
    sdf_writer = lazily("mafsil.model.sdf.writer")
    table_writer = lazily("mafsil.model.table.writing")
    urdf_writer = lazily("mafsil.model.urdf.writer")


def save(robot: RobotLike, path: str | PathLike[str], *, without: Collection[str] = ()) -> tuple[Loss, ...]:
    """Write a robot to a file: .urdf, .sdf or .world (Gazebo), .xml or .mjcf (MuJoCo), .toml (a table).

    Args:
        robot: any.
        path: of the file, which is replaced.
        without: what may be left out though the format cannot keep it; see `write` of `mafsil.model.urdf`,
            `mafsil.model.sdf`, `mafsil.model.mjcf` and `mafsil.model.table`.

    Returns:
        What the file does not hold, or says in another way; the file says it too, in a comment at its head.

    Warns:
        ModelWarning: something is left out that `without` does not name, and that changes no motion.

    Raises:
        FileError: another ending, or a place that cannot be written.
        InputError: a word in `without` that leaves out nothing in this format.
        ModelError: the format cannot hold such a robot, or what is read back would move otherwise; the sentence says
            what would be lost, and the word of `without`.
    """
    mechanism = as_mechanism(robot, keeps_loops=True)
    document = _document(mechanism, Path(path), without)
    deliver(document, mechanism.name, path, without)
    return document.losses


def _document(mechanism: Mechanism, path: Path, without: Collection[str]) -> Document:
    match path.suffix.lower():
        case ".urdf":
            return urdf_writer.document(mechanism, without)
        case ".xml" | ".mjcf":
            return mjcf_writer.document(mechanism, without)
        case ".toml":
            return table_writer.document(mechanism, without)
        case ".sdf" | ".world":
            return sdf_writer.document(mechanism, without, in_world=path.suffix.lower() == ".world")
        case _:
            raise FileError("writing.suffix", path=str(path))
