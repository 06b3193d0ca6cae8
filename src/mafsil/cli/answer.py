"""What an operation hands back: data for machines, lines for people, and whether the answer is yes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any


class Laid(str):
    """A line that is laid out already: harmless characters, cells in isolates; it is printed as it is."""

    __slots__ = ()


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
