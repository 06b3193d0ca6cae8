"""STL, binary and ASCII."""

from __future__ import annotations

import io
from array import array

import numpy as np

from mafsil.errors import FileError
from mafsil.model.mesh.surface import MeshLimits, Surface, clean_surface

_HEADER = 84
_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def read_stl(data: bytes, limits: MeshLimits) -> Surface:
    """The triangles of an STL file; it is ASCII if it begins with `solid` and its length does not fit its count."""
    count = int.from_bytes(data[80:84], "little")
    fits = len(data) >= _HEADER + count * _RECORD.itemsize
    if data[:80].lstrip()[:5].lower() == b"solid" and not (fits and _is_exact(data, count)):
        return _read_ascii(data, limits)
    if len(data) < _HEADER:
        raise FileError("mesh.cut")
    if not fits:
        raise FileError("mesh.count", declared=count, found=(len(data) - _HEADER) // _RECORD.itemsize)
    if count > limits.faces:
        raise FileError("mesh.too_many_faces", limit=limits.faces)
    records = np.frombuffer(data, _RECORD, count, _HEADER)
    vertices = records["corners"].reshape(-1, 3).astype(np.float64)
    return clean_surface(vertices, np.arange(3 * count).reshape(-1, 3))


def _is_exact(data: bytes, count: int) -> bool:
    return len(data) == _HEADER + count * _RECORD.itemsize


def _read_ascii(data: bytes, limits: MeshLimits) -> Surface:
    """Corners line by line, so that memory stays near the size of the numbers."""
    numbers = array("d")
    ended = False
    for number, line in enumerate(io.BytesIO(data), 1):
        words = line.split(None, 4)
        if not words:
            continue
        keyword = words[0].lower()
        if keyword == b"vertex":
            try:
                numbers.extend((float(words[1]), float(words[2]), float(words[3])))
            except (IndexError, ValueError):
                raise FileError("mesh.line", line=number) from None
            if len(numbers) > 9 * limits.faces:
                raise FileError("mesh.too_many_faces", limit=limits.faces)
        ended |= keyword == b"endsolid"
    if not ended or len(numbers) % 9:
        raise FileError("mesh.cut")
    vertices = np.frombuffer(numbers, np.float64).reshape(-1, 3) if numbers else np.zeros((0, 3))
    return clean_surface(vertices, np.arange(len(vertices)).reshape(-1, 3))
