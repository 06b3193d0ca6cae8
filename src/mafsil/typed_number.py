"""The one grammar of numbers as people type them: `-0.2`, `30deg`, `٣٠°`, `250 mm`, `pi/2`, `-2π/3`."""

from __future__ import annotations

import re
from math import pi
from typing import NamedTuple

UNITS = {
    "": 1.0, "rad": 1.0, "deg": pi / 180, "°": pi / 180, "m": 1.0, "cm": 0.01, "mm": 0.001, "s": 1.0, "ms": 0.001,
}  # fmt: skip
"""Factor to SI of each unit that may follow a number."""
WESTERN = dict(zip("٠١٢٣٤٥٦٧٨٩٫−،؛", "0123456789.-,;", strict=True))
"""Western digits and signs by the Arabic ones."""
_ARABIC = str.maketrans("0123456789.", "٠١٢٣٤٥٦٧٨٩٫")
_DIGITS = re.compile(r"(?<![\w^])\d+(?:\.\d+)*(?!\w)")
NUMBER = "".join((
    r"\s*([+-]?)\s*",  # sign
    r"(\d+(?:_\d+)*\.?\d*(?:e[+-]?\d+)?|\.\d+(?:e[+-]?\d+)?|inf|nan)?",  # digits
    r"\s*\*?\s*(pi|π)?(?:\s*/\s*(\d+\.?\d*))?",  # times pi, divided
    r"\s*([a-z°]*)\s*",  # unit
))  # fmt: skip
"""The grammar, in what regular expressions of Python and of a page have in common; case says nothing."""
_NUMBER = re.compile(NUMBER, re.ASCII | re.IGNORECASE)


class TypedNumber(NamedTuple):
    """What stands in a text.

    Attributes:
        value: before its unit is applied.
        unit: as written; empty where there is none.
        is_angle: whether it is a multiple of pi.
    """

    value: float
    unit: str
    is_angle: bool


def western(text: str) -> str:
    """The text with Western digits, decimal point, minus and commas."""
    return text.translate(str.maketrans(WESTERN))


def eastern(text: str) -> str:
    """The text with its free-standing numbers in Arabic-Indic digits; names such as x2 and 2R stay."""

    def write(number: re.Match[str]) -> str:
        is_section = number[0].count(".") > 1
        return number[0].replace(".", "\0" if is_section else ".").translate(_ARABIC).replace("\0", ".")

    return _DIGITS.sub(write, text)


def read_number(text: str) -> TypedNumber | None:
    """A number, perhaps a multiple of pi, divided, with a unit; None where the text is none or divides by zero.

    Args:
        text: one number, in Western or Arabic-Indic digits.
    """
    match = _NUMBER.fullmatch(western(text))
    sign, digits, turn, divisor, unit = match.groups() if match else ("", None, None, None, "")
    if not (digits or turn) or (divisor and not float(divisor)):
        return None
    size = float(digits or 1) * (pi if turn else 1.0) / float(divisor or 1)
    return TypedNumber(-size if sign == "-" else size, unit, bool(turn))
