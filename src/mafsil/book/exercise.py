"""Exercises of the book by section: random numbers, hints, full solution, and a checker that names the mistake.

A family is one function of a `Draw`: it draws the givens, computes the answer with the package, and says which mistakes
lead to which wrong answers. Its words stand in the catalogue under its number: title, text, hints, steps.

Numbers are drawn again until the mistakes of a family can be told from the right answer.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from typing import Any, TypeVar
from zlib import crc32

import numpy as np

from mafsil.arrays import Floats, whole
from mafsil.book.entry import Index, shown
from mafsil.book.judging import Asked, Assessment, assess
from mafsil.derivation import Derivation, to_text
from mafsil.errors import InputError
from mafsil.messages import clauses, direction, keys, say

AREA = "book_exercises"
LEVELS = (1, 2, 3)
_ATTEMPTS = 400
T = TypeVar("T")


class Draw:
    """Random givens of an exercise; what `level` asks for more, it makes larger or less round.

    Args:
        generator: of random numbers.
        level: 1, 2 or 3.
    """

    def __init__(self, generator: np.random.Generator, level: int) -> None:
        self._generator, self.level = generator, level

    def whole(self, low: int, high: int) -> int:
        """A whole number from low to high."""
        return int(self._generator.integers(low, high + 1))

    def number(self, low: float, high: float, step: float = 0.1) -> float:
        """A number of the grid of that step, not zero."""
        value = 0
        while value == 0:
            value = self.whole(round(low / step), round(high / step))
        return round(value * step, 6)

    def numbers(self, count: int, low: float, high: float, step: float = 0.1) -> Floats:
        """Several numbers."""
        return np.array([self.number(low, high, step) for _ in range(count)])

    def degrees(self, low: int = 20, high: int = 150) -> int:
        """An angle: of level 1 a multiple of 15 degrees, of level 2 of 5; of level 3 any, and negative too."""
        step = (15, 5, 1)[self.level - 1]
        value = step * self.whole(-(-low // step), high // step)
        return -value if self.level == 3 and self.whole(0, 1) else value

    def choice(self, options: Sequence[T]) -> T:
        """One of several things."""
        return options[self.whole(0, len(options) - 1)]


@dataclass(frozen=True, slots=True, eq=False)
class Task:
    """What a family returns.

    Attributes:
        facts: givens and intermediate numbers, which fill the words.
        asked: what is to be found.
        derivation: writes the general solution, if the package derives it.
    """

    facts: Mapping[str, Any]
    asked: Sequence[Asked]
    derivation: Callable[[], Derivation] | None = None


Family = Callable[[Draw], "Task | None"]
"""Draws an exercise; None where the numbers do not fit and others are to be drawn."""
_INDEX: Index[Family] = Index(
    ("exercises_of_mechanisms", "exercises_of_motions", "exercises_of_robots", "exercises_of_control"),
    "book_exercises.unknown",
)


def asks(number: str) -> Callable[[Family], Family]:
    """Declare a family.

    Args:
        number: the section of the source and a name: "4.3 frames".
    """

    def declare(family: Family) -> Family:
        _INDEX.declare(number, family)
        return family

    return declare


@dataclass(frozen=True, eq=False, repr=False)
class Exercise:
    """An exercise of the book with its own numbers.

    Attributes:
        number: section of the source and name of the family.
        seed, level: from which it was drawn.
        asked: what is to be found.
        facts: givens and intermediate numbers by name.
        derivation: writes the general solution, or None.
    """

    number: str
    seed: int
    level: int
    asked: tuple[Asked, ...]
    facts: Mapping[str, Any]
    derivation: Callable[[], Derivation] | None = field(default=None)

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
        key = f"{self.number}.{part}"
        if key not in keys(language or "en", AREA):
            return ""
        facts = {name: matrix_text(fact) for name, fact in self.facts.items()}
        return say(f"{AREA}.{key}", language=language, **facts)

    def hints(self, language: str | None = None) -> list[str]:
        """Hints, each saying more than the one before; the last is the first step of the solution."""
        return [*self._number_lines("hint", language), *self._number_lines("step", language)[:1]]

    def solution(self, language: str | None = None) -> list[str]:
        """The steps of the full solution, and the results."""
        results = [
            say(f"{AREA}.result", language=language, name=part.label(language), value=value_text(part, language))
            for part in self.asked
        ]
        return [*self._number_lines("step", language), clauses(results, language)]

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


def value_text(part: Asked, language: str | None = None) -> str:
    """The right answer as a student would write it."""
    if part.is_choice:
        return say(f"{AREA}.{'yes' if part.forms[0][0] else 'no'}", language=language)
    return matrix_text(part.value)


def matrix_text(value: Any) -> Any:
    """Matrices as `[1 0; 0 1]`, vectors as `(1, 0)`, numbers with four digits."""
    array = np.asarray(value)
    if array.ndim == 2:
        return "[" + "; ".join(" ".join(shown(item) for item in row) for row in array) + "]"
    return value if array.dtype.kind in "biu" and not array.ndim else shown(value)


def exercises(section: str = "") -> list[str]:
    """Numbers of all families, or of those of a section and its parts.

    Args:
        section: such as "4" or "4.2".
    """
    return [number for number in _INDEX.numbers() if not section or _is_of(number, str(section))]


def _is_of(number: str, section: str) -> bool:
    at = number.partition(" ")[0]
    return number == section or at == section or at.startswith(section + ".")


def exercise(number: str, /, *, seed: int = 0, level: int = 1) -> Exercise:
    """An exercise of the book with random numbers.

    Args:
        number: a family such as "4.3 frames", or a section, of whose families the seed chooses one.
        seed: of the numbers; the same seed gives the same exercise.
        level: 1 (round numbers) to 3.

    Raises:
        InputError: no such family or section, or no such level.
    """
    if level not in LEVELS:
        raise InputError("book_exercises.level", level=level)
    families = exercises(str(number))
    seed = whole("seed", seed)
    name = families[seed % len(families)] if families else str(number)
    family = _INDEX[name]
    draw = Draw(np.random.default_rng([seed, level, crc32(name.encode())]), level)
    tasks: Iterable[Task | None] = (family(draw) for _ in range(_ATTEMPTS))
    task = next(task for task in tasks if task is not None and all(part.is_telling for part in task.asked))
    return Exercise(name, seed, level, tuple(task.asked), task.facts, task.derivation)
