"""What an operation hands back: data for machines, lines for people, and whether the answer is yes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from mafsil.cli.colour import Tone


class Laid(str):
    """A line that is laid out already: harmless characters, cells in isolates; it is printed as it is."""

    __slots__ = ()


class Head(Laid):
    """The line above the rows of a table."""

    __slots__ = ()


class Toned(str):
    """A line that is a verdict, or part of one: good, a warning, or bad."""

    __slots__ = ("tone",)
    tone: Tone

    def __new__(cls, text: str, tone: Tone) -> Toned:
        """Args: the line, and what it says."""
        line = super().__new__(cls, text)
        line.tone = tone
        return line


def tone_of(line: str) -> Tone:
    """That of a line of an answer."""
    return line.tone if isinstance(line, Toned) else "head" if isinstance(line, Head) else "plain"


@dataclass(frozen=True, slots=True)
class Answer:
    """The result of one operation.

    Attributes:
        data: plain data, printed by `--json`.
        lines: the same for people; those of a table are `Laid`.
        refusal: why the honest answer is no, or None; it goes to stderr, and the exit code is 1.
        interrupted: whether Ctrl-C ended it early; the exit code is 130 then.
    """

    data: dict[str, Any] = field(default_factory=dict[str, Any])
    lines: tuple[str, ...] = ()
    refusal: str | None = None
    interrupted: bool = False
