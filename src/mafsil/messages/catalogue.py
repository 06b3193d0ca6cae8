"""Sentences by key. `area.name` stands in `<language>/<area>.toml`; areas are read at their first use.

Counted things: the form of a noun that belongs to a number, in English two, in Arabic six.

Reference: Unicode Common Locale Data Repository, language plural rules (cardinal numbers, integers).
"""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Callable, Iterable
from functools import cache
from importlib import resources
from string import Formatter
from typing import Any, Protocol, runtime_checkable

COUNTED = "#"
"""In a sentence `{errors:#error}` is the number of errors with its noun."""
_FORMS = {"en": ("one", "other"), "ar": ("zero", "one", "two", "few", "many", "other")}
_SMALL = {0: "zero", 1: "one", 2: "two"}
LANGUAGES = ("en", "ar")
_TWICE = re.compile(r"(?<![<\w])joint (?=joint)")


@runtime_checkable
class Spoken(Protocol):
    """A fact that has words in each language."""

    def spoken(self, language: str | None = None) -> str:
        """The words, in the given language or the current one."""
        ...


_chosen: str | None = None


def language(code: str | None = None) -> str:
    """Choose the language of all messages of this process, or return the current one.

    Args:
        code: `en` or `ar`; None changes nothing. The environment variable MAFSIL_LANG sets the language at start.

    Returns:
        The language now in force.

    Raises:
        ValueError: the language is not one of LANGUAGES.
    """
    global _chosen
    if code is not None:
        if code not in LANGUAGES:
            raise ValueError(say("messages.language", code=code, known=", ".join(LANGUAGES)))
        _chosen = code
    return _current()


def _current() -> str:
    if _chosen is not None:
        return _chosen
    from_environment = os.environ.get("MAFSIL_LANG", "en")[:2].lower()
    return from_environment if from_environment in LANGUAGES else "en"


def direction(code: str | None = None) -> str:
    """Writing direction of a language: `ltr` or `rtl`."""
    return "rtl" if (code or language()) == "ar" else "ltr"


def say(key: str, *, language: str | None = None, **details: object) -> str:
    """The sentence `key` with its details filled in.

    Args:
        key: `area.name`.
        language: `en` or `ar`; the current language if None.
        details: values for the placeholders of the sentence (str.format); `{count:#noun}` is a number with its noun;
            one that has words of its own in each language gives them by `spoken(language)`.
    """
    details |= {name: fact.spoken(language) for name, fact in details.items() if isinstance(fact, Spoken)}
    sentence = template(key, language)
    if ":#" not in sentence:
        return _once(sentence.format(**details))
    code = language or _current()
    return _once(Filling(code, lambda noun: template(f"plurals.{noun}", code)).vformat(sentence, (), details))


def clauses(sentences: Iterable[str], language: str | None = None) -> str:
    """Several sentences in one, parted as the language parts them."""
    return template("messages.between_clauses", language).join(sentences)


def _once(sentence: str) -> str:
    """The sentence without `joint` before a name that begins with it: `joint joint2` is `joint2`."""
    return _TWICE.sub("", sentence) if "joint joint" in sentence else sentence


def template(key: str, code: str | None = None) -> str:
    """The sentence `key` with its placeholders unfilled.

    Raises:
        ValueError: the language is not one of LANGUAGES.
    """
    if code is not None and code not in LANGUAGES:
        raise ValueError(say("messages.language", code=code, known=", ".join(LANGUAGES)))
    area, _, name = key.partition(".")
    return _area(code or language(), area)[name]


def placeholders(key: str, code: str | None = None) -> list[str]:
    """Names that the sentence `key` wants filled in, without what is asked of their values: `gains` of `{gains.kp}`."""
    return [re.split(r"[.\[]", name)[0] for _, name, _, _ in Formatter().parse(template(key, code)) if name]


def keys(code: str, area: str) -> frozenset[str]:
    """Names of all sentences of an area."""
    return frozenset(_area(code, area))


@cache
def _area(code: str, area: str) -> dict[str, str]:
    text = resources.files("mafsil.messages").joinpath(code, f"{area}.toml").read_text(encoding="utf-8")
    return tomllib.loads(text)


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


def count_noun(count: int, forms: str, language: str) -> str:
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
            return count_noun(int(value), self.forms_of(format_spec.removeprefix(COUNTED)), self.language)
        return str(super().format_field(value, format_spec))
