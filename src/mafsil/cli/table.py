"""Tables and named values for people: columns aligned by what is seen, numbers right, no wider than the terminal."""

from __future__ import annotations

import math
import shutil
import unicodedata
from collections.abc import Collection, Iterable, Mapping, Sequence
from itertools import zip_longest
from textwrap import wrap
from typing import Any, cast

from mafsil.arrays import Floats
from mafsil.cli.answer import Head, Laid
from mafsil.cli.tolerances import ROUNDOFF
from mafsil.messages import say
from mafsil.messages.isolates import in_cell
from mafsil.messages.visible import visible

NARROWEST = 40
"""A terminal is taken to have at least so many columns."""
NARROWEST_WORDS = 24
"""Columns below which words are not wrapped in a column of a table."""
_GAP = "  "


def columns() -> int:
    """Columns of the terminal; 80 where there is none, such as in a pipe or a file."""
    return max(NARROWEST, shutil.get_terminal_size((80, 24)).columns)


def table(
    head: Sequence[str], rows: Iterable[Sequence[str]], *, indent: str = "  ", words: Collection[int] = ()
) -> list[str]:
    """Lines of a table: the first column and those of words to the left, the others to the right.

    What is too wide for the terminal has its widest column of words wrapped. Without such a column it is turned, rows
    into columns, if that makes it fit; else it is cut into blocks of columns, each with the first column again.

    Args:
        head: one cell for each column.
        rows: cells.
        indent: in front of every line.
        words: indices of further columns that hold words.
    """
    upright = [[visible(cell) for cell in row] for row in (head, *rows)]
    available = columns() - len(indent)
    every = list(range(len(head)))
    if _total(upright, every) <= available or len(head) == 1:
        return _lines(upright, every, indent, words)
    if words and (wrapped := _wrap(upright, max(words, key=_widths(upright).__getitem__), available)):
        return _lines(wrapped, every, indent, words)
    turned = [list(column) for column in zip(*upright, strict=True)]
    if _total(turned, range(len(turned[0]))) <= available:
        return _lines(turned, range(len(turned[0])), indent, ())
    groups = _groups(upright, available)
    return [line for group in groups for line in ("", *_lines(upright, group, indent, words))][1:]


def label_lines(rows: Iterable[Sequence[str]], *, indent: str = "  ") -> list[str]:
    """Lines of numbers behind their labels; where the terminal is too narrow, below them.

    Args:
        rows: label and numbers of each line.
        indent: in front of every line.
    """
    cells = [(visible(label), [visible(text) for text in texts]) for label, *texts in rows]
    first = max((width(label) for label, _ in cells), default=0)
    sizes = [max(map(width, column)) for column in zip_longest(*(texts for _, texts in cells), fillvalue="")]
    beside = len(indent) + first + sum(len(_GAP) + size for size in sizes) <= columns()
    lines: list[str] = []
    for label, texts in cells:
        numbers = _GAP.join(_pad(text, size, left=False) for text, size in zip(texts, sizes, strict=False))
        shown = _pad(label, first if beside else width(label), left=True)
        lines += [f"{indent}{shown}{_GAP}{numbers}"] if beside else [indent + shown, f"{indent}{indent}{numbers}"]
    return [Laid(line.rstrip()) for line in lines]


def matrix(values: Floats, *, indent: str = "  ") -> list[str]:
    """Lines of a matrix (rows, columns), with fewer decimals where the terminal is narrow."""
    available = columns() - len(indent)
    for digits in (6, 4, 3):
        cells = [[number(x, digits) for x in row] for row in values]
        size = max((len(cell) for row in cells for cell in row), default=0)
        if not cells or (size + len(_GAP)) * len(cells[0]) - len(_GAP) <= available:
            break
    return [Laid(indent + _GAP.join(in_cell(cell.rjust(size)) for cell in row)) for row in cells]


def number(value: float, digits: int = 6) -> str:
    """A number with six decimals, roundoff shown as zero; very small and large ones with an exponent."""
    if math.isinf(value):
        return "∞" if value > 0 else "-∞"
    if abs(value) < ROUNDOFF:
        value = 0.0
    if value and not 1e-4 <= abs(value) < 1e6:
        return f"{value:.{digits - 1}e}"
    return f"{value:.{digits}f}"


def brief(value: float) -> str:
    """A number with four significant digits, roundoff shown as zero."""
    if math.isinf(value):
        return "∞" if value > 0 else "-∞"
    return f"{value if abs(value) >= ROUNDOFF else 0.0:.4g}"


def width(text: str) -> int:
    """Columns that a text takes on a terminal: marks above letters and of direction take none, wide letters two."""
    return sum(_columns(character) for character in text)


def _columns(character: str) -> int:
    if unicodedata.combining(character) or unicodedata.category(character) == "Cf":
        return 0
    return 2 if unicodedata.east_asian_width(character) in "WF" else 1


def _widths(cells: list[list[str]]) -> list[int]:
    return [max(map(width, column)) for column in zip(*cells, strict=True)]


def _total(cells: list[list[str]], group: Sequence[int]) -> int:
    sizes = _widths(cells)
    return sum(sizes[k] for k in group) + len(_GAP) * (len(group) - 1)


def _wrap(cells: list[list[str]], column: int, available: int) -> list[list[str]]:
    """Rows whose cells of one column are wrapped between words into further rows; none if it gets too narrow."""
    room = available - _total(cells, range(len(cells[0]))) + _widths(cells)[column]
    if room < NARROWEST_WORDS:
        return []
    rows: list[list[str]] = []
    for row in cells:
        pieces = wrap(row[column], room, break_long_words=False) or [""]
        blank = [""] * len(row)
        for piece, others in zip(pieces, [row, *[blank] * len(pieces)], strict=False):
            rows.append([*others[:column], piece, *others[column + 1 :]])
    return rows


def _groups(cells: list[list[str]], available: int) -> list[list[int]]:
    """Columns in groups that fit, each behind the first column."""
    groups = [[0]]
    for k in range(1, len(cells[0])):
        if len(groups[-1]) > 1 and _total(cells, [*groups[-1], k]) > available:
            groups.append([0])
        groups[-1].append(k)
    return groups


def _lines(cells: list[list[str]], group: Sequence[int], indent: str, words: Collection[int]) -> list[str]:
    sizes = _widths(cells)
    rows = (_GAP.join(_pad(row[k], sizes[k], left=k == 0 or k in words) for k in group) for row in cells)
    first, *others = ((indent + row).rstrip() for row in rows)
    return [Head(first), *map(Laid, others)]


def _pad(text: str, size: int, *, left: bool) -> str:
    """A cell in an isolate of its own, so that neighbours keep their columns whatever the direction of the line."""
    space, shown = " " * (size - width(text)), in_cell(text)
    return shown + space if left else space + shown


def details(values: Mapping[str, Any]) -> list[str]:
    """A line for each fact, named in the reader's language; variables of the environment keep their names.

    Args:
        values: plain data by name.
    """
    lines: list[str] = []
    for name, value in values.items():
        label = name if name.isupper() else say(f"cli.fact_{name}")
        parts: list[Any] = list(cast("list[Any]", value)) if isinstance(value, list | tuple) else [value]
        words = [say("cli.yes" if part else "cli.no") if isinstance(part, bool) else str(part) for part in parts]
        lines.append(f"  {label}: {', '.join(words)}")
    return lines
