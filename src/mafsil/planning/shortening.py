"""Paths made shorter: straight pieces between random places of them, as long as these are free."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector
from mafsil.planning.problem import Problem, length_of

ALONG = 1e-9
"""Share of the length by which a shortcut must be shorter to count."""


def take_shortcuts(problem: Problem, path: JointVector, rng: np.random.Generator, tries: int = 200) -> JointVector:
    """A path (k, n) with shortcuts, never longer.

    1. Corners that a straight piece can leave out, from the ends inwards.
    2. Two random places of the path; if the straight piece between them is free, it replaces the way between. What is
       left of the segments that it cuts is looked at too: each segment of the result was.

    Args:
        problem: what is free.
        path: (k, n) free.
        rng: for the places.
        tries: how many shortcuts are tried.
    """
    # 1.
    k = 0
    rows: list[JointVector] = list(path)
    while k + 2 < len(rows):
        farthest = next(
            (j for j in range(len(rows) - 1, k + 1, -1) if problem.is_free_segment(rows[k], rows[j])), k + 1
        )
        rows[k + 1 : farthest] = []
        k += 1
    best: Floats = np.stack(rows)
    # 2.
    for _ in range(tries):
        if len(best) < 3:
            break
        lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(best, axis=0), axis=1))])
        s: Floats = np.sort(rng.uniform(0.0, lengths[-1], 2))
        i, j = (np.searchsorted(lengths, s, side="right") - 1).tolist()
        if i == j:
            continue
        a, b = (
            best[m] + (best[m + 1] - best[m]) * ((x - lengths[m]) / (lengths[m + 1] - lengths[m]))
            for m, x in zip((i, j), s, strict=True)
        )
        candidate: Floats = np.concatenate([best[: i + 1], np.stack([a, b]), best[j + 1 :]])
        pieces = ((a, b), (best[i], a), (b, best[j + 1]))
        if length_of(candidate) < length_of(best) * (1.0 - ALONG) and all(
            problem.is_free_segment(*piece) for piece in pieces
        ):
            best = np.asarray(candidate[_move(candidate)], dtype=np.float64)
    return best


def _move(path: Floats) -> NDArray[np.bool_]:
    """(k,) which points differ from the one before."""
    return np.append(True, np.abs(np.diff(path, axis=0)).max(axis=1) > 0.0)
