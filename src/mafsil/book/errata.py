"""Errata of the source by number, each with what is right and what is printed, both computed where a number decides."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from typing import TYPE_CHECKING, Any, ClassVar, cast

from mafsil.book.entry import Entry, EntryStatus, Fact, matrix_text
from mafsil.errors import InputError
from mafsil.lazy_module import lazily
from mafsil.messages import say
from mafsil.toml_source import own_tables

if TYPE_CHECKING:
    import mafsil.book.counterexamples as counterexamples
else:
    counterexamples = lazily("mafsil.book.counterexamples")


@dataclass(frozen=True, eq=False, repr=False)
class Erratum(Entry):
    """What a section of the source prints wrongly; see `Entry`.

    Attributes:
        section: where it stands.
        ours, printed: what is computed as right and as printed, as one can type it in Python (`mf` is the package);
            empty where the printing or the wording is wrong and no number decides.
    """

    AREA: ClassVar[str] = "book_errata"
    section: str
    ours: str = ""
    printed: str = ""

    @property
    def proof(self) -> Fact | None:
        """Both numbers; None where no number decides."""
        return self.facts[0] if self.facts else None

    def explain(self, language: str | None = None) -> str:
        """What is wrong, and the numbers that decide, in `en`, `ar` or the current language."""
        lines = [say(f"{self.AREA}.heading", language=language, number=self.number, text=self.words("", language))]
        if self.proof:
            ours = _equation(self.ours, self.proof.value, language)
            printed = _equation(self.printed, self.proof.printed, language)
            lines.append(say(f"{self.AREA}.proof", language=language, ours=ours, printed=printed))
        return "\n".join(lines)


@cache
def _data() -> Mapping[str, Mapping[str, str]]:
    return cast("Mapping[str, Mapping[str, str]]", own_tables(__file__))


def errata(section: str = "") -> list[str]:
    """Numbers of all errata of the source, or of those of a section alone.

    Args:
        section: such as "4.2.3".
    """
    return [number for number, entry in _data().items() if section in ("", entry["section"])]


def erratum(number: str, /) -> Erratum:
    """An erratum of the source with its proof.

    Args:
        number: part, E (first list) or D (further list) and number: "04-E16".

    Raises:
        InputError: no erratum of that number.
    """
    if str(number) not in _data():
        near = get_close_matches(str(number), _data(), n=5, cutoff=0.3) or list(_data())[:5]
        raise InputError("book_errata.unknown", number=str(number), known=", ".join(near))
    entry = _data()[number]
    sides = [_value(entry[side]) for side in ("ours", "printed") if side in entry]
    return Erratum(number, EntryStatus.FIXED, {}, (Fact("proof", *sides),) if sides else (), **entry)


@cache
def _value(formula: str) -> Any:
    """The formulas are those of `errata.toml` of this package, never a reader's."""
    return eval(formula, dict(counterexamples.NAMES))


def _equation(formula: str, value: Any, language: str | None) -> str:
    """A formula and its value; a number that stands for itself alone."""
    is_flag = isinstance(value, bool)
    text = say(f"book_exercises.{'yes' if value else 'no'}", language=language) if is_flag else str(matrix_text(value))
    return text if re.fullmatch(r"-?[\d.]+|\((-?[\d.]+(, )?)+\)", formula) else f"{formula} = {text}"
