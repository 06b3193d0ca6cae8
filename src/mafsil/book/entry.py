"""What figures and worked examples of the book share: live objects, facts beside the printed ones, words, the index."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from html import escape
from importlib import import_module
from typing import Any, ClassVar, Generic, TypeVar

import numpy as np

from mafsil.answer import Answer, Status
from mafsil.errors import InputError
from mafsil.messages import direction, keys, say
from mafsil.messages.catalogue import placeholders

T = TypeVar("T")
BESIDE: dict[str, list[Callable[[str | None], str]]] = {}
"""Remarks that `explain` of a figure or an example says, by its number."""


class EntryStatus(Status):
    """How much of an entry the source fixes."""

    FIXED = ("book.fixed", True)
    REBUILT = ("book.rebuilt", True)
    SCHEMATIC = ("book.schematic", True)
    MISSING = ("book_pages.no_page", False)


@dataclass(frozen=True, slots=True)
class Slider:
    """A number that redraws a figure.

    Attributes:
        least, greatest: between which it lies.
        value: at first.
        unit: of all three.
    """

    least: float
    greatest: float
    value: float
    unit: str = "rad"


@dataclass(frozen=True, eq=False, slots=True)
class Fact:
    """A number that an entry states, computed here.

    Attributes:
        name: of its words in the catalogue.
        value: ours: a number, an array or a text.
        printed: what the source prints; None if it prints none.
        unit: of both.
    """

    name: str
    value: Any
    printed: Any = None
    unit: str = ""

    @property
    def agrees(self) -> bool:
        """Whether the printed number is ours to its printed digits (a relative difference of 0.5 %)."""
        if self.printed is None or isinstance(self.value, str):
            return self.printed is None or self.printed == self.value
        return bool(np.allclose(self.value, self.printed, rtol=5e-3, atol=1e-9))


@dataclass(frozen=True, eq=False, repr=False)
class Entry(Answer):
    """A figure or a worked example of the book.

    Attributes:
        number: as the source has it.
        status: how much of it the source fixes.
        objects: what it is about, live, by name.
        facts: its numbers, beside the printed ones.
    """

    AREA: ClassVar[str]
    number: str
    status: EntryStatus
    objects: Mapping[str, Any]
    facts: tuple[Fact, ...]

    def __getitem__(self, name: str) -> Any:
        """The fact of that name, its value."""
        return next(fact.value for fact in self.facts if fact.name == name)

    @property
    def title(self) -> str:
        """Its name, in the current language."""
        return self.words()

    @property
    def caption(self) -> str:
        """What it shows, in the current language; where geometry had to be chosen, the choices."""
        return " ".join(text for part in ("caption", "chosen") if (text := self.words(part)))

    @property
    def erratum(self) -> str:
        """What the source prints wrongly, and why; empty where nothing is known to be wrong."""
        return self.words("erratum")

    def words(self, part: str = "", language: str | None = None) -> str:
        """A sentence of this entry with its facts filled in; empty where there is none.

        Args:
            part: such as `caption`; its title if empty.
            language: `en` or `ar`; the current one if None.
        """
        key = f"{self.number}.{part}" if part else self.number
        if key not in keys(language or "en", self.AREA):
            return ""
        return say(f"{self.AREA}.{key}", language=language, **{fact.name: shown(fact.value) for fact in self.facts})

    def explain(self, language: str | None = None) -> str:
        """Title, caption, choices, facts beside the printed ones, erratum, in `en`, `ar` or the current language."""
        heading = say(f"{self.AREA}.heading", language=language, number=self.number, title=self.words("", language))
        parts = [self.words(part, language) for part in ("caption", "chosen")]
        facts = [self.fact_line(fact, language) for fact in self.facts if not self._stands_in_caption(fact, language)]
        wrong = self.words("erratum", language)
        lines = [heading, *parts, *facts, say("book.erratum", language=language, text=wrong) if wrong else ""]
        lines += [remark(language) for remark in BESIDE.get(self.number, ())]
        return "\n".join(line for line in lines if line)

    def fact_line(self, fact: Fact, language: str | None = None) -> str:
        """A fact as a sentence, beside what is printed."""
        key = "fact" if fact.printed is None else "fact_printed" if fact.agrees else "fact_differs"
        unit = f" {fact.unit}" if fact.unit else ""
        details = {"value": shown(fact.value) + unit, "printed": shown(fact.printed)}
        return say(f"book.{key}", language=language, name=self._fact_name(fact, language) or fact.name, **details)

    def _fact_name(self, fact: Fact, language: str | None) -> str:
        """Words for a fact, own ones or those that entries share; empty where there are none."""
        shared = f"fact_{fact.name}"
        known = shared in keys(language or "en", self.AREA)
        return self.words(fact.name, language) or (say(f"{self.AREA}.{shared}", language=language) if known else "")

    def _stands_in_caption(self, fact: Fact, language: str | None) -> bool:
        """Whether a fact without words of its own stands in the caption."""
        key = f"{self.number}.caption"
        captioned = key in keys(language or "en", self.AREA) and fact.name in placeholders(
            f"{self.AREA}.{key}", language
        )
        return captioned and not self._fact_name(fact, language)

    def to_dict(self) -> dict[str, Any]:
        """Number, title, caption, erratum and facts as plain data."""
        facts = {fact.name: {"value": fact.value, "printed": fact.printed, "unit": fact.unit} for fact in self.facts}
        head = {"number": self.number, "status": self.status.name.lower(), "title": self.title, "caption": self.caption}
        return {**head, "erratum": self.erratum, "facts": facts}

    def _repr_html_(self) -> str:
        lines = self.explain().split("\n")
        return "".join(f'<div dir="{direction()}">{escape(line)}</div>' for line in lines)


def shown(value: Any) -> str:
    """A number, an array or a text as a sentence has it: four digits, no rounding dust."""
    if isinstance(value, str) or value is None:
        return value or ""
    array = np.asarray(value)
    if array.ndim:
        return "(" + ", ".join(shown(item) for item in array) + ")"
    if array.dtype.kind in "biu":
        return str(array.item())
    return f"{0.0 if abs(float(array)) < 5e-12 else float(array):.4g}"


def matrix_text(value: Any) -> Any:
    """Matrices as `[1 0; 0 1]`, vectors as `(1, 0)`, numbers with four digits; what speaks for itself stays."""
    if hasattr(value, "spoken"):
        return value
    array = np.asarray(value)
    if array.ndim == 2:
        return "[" + "; ".join(" ".join(shown(item) for item in row) for row in array) + "]"
    return value if array.dtype.kind in "biu" and not array.ndim else shown(value)


class Index(Generic[T]):
    """Entries by number, declared in modules of the package that are imported at the first look-up.

    Args:
        modules: names of modules in `mafsil.book`.
        unknown: key of the sentence for a number that is not there.
    """

    def __init__(self, modules: tuple[str, ...], unknown: str) -> None:
        self._modules, self._unknown = modules, unknown
        self._makers: dict[str, T] = {}

    def declare(self, number: str, maker: T) -> None:
        """Add an entry."""
        self._makers[number] = maker

    def numbers(self) -> list[str]:
        """Of all entries, in order."""
        for module in self._modules:
            import_module(f"mafsil.book.{module}")
        return sorted(self._makers, key=_place)

    def __getitem__(self, number: str) -> T:
        """What makes the entry of that number.

        Raises:
            InputError: there is none; the sentence has the numbers that look like it.
        """
        known = self.numbers()
        if number not in self._makers:
            near = get_close_matches(str(number), known, n=5, cutoff=0.3) or known[:5]
            raise InputError(self._unknown, number=str(number), known=", ".join(near))
        return self._makers[number]


def _place(number: str) -> tuple[tuple[int, ...], str]:
    first, _, rest = number.partition(" ")
    return tuple(int(part) for part in first.split(".") if part.isdigit()), rest
