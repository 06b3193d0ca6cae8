"""Exercises of the book by section: random numbers, hints, full solution, and a checker that names the mistake."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from html import escape
from typing import Any
from zlib import crc32

import numpy as np

from mafsil.arrays import whole
from mafsil.book.entry import matrix_text
from mafsil.book.family import AREA, Draw, Task, families, family_of
from mafsil.book.judging import Asked, Assessment, assess
from mafsil.derivation import Derivation, to_text
from mafsil.errors import InputError
from mafsil.messages import clauses, direction, keys, say
from mafsil.messages import language as current_language

LEVELS = (1, 2, 3)
_ATTEMPTS = 400


@dataclass(frozen=True, eq=False, repr=False)
class Exercise:
    """An exercise of the book with its own numbers.

    Attributes:
        number: section of the source and name of the family.
        seed, level: from which it was drawn.
        asked: what is to be found.
        facts: givens and intermediate numbers by name.
        derivation: writes the general solution, or None.
        hidden: name of the given that the text calls X; empty where there is none.
    """

    number: str
    seed: int
    level: int
    asked: tuple[Asked, ...]
    facts: Mapping[str, Any]
    derivation: Callable[[], Derivation] | None = field(default=None)
    hidden: str = ""

    @property
    def title(self) -> str:
        """Its name, in the current language."""
        return self.words("title")

    def words(self, part: str, language: str | None = None) -> str:
        """A sentence of this exercise with its numbers filled in; empty where there is none.

        Args:
            part: `title`, `text`, `hint1`, `step1` and so on.
            language: `en` or `ar`; the current one if None.
        """
        facts = {name: matrix_text(fact) for name, fact in self.facts.items()}
        return _fill(self.number, part, facts, self.hidden, language)

    def hints(self, language: str | None = None) -> list[str]:
        """Hints, each saying more than the one before; the last is the first step of the solution if none says it."""
        return [*self._number_lines("hint", language), *self._number_lines("step", language)[:1]][:3]

    def solution(self, language: str | None = None) -> list[str]:
        """The steps of the full solution, and the results."""
        results = [
            say(f"{AREA}.result", language=language, name=part.label(language), value=value_text(part, language))
            for part in self.asked
        ]
        last = filter(None, [self.words("end", language)])
        return [*self._number_lines("step", language), *last, clauses(results, language)]

    def derive(self, language: str | None = None) -> str:
        """The general solution in letters, every line compared with the compiled robot; empty where there is none."""
        return "" if self.derivation is None else to_text(self.derivation(), language)

    def check(self, answer: Any) -> Assessment:
        """Judge an answer: right in every equivalent form, else by which mistake wrong.

        Args:
            answer: by name of the quantity, or of the only (first) one alone: numbers or a text such as `30°`.

        Raises:
            InputError: a name that is not asked, or a text that cannot be read.
        """
        return assess(self.asked, answer)

    def explain(self, language: str | None = None) -> str:
        """Title, text and what is asked, in `en`, `ar` or the current language."""
        heading = say(f"{AREA}.heading", language=language, number=self.number, title=self.words("title", language))
        parts = [f"{part.name}: {part.label(language)}" for part in self.asked]
        return "\n".join([heading, self.words("text", language), *parts])

    def to_dict(self) -> dict[str, Any]:
        """Number, seed, level, words and right answers as plain data."""
        head = {"number": self.number, "seed": self.seed, "level": self.level, "title": self.title}
        answers = {part.name: part.value for part in self.asked}
        return {
            **head,
            "text": self.words("text"),
            "hints": self.hints(),
            "solution": self.solution(),
            "answers": answers,
        }

    def __repr__(self) -> str:
        return self.explain()

    def _repr_html_(self) -> str:
        return "".join(f'<div dir="{direction()}">{escape(line)}</div>' for line in self.explain().split("\n"))

    def _number_lines(self, part: str, language: str | None) -> list[str]:
        texts = (self.words(f"{part}{k}", language) for k in range(1, 9))
        return [text for text in texts if text]


def _fill(number: str, part: str, facts: Mapping[str, Any], hidden: str, language: str | None) -> str:
    """A sentence of a family, within that of the form of its question if this has one."""
    family, _, form = number.partition(": ")
    known = facts if part.startswith("step") or not hidden else {**facts, hidden: "X"}
    code = language or current_language()
    words = say(f"{AREA}.{key}", language=code, **known) if (key := f"{family}.{part}") in keys(code, AREA) else ""
    key = f"{form}_{part}"
    return say(f"{AREA}.{key}", language=code, **facts, words=words) if key in keys(code, AREA) else words


def title_of(number: str, language: str | None = None) -> str:
    """The title of an exercise that need not be drawn for it."""
    return _fill(number, "title", {}, "", language)


def value_text(part: Asked, language: str | None = None) -> str:
    """The right answer as a student would write it."""
    if part.is_choice:
        return say(f"{AREA}.{'yes' if part.forms[0][0] else 'no'}", language=language)
    return matrix_text(part.value)


def exercises(section: str = "") -> list[str]:
    """Numbers of all exercises, or of those of a section and its parts: families, then the questions made of them.

    Args:
        section: such as "4" or "4.2".
    """
    inside = [family for family in families() if not section or _is_of(family.number, str(section))]
    return [family.number for family in inside] + [f"{one.number}: {form}" for one in inside for form in one.forms]


def _is_of(number: str, section: str) -> bool:
    at = number.partition(" ")[0]
    return section in (number, at) or at.startswith(section + ".")


def exercise(number: str, /, *, seed: int = 0, level: int = 1) -> Exercise:
    """An exercise of the book with random numbers.

    Args:
        number: such as "4.3.2 frames" or "4.3.2 frames: mistake", or a section: the seed then chooses one of its own.
        seed: of the numbers; the same seed gives the same exercise.
        level: 1 (round numbers) to 3.

    Raises:
        InputError: no such exercise or section, or no such level.
    """
    if level not in LEVELS:
        raise InputError("book_exercises.level", level=level)
    number, seed = str(number), whole("seed", seed)
    inside = [] if " " in number else exercises(number)
    name = inside[seed % len(inside)] if inside else number
    family, form = family_of(name)
    generator = np.random.default_rng([seed, level, crc32(name.encode())])
    tasks: Iterable[Task | None] = (family.draw(form, Draw(generator, level)) for _ in range(_ATTEMPTS))
    task = next(task for task in tasks if task is not None and task.is_telling)
    return Exercise(name, seed, level, tuple(task.asked), task.facts, task.derivation, task.hidden)
