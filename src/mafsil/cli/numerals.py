"""Numbers as people type them: with a unit, as a fraction of pi, in degrees when marked."""

from __future__ import annotations

from math import pi

from mafsil.errors import InputError
from mafsil.messages.visible import visible
from mafsil.typed_number import UNITS, read_number


def number(name: str, text: str) -> float:
    """A number, perhaps with a unit: `-0.2`, `30deg`, `120mm`, `pi/2`, `-2pi/3`.

    Args:
        name: of the argument, for the error.
        text: what was typed.

    Raises:
        InputError: it is no number, or the unit is not known.
    """
    return _read(name, text)[0]


def coordinate(name: str, text: str) -> tuple[float, bool]:
    """A joint coordinate, and whether its unit was written (so that `--degrees` must not touch it)."""
    return _read(name, text)


def angle(name: str, text: str, *, degrees: bool) -> float:
    """A number whose unit, if it has one, stands; a bare one is in degrees if that is asked.

    Args:
        name: of the argument, for the error.
        text: what was typed.
        degrees: whether bare numbers are degrees.
    """
    value, marked = coordinate(name, text)
    return value * pi / 180 if degrees and not marked else value


def count(name: str, text: str) -> int:
    """A whole number from 0 on.

    Raises:
        InputError: it is none.
    """
    if not (text.isascii() and text.isdigit() and len(text) < 10):
        raise InputError("cli.whole", name=name, text=visible(text))
    return int(text)


def _read(name: str, text: str) -> tuple[float, bool]:
    typed = read_number(text)
    if typed is None:
        raise InputError("cli.no_number", name=name, text=visible(text))
    if typed.unit not in UNITS:
        raise InputError("cli.no_unit", name=name, text=visible(text), known=", ".join(u for u in UNITS if u))
    return typed.value * UNITS[typed.unit], bool(typed.unit) or typed.is_angle


def typed_value(words: str) -> bool | float | str:
    """What is typed for a variable: true, false, a number, else a text.

    Args:
        words: as typed.
    """
    word = words.strip()
    if word in ("true", "false"):
        return word == "true"
    try:
        return float(word)
    except ValueError:
        return words
