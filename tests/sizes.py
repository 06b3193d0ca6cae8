"""How many of many equal cases run: a few with the tests, all with `pytest --full`."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeVar

Case = TypeVar("Case")

full = False
"""Whether `--full` was given: set before any test is collected."""


def few(cases: Iterable[Case], count: int) -> list[Case]:
    """So many of the cases, evenly spread, the first and the last among them; all of them with `--full`.

    Args:
        cases: that prove the same, each on its own data.
        count: two or more.
    """
    every = list(cases)
    if full or len(every) <= count:
        return every
    return [every[round(k * (len(every) - 1) / (count - 1))] for k in range(count)]


def size(small: Case, large: Case) -> Case:
    """The small size, or the large one with `--full`."""
    return large if full else small
