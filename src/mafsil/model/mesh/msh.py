"""MuJoCo's binary MSH: points and triangles; normals and texture coordinates are passed over."""

from __future__ import annotations

import numpy as np

from mafsil.errors import FileError
from mafsil.model.mesh.surface import MeshLimits, Surface, cleaned

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
    return cleaned(vertices, faces)
