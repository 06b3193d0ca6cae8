"""Places of patterns: rows, columns and layers, or the rows of a file."""

from __future__ import annotations

from itertools import product
from math import prod
from pathlib import Path

import msgspec
import numpy as np

from mafsil.arrays import PoseMatrix
from mafsil.csv_table import read_csv_table
from mafsil.geometry import rotation
from mafsil.job.language.frames import Complaint, Frames
from mafsil.job.language.statements import Pattern

ANGLES = ("roll", "pitch", "yaw")
"""Columns of a file of places that may be absent."""
MOST_PLACES = 100_000
"""Of one pattern."""


def places(
    pattern: Pattern, name: str, frames: Frames, unit: float, folder: Path, error: Complaint
) -> list[tuple[str, PoseMatrix]]:
    """Label `2,3` and pose (4, 4) in {s} of every place, in the order in which they are gone to.

    Args:
        pattern: of the file.
        name: of it.
        frames: of the job.
        unit: of lengths in the files that it names [m].
        folder: to which their paths are relative.
        error: makes the complaint about a key.

    Raises:
        JobError: not one pitch for each count, not one to three of them, or too many places.
        FileError: the file of places cannot be read; it names line and column.
    """
    if pattern.file is not None:
        if pattern.count or pattern.pitch:
            raise error("job.pattern_file", ("pattern", name))
        given = frames.place(msgspec.structs.replace(pattern, frame=None), ("pattern", name))
        rows = _of_file(folder / pattern.file, unit, degrees=frames.degrees)
        rows[:, :3, 3] += given[:3, 3]
        rows[:, :3, :3] = rows[:, :3, :3] @ given[:3, :3]
        around = np.eye(4) if pattern.frame is None else frames.pose(pattern.frame, ("pattern", name, "frame"))
        return [(str(k + 1), T) for k, T in enumerate(around @ rows)]
    if not 1 <= len(pattern.count) <= 3 or len(pattern.pitch) != len(pattern.count):
        raise error("job.pattern_pitch", ("pattern", name), count=len(pattern.count), pitch=len(pattern.pitch))
    if prod(pattern.count) > MOST_PLACES:
        raise error("job.too_many_places", ("pattern", name, "count"), places=prod(pattern.count), most=MOST_PLACES)
    origin = frames.place(pattern, ("pattern", name))
    found: list[tuple[str, PoseMatrix]] = []
    backwards = pattern.order == "snake"
    for row, above in enumerate(product(*(range(count) for count in reversed(pattern.count[1:])))):
        along = range(pattern.count[0])
        for first in reversed(along) if backwards and row % 2 else along:
            index = (first, *reversed(above))
            T = np.array(origin)
            steps = np.array([k * pitch for k, pitch in zip(index, pattern.pitch, strict=True)])
            T[:3, 3] += T[:3, : len(steps)] @ steps
            found.append((",".join(str(k + 1) for k in index), T))
    return found


def _of_file(path: Path, unit: float, *, degrees: bool) -> PoseMatrix:
    """(m, 4, 4) of the rows of a file."""
    table = read_csv_table(path, fewest=1)
    turned = any(table.column(name) is not None for name in ANGLES)
    columns = list[int]()
    for name in ("x", "y", "z", *(ANGLES if turned else ())):
        column = table.column(name)
        if column is None:
            raise table.no_column(name)
        columns.append(column)
    values = table.numbers(columns)
    T = np.tile(np.eye(4), (len(values), 1, 1))
    T[:, :3, 3] = unit * values[:, :3]
    if turned:
        T[:, :3, :3] = rotation.from_rpy(np.radians(values[:, 3:]) if degrees else values[:, 3:])
    return T
