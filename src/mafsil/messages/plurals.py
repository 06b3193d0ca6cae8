"""Counted things: the form of a noun that belongs to a number, in English two, in Arabic six.

Reference: Unicode Common Locale Data Repository, language plural rules (cardinal numbers, integers).
"""

from __future__ import annotations

from collections.abc import Callable
from string import Formatter
from typing import Any

COUNTED = "#"
"""In a sentence `{errors:#error}` is the number of errors with its noun."""
_FORMS = {"en": ("one", "other"), "ar": ("zero", "one", "two", "few", "many", "other")}
_SMALL = {0: "zero", 1: "one", 2: "two"}


def category(count: int, language: str) -> str:
    """Which form of a noun goes with a number: `zero`, `one`, `two`, `few`, `many` or `other`.

    Args:
        count: how many.
        language: `en` or `ar`.
    """
    if language != "ar":
        return "one" if count == 1 else "other"
    rest = count % 100
    return _SMALL.get(count, "few" if 3 <= rest <= 10 else "many" if rest >= 11 else "other")


def counted(count: int, forms: str, language: str) -> str:
    """A number with its noun: `1 solution`, `3 solutions`.

    Args:
        count: how many.
        forms: those of the noun in the order of the language's categories, between bars; `{n}` is the number.
        language: `en` or `ar`.
    """
    return forms.split(" | ")[_FORMS[language].index(category(count, language))].format(n=count)


class Filling(Formatter):
    """str.format that knows `{count:#noun}`.

    Args:
        language: of the nouns.
        forms_of: gives the forms of a noun by its name.
    """

    def __init__(self, language: str, forms_of: Callable[[str], str]) -> None:
        super().__init__()
        self.language = language
        self.forms_of = forms_of

    def format_field(self, value: Any, format_spec: str) -> str:
        """One filled place of a sentence."""
        if format_spec.startswith(COUNTED):
            return counted(int(value), self.forms_of(format_spec.removeprefix(COUNTED)), self.language)
        return str(super().format_field(value, format_spec))
