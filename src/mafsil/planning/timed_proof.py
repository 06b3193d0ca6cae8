"""Whether a motion in time is free at every moment: proved by chords that keep clear of what lies between."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from mafsil.arrays import Floats
from mafsil.collision import Checker

CHORD = 0.05
"""Largest change of a coordinate over a chord at first [rad | m]."""
HALVINGS = 6
"""How often a chord that cannot be proved is halved."""
Places: TypeAlias = Callable[[Floats], Floats]
"""(k,) moments [s] -> (k, n) coordinates."""


def first_unproved(checker: Checker, places: Places, breaks: Floats, accelerations: Floats) -> float | None:
    """The earliest moment from which a motion is not proved to keep more than the clearance; None if all of it is.

    1. Chords between the breaks and moments between which no coordinate moves by much more than CHORD.
    2. Over a chord of h seconds a coordinate leaves the straight line by no more than h^2 / 8 times its largest
       acceleration: the line is proved with a clearance larger by all that two bodies can move by so much.
    3. Chords that cannot be proved are halved, HALVINGS times.

    Args:
        checker: what has to be free.
        places: the motion; its velocity may jump nowhere.
        breaks: (m + 1,) moments between which the bounds of the acceleration hold [s].
        accelerations: (m, n) largest magnitudes between them; zero for a coordinate that rests [rad/s^2 | m/s^2].
    """
    for m, (first, last) in enumerate(pairwise(breaks)):
        t = _chords(places, float(first), float(last))  # 1
        for begin, end in pairwise(t):
            spans = [(float(begin), float(end), 0)]
            while spans:
                a, b, halved = spans.pop()
                if _is_proved(checker, places(np.array([a, b])), accelerations[m] * (b - a) ** 2 / 8.0):  # 2
                    continue
                if halved == HALVINGS:
                    return a
                middle = (a + b) / 2.0  # 3
                spans += [(middle, b, halved + 1), (a, middle, halved + 1)]
    return None


def _chords(places: Places, begin: float, end: float) -> Floats:
    """Moments from begin to end between which coordinates move by about CHORD."""
    t = np.linspace(begin, end, max(int((end - begin) / 0.01), 1) + 1)
    way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(places(t), axis=0)).max(axis=1, initial=0.0))])
    chosen = np.unique((way / CHORD).astype(np.int64), return_index=True)[1]
    return np.union1d(t[chosen], [begin, end])


def _is_proved(checker: Checker, ends: Floats, apart: Floats) -> bool:
    extra = checker.largest_way(apart, np.abs(ends).max(axis=0) + apart)
    return bool(checker.free_segment(ends[0], ends[1], extra=2.0 * extra))
