"""Wavefront OBJ: points and faces; polygons become fans of triangles."""

from __future__ import annotations

import io
from array import array
from itertools import pairwise

import numpy as np

from mafsil.errors import FileError
from mafsil.model.mesh.surface import MeshLimits, Surface, cleaned


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
    return cleaned(vertices, faces)


def _add_face(corners: array[int], words: list[bytes], known: int) -> None:
    """One polygon as a fan; indices count from 1, or backwards from the last point if negative."""
    polygon = [int(word.partition(b"/")[0]) for word in words]
    indices = [index - 1 if index > 0 else known + index for index in polygon]
    if len(indices) < 3 or min(indices) < 0 or 0 in polygon:
        raise ValueError
    for second, third in pairwise(indices[1:]):
        corners.extend((indices[0], second, third))
