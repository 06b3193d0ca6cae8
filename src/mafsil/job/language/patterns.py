"""Places of patterns: rows, columns and layers."""

from __future__ import annotations

from itertools import product
from math import prod

import numpy as np

from mafsil.arrays import PoseMatrix
from mafsil.job.language.frames import Complaint, Frames
from mafsil.job.language.statements import Pattern

MOST_PLACES = 100_000
"""Of one pattern."""


def places(pattern: Pattern, name: str, frames: Frames, error: Complaint) -> list[tuple[str, PoseMatrix]]:
    """Label `2,3` and pose (4, 4) in {s} of every place, in the order in which they are gone to.

    Args:
        pattern: of the file.
        name: of it.
        frames: of the job.
        error: makes the complaint about a key.

    Raises:
        JobError: not one pitch for each count, not one to three of them, or too many places.
    """
    if not 1 <= len(pattern.count) <= 3 or len(pattern.pitch) != len(pattern.count):
        raise error("job.pattern_pitch", ("pattern", name), count=len(pattern.count), pitch=len(pattern.pitch))
    if prod(pattern.count) > MOST_PLACES:
        raise error("job.too_many_places", ("pattern", name, "count"), places=prod(pattern.count), most=MOST_PLACES)
    origin = frames.placed(pattern, ("pattern", name))
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
