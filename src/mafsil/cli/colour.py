"""Colours of verdicts and of the heads of tables on a terminal; none in a pipe or where `NO_COLOR` is set.

Reference: https://no-color.org
"""

from __future__ import annotations

import os
from typing import Literal, TextIO, TypeAlias

Tone: TypeAlias = Literal["plain", "good", "warning", "bad", "head"]
_CODES: dict[Tone, str] = {"good": "32", "warning": "33", "bad": "31", "head": "1"}
_chosen = True


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
