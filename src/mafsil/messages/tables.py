"""Tables that fit a screen, for what is printed: names to the left, numbers to the right, at most so many rows."""

from __future__ import annotations

import textwrap
import unicodedata
from collections.abc import Sequence
from html import escape
from math import isnan

from mafsil.messages.catalogue import say
from mafsil.messages.isolates import in_cell

MOST_ROWS = 20
"""With head, sentence and remarks a table then stays below 25 lines."""
LONGEST_NAME = 24
"""Longer names are cut [columns]: seven columns of numbers stand beside them in 100."""
LINES, COLUMNS = 25, 100
"""Of a screen."""
JOINT_UNITS = {
    **dict.fromkeys(("start", "end", "error", "lowest", "highest", "length"), "[rad | m]"),
    **dict.fromkeys(("velocity", "rate"), "[rad/s | m/s]"),
    "acceleration": "[rad/s^2 | m/s^2]",
    "jerk": "[rad/s^3 | m/s^3]",
    "effort": "[N m | N]",
}
"""Below the names of columns that are numbers of joints."""


def table(
    head: Sequence[str], rows: Sequence[Sequence[str]], language: str | None = None, units: Sequence[str] = ()
) -> list[str]:
    """Lines of a table, the first column to the left, the others to the right.

    Args:
        head: one cell for each column.
        rows: cells; what is beyond MOST_ROWS is counted in a last line.
        language: `en` or `ar`; the current one if None.
        units: a second line of the head.
    """
    cells = [list(head), *([list(units)] if units else []), *([_cut(row[0]), *row[1:]] for row in rows[:MOST_ROWS])]
    sizes = [max(map(_width, column)) for column in zip(*cells, strict=True)]
    lines = ["  " + "  ".join(_pad(row, sizes, language)).rstrip() for row in cells]
    if len(rows) > MOST_ROWS:
        lines.append("  " + say("messages.more_rows", language=language, count=len(rows) - MOST_ROWS))
    return lines


def joint_units(columns: Sequence[str]) -> list[str]:
    """The units of columns by their names, for a table with a row for each joint; empty where there is none.

    Args:
        columns: such as `start`, `velocity`, `effort`.
    """
    return [JOINT_UNITS.get(name, "") for name in columns]


def number(value: float) -> str:
    """Four digits; a dash for what is not known."""
    return "-" if isnan(value) else f"{value + 0.0:.4g}"


def on_screen(text: str) -> str:
    """A text as far as it fits a screen: long sentences are wrapped, what is beyond the last line is left out."""
    lines = [piece for line in text.split("\n") for piece in ([line] if _width(line) <= COLUMNS else wrap_line(line))]
    return "\n".join(lines if len(lines) <= LINES else [*lines[: LINES - 1], "\N{HORIZONTAL ELLIPSIS}"])


def in_notebook(text: str) -> str:
    """A printed table as HTML that keeps its columns."""
    return f'<pre dir="auto">{escape(text)}</pre>'


def wrap_line(line: str, columns: int = COLUMNS) -> list[str]:
    """A long line in several, broken between words; those that follow are indented by two more.

    Args:
        line: which may begin with blanks.
        columns: of the screen.
    """
    indent = " " * (len(line) - len(line.lstrip()))
    room = max(columns, len(indent) + 22)
    return textwrap.wrap(
        line.strip(),
        room,
        initial_indent=indent,
        subsequent_indent=indent + "  ",
        break_long_words=False,
        break_on_hyphens=False,
    )


def _cut(name: str) -> str:
    return name if len(name) <= LONGEST_NAME else name[: LONGEST_NAME - 1] + "…"


def _width(text: str) -> int:
    return sum(not (unicodedata.combining(c) or unicodedata.category(c) == "Cf") for c in text)


def _pad(row: Sequence[str], sizes: Sequence[int], language: str | None) -> list[str]:
    pieces: list[str] = []
    for k, (cell, size) in enumerate(zip(row, sizes, strict=True)):
        space, shown = " " * (size - _width(cell)), in_cell(cell, language)
        pieces.append(space + shown if k else shown + space)
    return pieces
