"""Fewer triangles for pictures: points that share a cell of a grid become one, where the planes around them meet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.model.mesh.surface import Faces, Surface

MOST_CELLS = 1024
"""Finest grid: cells along the longest edge of the surface."""
FLAT = 1e-2
"""Directions in which the planes of a cell bind its point less than this share of the strongest do not move it."""
_SEARCHES = 9


@dataclass(frozen=True, slots=True)
class _Grid:
    """Cell of each vertex, and the width of the cells."""

    cells: NDArray[np.int64]
    width: float


def decimate(surface: Surface, most: int) -> Surface:
    """A surface of at most about `most` triangles; the same one if it has no more.

    Points are moved to where the planes of their triangles come nearest to each other (the least squares of Garland and
    Heckbert's quadrics, cell by cell as Lindstrom does), so that edges and corners stay sharp.

    Args:
        surface: any triangles, shared corners or not.
        most: triangles to keep at most, about; a small surface may keep a few more.

    Reference:
        Lindstrom, P. Out-of-core simplification of large polygonal models. SIGGRAPH 2000.
    """
    if len(surface.faces) <= most:
        return surface
    coarse, fine = 1, MOST_CELLS
    for _ in range(_SEARCHES):
        middle = (coarse + fine) // 2
        if int(_apart(_grid(surface, middle).cells[surface.faces]).sum()) <= most:
            coarse = middle
        else:
            fine = middle
    return _cluster(surface, _grid(surface, max(coarse, 1)))


def _grid(surface: Surface, count: int) -> _Grid:
    """Cells of a grid that divides the longest edge of the surface's box by `count`."""
    used = surface.vertices[surface.faces].reshape(-1, 3)
    low = used.min(axis=0)
    width = max(float((used.max(axis=0) - low).max()) / count, LEAST_DIVISOR)
    steps = np.clip(np.floor((surface.vertices - low) / width), 0, count).astype(np.int64)
    return _Grid((steps[:, 0] * (count + 1) + steps[:, 1]) * (count + 1) + steps[:, 2], width)


def _apart(corners: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Which triangles keep three different corners."""
    a, b, c = corners.T
    return (a != b) & (b != c) & (c != a)


def _cluster(surface: Surface, grid: _Grid) -> Surface:
    used = np.zeros(len(surface.vertices), dtype=bool)
    used[surface.faces] = True
    _, names = np.unique(grid.cells[used], return_inverse=True)
    index = np.zeros(len(surface.vertices), dtype=np.int64)
    index[used] = names.reshape(-1)
    faces = index[surface.faces]
    points = _meeting_points(surface, faces, index[used], surface.vertices[used], grid.width)
    kept = np.flatnonzero(_apart(faces))
    _, first = np.unique(np.sort(faces[kept], axis=1), axis=0, return_index=True)
    kept = kept[np.sort(first)]
    colours = None if surface.colours is None else surface.colours[kept]
    return Surface(points, faces[kept], colours, surface.dropped)


def _meeting_points(surface: Surface, faces: Faces, of_vertex: Faces, vertices: Floats, width: float) -> Floats:
    """(cells, 3) for each cell the point nearest to all planes through it, not further than a cell from the middle."""
    count = int(of_vertex.max()) + 1
    middle = _sums(of_vertex, vertices, count) / np.bincount(of_vertex, minlength=count)[:, None]
    corners = surface.vertices[surface.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    n = normals / np.maximum(lengths, LEAST_DIVISOR)[:, None]
    quadrics = (lengths[:, None, None] * n[:, :, None] * n[:, None, :]).reshape(-1, 9)
    A, b = np.zeros((count, 9)), np.zeros((count, 3))
    for k in range(3):
        offsets = lengths * np.einsum("ij,ij->i", n, corners[:, 0] - middle[faces[:, k]])
        A += _sums(faces[:, k], quadrics, count)
        b += _sums(faces[:, k], offsets[:, None] * n, count)
    values, axes = np.linalg.eigh(A.reshape(-1, 3, 3))
    strong = values > FLAT * np.maximum(values[:, -1:], LEAST_DIVISOR)
    along = np.einsum("cij,ci->cj", axes, b)
    move = np.einsum("cij,cj->ci", axes, np.where(strong, along / np.where(strong, values, 1.0), 0.0))
    return middle + np.where(np.abs(move).max(axis=1, keepdims=True) <= width, move, 0.0)


def _sums(groups: Faces, values: Floats, count: int) -> Floats:
    """(count, k) sums of the rows of `values` by group."""
    columns = [np.bincount(groups, weights=column, minlength=count) for column in values.T]
    return np.stack(columns, axis=1).astype(np.float64)
