"""Robots that wait for each other."""

from __future__ import annotations

from dataclasses import dataclass

from mafsil.messages import say
from mafsil.messages.quantities import quantity


@dataclass(frozen=True, slots=True)
class Standing:
    """A robot that waits for what does not come.

    Attributes:
        robot: its name in the file.
        name: as sentences call it.
        number: of the move at which it waits, from 1.
        wanted: what for.
        since: when the wait begins [s].
    """

    robot: str
    name: str
    number: int
    wanted: str
    since: float


@dataclass(frozen=True, slots=True)
class Standstill:
    """Robots that wait, for sentences in any language."""

    robots: tuple[Standing, ...]

    def explain(self, *, language: str | None = None) -> str:
        """`right, move 2, waits from 1.2 s on for a = true`."""
        words = [
            say(
                "job.stands", language=language, name=one.name, number=one.number, wanted=one.wanted,
                time=quantity(one.since, "s"),
            )
            for one in self.robots
        ]  # fmt: skip
        return say("job.list_separator", language=language).join(words)
