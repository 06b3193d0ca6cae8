"""Chooses the reader by the file's name; every refusal is a FileError with the reason.

MuJoCo's binary MSH: points and triangles; normals and texture coordinates are passed over.

Wavefront OBJ: points and faces; polygons become fans of triangles.
"""

from __future__ import annotations

import errno
import io
from array import array
from collections.abc import Callable, Mapping
from itertools import pairwise
from pathlib import Path
from typing import TypeVar

import numpy as np

from mafsil.errors import FileError
from mafsil.model.diagnostics import shown
from mafsil.model.mesh.collada import read_collada, read_stl
from mafsil.model.mesh.surface import DEFAULT_LIMITS, MeshLimits, Surface, clean_surface
from mafsil.regular_file import whole_bytes


def read_obj(data: bytes, limits: MeshLimits) -> Surface:
    """The triangles of an OBJ file; textures, normals, lines and materials are ignored."""
    points, corners = array("d"), array("q")
    for number, line in enumerate(io.BytesIO(data), 1):
        words = line.split()
        if not words or words[0] not in (b"v", b"f"):
            continue
        try:
            if words[0] == b"v":
                points.extend((float(words[1]), float(words[2]), float(words[3])))
            else:
                _add_face(corners, words[1:], len(points) // 3)
        except (IndexError, ValueError, OverflowError):
            raise FileError("mesh.line", line=number) from None
        if len(corners) > 3 * limits.faces:
            raise FileError("mesh.too_many_faces", limit=limits.faces)
    vertices = np.frombuffer(points, np.float64).reshape(-1, 3) if points else np.zeros((0, 3))
    faces = np.frombuffer(corners, np.int64).reshape(-1, 3) if corners else np.zeros((0, 3), np.int64)
    if faces.size and faces.max() >= len(vertices):
        raise FileError("mesh.index", index=int(faces.max()) + 1, found=len(vertices))
    return clean_surface(vertices, faces)


def _add_face(corners: array[int], words: list[bytes], known: int) -> None:
    """One polygon as a fan; indices count from 1, or backwards from the last point if negative."""
    polygon = [int(word.partition(b"/")[0]) for word in words]
    indices = [index - 1 if index > 0 else known + index for index in polygon]
    if len(indices) < 3 or min(indices) < 0 or 0 in polygon:
        raise ValueError
    for second, third in pairwise(indices[1:]):
        corners.extend((indices[0], second, third))


_HEADER = 16


def read_msh(data: bytes, limits: MeshLimits) -> Surface:
    """The triangles of an MSH file: four counts (points, normals, texture points, triangles), then their numbers."""
    if len(data) < _HEADER:
        raise FileError("mesh.cut")
    points, normals, textures, count = (int(n) for n in np.frombuffer(data, "<i4", 4))
    if min(points, normals, textures, count) < 0:
        raise FileError("mesh.cut")
    if count > limits.faces:
        raise FileError("mesh.too_many_faces", limit=limits.faces)
    numbers = 3 * points + 3 * normals + 2 * textures
    if len(data) != _HEADER + 4 * (numbers + 3 * count):
        raise FileError("mesh.count", declared=count, found=max(len(data) - _HEADER - 4 * numbers, 0) // 12)
    vertices = np.frombuffer(data, "<f4", 3 * points, _HEADER).reshape(-1, 3).astype(np.float64)
    faces = np.frombuffer(data, "<i4", 3 * count, _HEADER + 4 * numbers).reshape(-1, 3).astype(np.int64)
    if faces.size and (faces.min() < 0 or faces.max() >= points):
        raise FileError("mesh.index", index=int(faces.max()), found=points)
    return clean_surface(vertices, faces)


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
