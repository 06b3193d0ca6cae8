"""Tables for people: columns aligned by what is seen, numbers to the right."""

from __future__ import annotations

import math
import unicodedata
from collections.abc import Iterable, Sequence

from mafsil.arrays import Floats
from mafsil.messages.visible import visible


def table(head: Sequence[str], rows: Iterable[Sequence[str]], *, indent: str = "  ") -> list[str]:
    """Lines of a table: the first column to the left, the others to the right."""
    shown = [[visible(cell) for cell in row] for row in (head, *rows)]
    widths = [max(width(row[k]) for row in shown) for k in range(len(head))]
    return [
        (indent + "  ".join(_padded(row[k], size, left=k == 0) for k, size in enumerate(widths))).rstrip()
        for row in shown
    ]


def matrix(values: Floats, *, indent: str = "  ") -> list[str]:
    """Lines of a matrix (rows, columns)."""
    cells = [[number(x) for x in row] for row in values]
    size = max((len(cell) for row in cells for cell in row), default=0)
    return [indent + "  ".join(cell.rjust(size) for cell in row) for row in cells]


def number(value: float, digits: int = 6) -> str:
    """A number with six decimals, rounding dust shown as zero; very small and large ones with an exponent."""
    if math.isinf(value):
        return "∞" if value > 0 else "-∞"
    if abs(value) < 1e-12:
        value = 0.0
    if value and not 1e-4 <= abs(value) < 1e6:
        return f"{value:.{digits - 1}e}"
    return f"{value:.{digits}f}"


def brief(value: float) -> str:
    """A number with four significant digits."""
    if math.isinf(value):
        return "∞" if value > 0 else "-∞"
    return f"{value:.4g}"


def width(text: str) -> int:
    """Columns that a text takes on a terminal: marks above letters and of direction take none, wide letters two."""
    return sum(_columns(character) for character in text)


def _columns(character: str) -> int:
    if unicodedata.combining(character) or unicodedata.category(character) == "Cf":
        return 0
    return 2 if unicodedata.east_asian_width(character) in "WF" else 1


def _padded(text: str, size: int, *, left: bool) -> str:
    space = " " * (size - width(text))
    return text + space if left else space + text
