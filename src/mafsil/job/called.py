"""How sentences call the moves of a job."""

from __future__ import annotations

from dataclasses import dataclass

from mafsil.job.description import Move
from mafsil.messages import say
from mafsil.messages.visible import visible


def label(index: int, move: Move, language: str | None = None) -> str:
    """`move 3 'lift'`: how sentences call a move."""
    if move.name:
        return say("job.move_named", language=language, number=index + 1, name=visible(move.name))
    return say("job.move", language=language, number=index + 1)


@dataclass(frozen=True, slots=True)
class Where:
    """A move, or the start where there is none, called in the reader's language, with its line."""

    index: int
    move: Move | None
    line: int | None = None

    def explain(self, *, language: str | None = None) -> str:
        """`move 3 'lift' (line 41)`."""
        called = say("job.start", language=language) if self.move is None else label(self.index, self.move, language)
        return called if self.line is None else say("job.at_line", language=language, what=called, line=self.line)
