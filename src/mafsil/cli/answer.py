"""What an operation hands back: data for machines, lines for people, and whether the answer is yes.

Lines that are verdicts or heads of tables are coloured on a terminal, not in a pipe or where `NO_COLOR` is set
(https://no-color.org). Pictures go into files: one of a kind that is known, and one sentence where a place refuses.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, TextIO, TypeAlias

from mafsil.errors import FileError, InputError
from mafsil.messages import say

Tone: TypeAlias = Literal["plain", "good", "warning", "bad", "head"]
_CODES: dict[Tone, str] = {"good": "32", "warning": "33", "bad": "31", "head": "1"}
_chosen = True
PLAIN = (".png", ".svg", ".pdf")


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


def require_kind(path: str, known: Sequence[str]) -> None:
    """Refuse a file of another kind before anything is computed.

    Args:
        path: of the picture.
        known: endings, with their points.

    Raises:
        InputError: another ending; the sentence lists those that are known.
    """
    if Path(path).suffix.lower() not in known:
        raise InputError("cli.picture_kind", path=path, known=", ".join(known))


def draw_picture(draw: Callable[[Path], None], path: str, data: dict[str, Any]) -> str:
    """Draw into a file; the line that says so.

    Args:
        draw: writes the picture into a file.
        path: of that file.
        data: of the answer, in which the file is named.

    Raises:
        FileError: the place cannot be written.
    """
    try:
        draw(Path(path))
    except OSError as error:
        raise FileError("file.cannot_write", path=path, reason=error.strerror or str(error)) from None
    data["picture"] = path
    return say("cli.picture_written", path=path)


def allow_colours(*, allowed: bool) -> None:
    """Whether this process may print in colours, where a terminal takes them.

    Args:
        allowed: False for `--no-color`.
    """
    global _chosen
    _chosen = allowed


def paint(text: str, tone: Tone, stream: TextIO) -> str:
    """The text in the colour of its tone, if it goes to a terminal that shows colours.

    Args:
        text: one line or a part of it.
        tone: plain text stays as it is.
        stream: to which it will be written.
    """
    shows = _chosen and stream.isatty() and not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"
    return f"\x1b[{_CODES[tone]}m{text}\x1b[0m" if shows and tone in _CODES and text else text
