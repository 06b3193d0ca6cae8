"""Which format a robot file has: its root element says it, whatever the file is called; TOML goes by its suffix."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from mafsil.lazy_module import lazily
from mafsil.model.file_reader import FileReader
from mafsil.model.source import with_readable_tags
from mafsil.regular_file import regular_bytes

if TYPE_CHECKING:
    import mafsil.model.mjcf.reader as reader
    import mafsil.model.sdf as sdf
    import mafsil.model.urdf as urdf
else:
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
        data = with_readable_tags(regular_bytes(path, PROLOGUE))
    except (OSError, ValueError):
        return ""
    found = _ROOT.match(data)
    return "" if found is None else found[1].decode("ascii")
