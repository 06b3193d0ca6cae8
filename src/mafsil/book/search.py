"""Search in the words of the book: Arabic with and without marks, article and joined particles; English in any case."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache

from mafsil.book.edition import sections
from mafsil.book.errata import errata
from mafsil.book.example import examples
from mafsil.book.exercise import exercises
from mafsil.book.figure import figures
from mafsil.book.remarks import remarks
from mafsil.messages import LANGUAGES, keys
from mafsil.messages.catalogue import template

_KINDS = {
    "section": ("book_pages", sections), "figure": ("book_figures", figures), "example": ("book_examples", examples),
    "remark": ("book_remarks", remarks), "exercise": ("book_exercises", exercises), "erratum": ("book_errata", errata),
}  # fmt: skip
_PARTS = ("caption", "erratum", "text", "hint1", "hint2")
_MARKS = re.compile("[\u0610-\u061a\u064b-\u0652\u0670\u0640]")
_LETTERS = str.maketrans("أإآٱىةؤئ", "ااااي" + "هوي")
_PREFIX = "(?:[وف]?(?:ال|بال|كال|لل|[بكل])?)"
_ARTICLE = re.compile(f"^{_PREFIX}(?=[\u0600-\u06ff]{{3}})")


def find(words: str, /) -> list[tuple[str, str, str]]:
    """Sections, figures, examples, remarks, exercises and errata of the book that have all the words.

    Args:
        words: in Arabic or English; beginnings of words are enough.

    Returns:
        Kind, number and title in the language of the words, those with the words in the title first.
    """
    words = str(words)
    sought = [_pattern(word) for word in _plain(words).split()]
    code = "ar" if re.search("[\u0600-\u06ff]", words) else "en"
    hits: list[tuple[bool, str, str, str]] = []
    for (kind, number), (title, rest) in _texts(code).items() if sought else ():
        where = [(pattern.search(_plain(title)), pattern.search(rest)) for pattern in sought]
        if all(any(places) for places in where):
            hits.append((not all(places[0] for places in where), kind, number, title))
    return [(kind, number, title) for _, kind, number, title in sorted(hits, key=lambda entry: entry[0])]


@cache
def _texts(code: str) -> Mapping[tuple[str, str], tuple[str, str]]:
    """Title and plain words of each entry, by kind and number."""
    assert code in LANGUAGES
    texts: dict[tuple[str, str], tuple[str, str]] = {}
    for kind, (area, numbers) in _KINDS.items():
        known = keys(code, area)
        for number in numbers():
            head = number if number in known else f"{number}.title"
            rest = [template(f"{area}.{key}", code) for key in (f"{number}.{part}" for part in _PARTS) if key in known]
            texts[kind, number] = template(f"{area}.{head}", code), _plain(" ".join([number, *rest]))
    return texts


def _plain(text: str) -> str:
    """Small letters, without marks; letters that people write one for another are one."""
    return _MARKS.sub("", text).translate(_LETTERS).lower()


def _pattern(word: str) -> re.Pattern[str]:
    """Finds a word that begins so, whatever particles are joined to it."""
    stem = _ARTICLE.sub("", word)
    return re.compile(rf"(?<!\w){_PREFIX}(?:{re.escape(word)}|{re.escape(stem)})")
