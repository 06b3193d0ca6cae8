"""The strict decimal grammar of robot files, and what to say about everything else that looks like a number."""

from __future__ import annotations

import math
import re
import unicodedata

from mafsil.model.diagnostics import Fault
from mafsil.model.faults import (
    DECIMAL_COMMA,
    HEXADECIMAL,
    LOCAL_DIGITS,
    NOT_A_NUMBER,
    NOT_FINITE,
    OVERFLOW,
    TOO_BIG,
    UNDERFLOW,
    WITH_UNIT,
)

LARGEST = 1e15
"""Beyond this no mass, length or inertia in SI units is meant; joint limits may be larger."""
LONGEST = 400
_DECIMAL = re.compile(r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_HEXADECIMAL = re.compile(r"[+-]?0[xX][0-9a-fA-F]+")
_COMMA = re.compile(r"([+-]?[0-9]+),([0-9]+(?:[eE][+-]?[0-9]+)?)")
_UNIT = re.compile(r"([+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)\s*(kg|m|rad|N|Nm|s|kgm2|kg\.m2)")
_NOT_FINITE = {"nan", "inf", "infinity"}
_SEPARATORS = {"٫": ".", "٬": "", "−": "-"}


def decimal(text: str, *, largest: float = LARGEST) -> tuple[float, Fault | None]:
    """The number a word stands for, and what is wrong with it.

    Args:
        text: one word without blanks.
        largest: magnitude beyond which it is refused.

    Returns:
        The value (0.0 if it has none) and the fault, or None.
    """
    if len(text) > LONGEST or not _DECIMAL.fullmatch(text):
        return 0.0, _kind_of_nonsense(text)
    value = float(text)
    if math.isinf(value):
        return 0.0, OVERFLOW
    if abs(value) > largest:
        return 0.0, TOO_BIG
    if value == 0.0 and any(c in "123456789" for c in re.split("[eE]", text)[0]):
        return 0.0, UNDERFLOW
    return value, None


def proposal(text: str) -> str | None:
    """The plain decimal that a faulty word most probably means, or None."""
    word = text.strip()
    if len(word) > LONGEST:
        return None
    if found := _COMMA.fullmatch(word):
        return f"{found[1]}.{found[2]}"
    if _HEXADECIMAL.fullmatch(word):
        return str(int(word, 16))
    if found := _UNIT.fullmatch(word):
        return found[1]
    western = _with_western_digits(word)
    return western if western != word and _DECIMAL.fullmatch(western) else None


def written(value: float) -> str:
    """The shortest decimal that reads back as the same double."""
    text = repr(float(value))
    return text.removesuffix(".0")


def _kind_of_nonsense(text: str) -> Fault:
    word = text.strip().lower()
    if len(word) > LONGEST:
        return NOT_A_NUMBER
    if word.lstrip("+-") in _NOT_FINITE:
        return NOT_FINITE
    if _HEXADECIMAL.fullmatch(word):
        return HEXADECIMAL
    if _COMMA.fullmatch(word):
        return DECIMAL_COMMA
    if _UNIT.fullmatch(text.strip()):
        return WITH_UNIT
    return LOCAL_DIGITS if any(c.isdecimal() and c > "\x7f" for c in word) else NOT_A_NUMBER


def _with_western_digits(word: str) -> str:
    return "".join(_SEPARATORS.get(c, str(unicodedata.decimal(c)) if c.isdecimal() else c) for c in word)
