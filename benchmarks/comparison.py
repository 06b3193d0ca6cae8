"""One line of the page of ratios: what was called, beside whom, how much quicker, and how much quicker it should be."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import Any


@dataclass(frozen=True)
class Comparison:
    """One public call beside a rival's for the same work, both timed in the same run.

    Attributes:
        call: the name that a user calls, and its form.
        case: robot or size.
        ours: microseconds of one evaluation.
        peer: whose call, and which.
        theirs: its microseconds for one evaluation.
        goal: how many times quicker ours should be; None where it is only to be known.
        bound: what the machine leaves no room beyond, where the goal is missed.
    """

    call: str
    case: str
    ours: float
    peer: str
    theirs: float
    goal: float | None = None
    bound: str = ""

    @property
    def ratio(self) -> float:
        """How many times quicker ours is."""
        return self.theirs / self.ours

    @property
    def met(self) -> bool | None:
        """Whether the goal is reached; None without one."""
        return None if self.goal is None else self.ratio >= self.goal


class Comparisons:
    """What one run of a benchmark has compared, for its JSON file."""

    def __init__(self) -> None:
        self.rows: list[Comparison] = []

    def add(self, call: str, case: str, ours: float, peer: str, theirs: float, goal: float | None = None) -> None:
        """One more; arguments as the attributes of `Comparison`, times in microseconds."""
        self.rows.append(Comparison(call, case, ours, peer, theirs, goal))

    def plain(self) -> list[dict[str, Any]]:
        """For a JSON file."""
        return [asdict(one) for one in self.rows]


def read(rows: Iterable[dict[str, Any]]) -> list[Comparison]:
    """From a JSON file."""
    return [Comparison(**row) for row in rows]
