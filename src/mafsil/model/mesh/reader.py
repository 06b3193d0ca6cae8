"""Chooses the reader by the file's name; every refusal is a FileError with the reason."""

from __future__ import annotations

import errno
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TypeVar

from mafsil.errors import FileError
from mafsil.model.diagnostics import shown
from mafsil.model.mesh.collada import read_collada
from mafsil.model.mesh.msh import read_msh
from mafsil.model.mesh.obj import read_obj
from mafsil.model.mesh.stl import read_stl
from mafsil.model.mesh.surface import DEFAULT_LIMITS, MeshLimits, Surface
from mafsil.regular_file import whole_bytes

T = TypeVar("T")
_READERS: dict[str, Callable[[bytes, MeshLimits], Surface]] = {
    ".stl": read_stl,
    ".stlb": read_stl,
    ".obj": read_obj,
    ".dae": read_collada,
    ".msh": read_msh,
}


def read(path: str | Path, *, limits: MeshLimits = DEFAULT_LIMITS) -> Surface:
    """The triangles of a mesh file.

    Args:
        path: of an STL (binary or ASCII), OBJ, Collada or MuJoCo MSH file; the name's end says which.
        limits: sizes beyond which the file is refused.

    Raises:
        FileError: no such file, another format, too large, cut, a header that lies, indices out of range.
    """
    readers = {ending: _within(limits, reader) for ending, reader in _READERS.items()}
    return read_by(readers, path, limits.bytes, "mesh.format")


def _within(limits: MeshLimits, reader: Callable[[bytes, MeshLimits], Surface]) -> Callable[[bytes], Surface]:
    return lambda data: reader(data, limits)


def read_by(readers: Mapping[str, Callable[[bytes], T]], path: str | Path, most: int, unknown: str) -> T:
    """What the reader of a file's kind makes of it; every refusal names the file.

    Args:
        readers: by the end of the name, in small letters.
        path: of the file.
        most: bytes beyond which it is refused.
        unknown: key of the sentence about another end.

    Raises:
        FileError: no such file, another format, too large, or what the reader refuses.
    """
    path = Path(path)
    reader = readers.get(path.suffix.lower())
    if reader is None:
        raise FileError(unknown, path=shown(str(path)), known=", ".join(readers))
    data = contents(path, most)
    try:
        return reader(data)
    except FileError as error:
        raise FileError(error.key, path=shown(str(path)), **error.details) from None


def contents(path: Path, most: int) -> bytes:
    """The bytes of a file with shapes.

    Args:
        path: of the file.
        most: bytes beyond which it is refused.

    Raises:
        FileError: no such file, no plain file, too large.
    """
    try:
        return whole_bytes(path, most)
    except OSError as fault:
        key = "mesh.too_large" if fault.errno == errno.EFBIG else "mesh.unreadable"
        raise FileError(key, path=shown(str(path)), limit=most) from None
    except ValueError:
        raise FileError("mesh.unreadable", path=shown(str(path))) from None
