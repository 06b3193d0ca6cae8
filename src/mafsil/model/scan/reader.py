"""Chooses the reader by the file's name; every refusal is a FileError with the reason."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mafsil.arrays import Floats
from mafsil.errors import FileError
from mafsil.model.diagnostics import shown
from mafsil.model.mesh.reader import read_by
from mafsil.model.scan.npy import read_npy
from mafsil.model.scan.ply import read_ply
from mafsil.model.scan.png import read_png
from mafsil.model.scan.text import read_rows


@dataclass(frozen=True, slots=True)
class ScanLimits:
    """Sizes beyond which a file is refused: its bytes, points of a cloud, points of a grid of heights."""

    bytes: int = 128 << 20
    points: int = 1_000_000
    heights: int = 500_000


DEFAULT_LIMITS = ScanLimits()


def read_points(path: str | Path, *, limits: ScanLimits = DEFAULT_LIMITS) -> Floats:
    """(k, 3) points of a file, in its unit.

    Args:
        path: of an .npy array (k, 3) or more columns, a .ply file, or text (.xyz, .txt, .csv) with x, y, z first on
            each line; the name's end says which.
        limits: sizes beyond which the file is refused.

    Raises:
        FileError: no such file, another format, too large, damaged, a point that is not finite.
    """
    readers: dict[str, Callable[[bytes], Floats]] = {
        ".npy": read_npy,
        ".ply": lambda data: read_ply(data, limits.points),
        **dict.fromkeys((".xyz", ".txt", ".csv"), lambda data: read_rows(data, 12 * limits.points)),
    }
    points = read_by(readers, path, limits.bytes, "scan.format")
    if points.ndim == 3:
        # The picture of a depth camera: rows and columns of points.
        points = points.reshape(-1, points.shape[2])
    if points.ndim != 2 or points.shape[1] < 3 or not len(points):
        raise FileError("scan.points", path=shown(str(path)), got=points.shape)
    if len(points) > limits.points:
        raise FileError("scan.too_many", path=shown(str(path)), found=len(points), limit=limits.points)
    return _finite(path, points[:, :3])


def read_heights(path: str | Path, *, limits: ScanLimits = DEFAULT_LIMITS) -> Floats:
    """(rows, columns) heights of a file on a regular grid, in its unit; the first row is the one of smallest y.

    Args:
        path: of an .npy array (rows, columns), text (.csv, .txt) with one row each line, or a grey .png picture, black
            0 and white 1, whose top row is the one of largest y; the name's end says which.
        limits: sizes beyond which the file is refused.

    Raises:
        FileError: no such file, another format, too large, damaged, a height that is not finite.
    """
    readers: dict[str, Callable[[bytes], Floats]] = {
        ".npy": read_npy,
        ".png": lambda data: read_png(data, limits.heights)[::-1],
        **dict.fromkeys((".csv", ".txt"), lambda data: read_rows(data, limits.heights)),
    }
    heights = read_by(readers, path, limits.bytes, "scan.format")
    if heights.ndim != 2 or min(heights.shape) < 2:
        raise FileError("scan.heights", path=shown(str(path)), got=heights.shape)
    if heights.size > limits.heights:
        raise FileError("scan.too_many", path=shown(str(path)), found=heights.size, limit=limits.heights)
    return _finite(path, heights)


def _finite(path: str | Path, values: Floats) -> Floats:
    """The values themselves, all finite: what a sensor did not see is not known to be free."""
    bad = int((~np.isfinite(values)).sum())
    if bad:
        raise FileError("scan.not_finite", path=shown(str(path)), count=bad)
    return np.ascontiguousarray(values)
