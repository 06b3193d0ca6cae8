"""Families of exercises: what a family draws and asks, and the questions that are made of each family.

A family is one function of a `Draw`: it draws the givens, computes the answer with the package, and says which mistakes
lead to which wrong answers. Its words stand in the catalogue under its number: title, text, hints, steps.

The forward question of a family gives four more: which given has a result (`inverse`), how the result changes with a
given (`scaling`), which of several results is right (`choose`), and by which mistake one is wrong (`mistake`). A family
is a function of its draws, so it is computed again with one of them changed.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, partial
from math import isfinite
from typing import Any, NamedTuple, TypeVar, cast

import numpy as np

from mafsil.arrays import Floats
from mafsil.book.entry import Index, matrix_text
from mafsil.book.judging import NEAR, Asked, ask
from mafsil.derivation import Derivation
from mafsil.messages import clauses, say
from mafsil.messages.catalogue import template

AREA = "book_exercises"
FORMS = ("inverse", "scaling", "choose", "mistake")
"""Questions that are made of a family, by the ending of the number: `3.1 slip: choose`."""
_OF_GIVENS = ("inverse", "scaling")
_SAMPLES, _SECANTS, _OPTIONS = 13, 6, 4
"""Values of a given at which the result has to be monotonic; steps to where a mistake leads to it; options."""
LEAST_ELASTICITY = 0.1
"""Least relative change of a result by that of a given, so that three digits of the one fix the other."""
LEAST_CHANGE = 0.03
"""Least relative change of a given or a result that a question is about, six times what an answer may be wrong by."""
_UNIT = re.compile(r"\s?(°|kg m²|N m s/rad|rad/s²|rad/s|N s/m|m/s²|m/s|N/m|N m|kg|mm|ms|m|N|s)(?![\w/²])")
T = TypeVar("T")


class Given(NamedTuple):
    """A single number that was drawn: between which it lies, and itself."""

    low: float
    high: float
    value: float


class Draw:
    """Random givens of an exercise; what `level` asks for more, it makes larger or less round.

    Args:
        generator: of random numbers.
        level: 1, 2 or 3.
        changed: numbers that replace drawn ones, by their place in `givens`.
    """

    def __init__(self, generator: np.random.Generator, level: int, changed: Mapping[int, float] | None = None) -> None:
        self._generator, self.level, self._changed = generator, level, changed or {}
        self._before = generator.bit_generator.state
        self.givens: list[Given] = []

    def again(self, place: int, value: float) -> Draw:
        """The same draws, that of a place replaced."""
        source: Any = np.random.PCG64(0)
        source.state = self._before
        return Draw(np.random.Generator(source), self.level, {place: value})

    def whole(self, low: int, high: int) -> int:
        """A whole number from low to high."""
        return int(self._generator.integers(low, high + 1))

    def number(self, low: float, high: float, step: float = 0.1) -> float:
        """A number of the grid of that step, not zero."""
        value = 0
        while value == 0:
            value = self.whole(round(low / step), round(high / step))
        return self._give(low, high, round(value * step, 6))

    def numbers(self, count: int, low: float, high: float, step: float = 0.1) -> Floats:
        """Several numbers."""
        return np.array([self.number(low, high, step) for _ in range(count)])

    def degrees(self, low: int = 20, high: int = 150) -> int:
        """An angle: of level 1 a multiple of 15 degrees, of level 2 of 5; of level 3 any, and negative too."""
        step = (15, 5, 1)[self.level - 1]
        value = step * self.whole(-(-low // step), high // step)
        if self.level == 3 and self.whole(0, 1):
            return self._give(-high, -low, -value)
        return self._give(low, high, value)

    def choice(self, options: Sequence[T]) -> T:
        """One of several things."""
        return options[self.whole(0, len(options) - 1)]

    def permutation(self, count: int) -> list[int]:
        """The whole numbers below a count in random order."""
        return [int(k) for k in self._generator.permutation(count)]

    def _give(self, low: float, high: float, value: T) -> T:
        self.givens.append(Given(low, high, float(cast("Any", value))))
        return cast("T", self._changed.get(len(self.givens) - 1, value))


@dataclass(frozen=True, slots=True, eq=False)
class Task:
    """What a family returns.

    Attributes:
        facts: givens and intermediate numbers, which fill the words.
        asked: what is to be found.
        derivation: writes the general solution, if the package derives it.
        hidden: name of the given that is sought or changed, which the text calls X.
    """

    facts: Mapping[str, Any]
    asked: Sequence[Asked]
    derivation: Callable[[], Derivation] | None = None
    hidden: str = ""

    @property
    def is_telling(self) -> bool:
        """Whether all mistakes lead to answers apart from the right ones."""
        return all(part.is_telling for part in self.asked)


Compute = Callable[[Draw], "Task | None"]
"""Draws an exercise; None where the numbers do not fit and others are to be drawn."""


@dataclass(frozen=True, slots=True)
class Family:
    """A family of exercises.

    Attributes:
        number: section of the source and name.
        compute: draws its forward question.
        unknown: givens of its text that follow from a result.
    """

    number: str
    compute: Compute
    unknown: tuple[str, ...] = field(default=())

    @property
    def forms(self) -> tuple[str, ...]:
        """Questions that are made of it."""
        return FORMS if self.unknown else FORMS[len(_OF_GIVENS) :]

    def draw(self, form: str, draw: Draw) -> Task | None:
        """An exercise of a form, forward if empty; None where other numbers are to be drawn."""
        task = self.compute(draw)
        if task is None or not task.is_telling or not form:
            return task
        if form in _OF_GIVENS:
            return self._of_given(form, draw, task)
        offered = [part for part in task.asked if not part.is_choice and len(_wrong_answers(part)) > 1]
        if not offered:
            return None
        part = draw.choice(offered)
        return _choose(draw, task, part) if form == "choose" else _find_mistake(draw, task, part)

    def _of_given(self, form: str, draw: Draw, task: Task) -> Task | None:
        """A question about a given that a result follows from."""
        name = draw.choice(self.unknown)
        places = [k for k, given in enumerate(draw.givens) if self._is_given(name, k, given, draw, task)]
        for k in range(len(task.asked)) if places else ():
            curve = Curve(cache(partial(self._part, draw, places[0], k)), task.asked[k], draw.givens[places[0]])
            if curve.is_invertible:
                text = template(f"{AREA}.{self.number}.text", "en")
                unit = match[1] if (match := _UNIT.match(text.partition(f"{{{name}}}")[2])) else ""
                question = (_invert if form == "inverse" else _scale)(draw, curve, unit)
                return question and Task({**task.facts, **question.facts}, question.asked, task.derivation, name)
        return None

    def _part(self, draw: Draw, place: int, k: int, value: float) -> Asked | None:
        """A quantity of the exercise that has another number at a place."""
        task = self.compute(draw.again(place, value))
        return None if task is None else task.asked[k]

    def _is_given(self, name: str, place: int, given: Given, draw: Draw, task: Task) -> bool:
        """Whether a fact is the number drawn at a place, and nothing else of the text changes with it."""
        if not np.array_equal(task.facts[name], given.value):
            return False
        other = given.value + (given.high - given.value if given.high > given.value else given.low - given.value) / 2
        again = self.compute(draw.again(place, other or given.high))  # no number that is drawn is zero
        text = template(f"{AREA}.{self.number}.text", "en")
        return again is not None and all(
            np.array_equal(fact, task.facts[key]) != (key == name)
            for key, fact in again.facts.items()
            if f"{{{key}}}" in text
        )


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """A result as a function of one given, with what each mistake makes of it.

    Attributes:
        ask_again: the quantity at another value of the given; None where there is no exercise.
        part: the quantity as it was drawn.
        given: the value drawn, and its range.
    """

    ask_again: Callable[[float], Asked | None]
    part: Asked
    given: Given

    def value(self, x: float, mistake: str = "") -> float:
        """The result, or what a mistake leads to; NaN where there is none."""
        part = self.ask_again(x)
        known = () if part is None else part.mistakes if mistake else [("", part.forms[0])]
        return next((form.item() for name, form in known if name == mistake and form.size == 1), float("nan"))

    @property
    def is_invertible(self) -> bool:
        """Whether one given alone has the result, and three digits of the one fix three of the other."""
        right = self.part.forms[0]
        if self.part.is_exact or self.part.unordered or right.size != 1 or not right.item():
            return False
        y = np.array([self.value(x) for x in self._grid()])
        steps = np.diff(y[np.isfinite(y)])
        least = LEAST_ELASTICITY * abs(right.item() / self.given.value) * (self.given.high - self.given.low) / _SAMPLES
        return len(steps) > _SAMPLES // 2 and bool((steps > least).all() or (steps < -least).all())

    def mistakes(self) -> list[str]:
        """Names of mistakes."""
        return list(dict.fromkeys(name for name, _ in self.part.mistakes))

    def argument(self, mistake: str) -> float | None:
        """Where a mistake leads to the right result, if it does so within the range."""
        target, grid = self.part.forms[0].item(), self._grid()
        y = [self.value(x, mistake) - target for x in grid]
        a = next((k for k in range(_SAMPLES - 1) if y[k] * y[k + 1] < 0), None)
        if a is None:
            return None
        (low, high), (y_low, y_high) = grid[a : a + 2], y[a : a + 2]
        x = value = float("nan")
        for _ in range(_SECANTS):
            x = low - y_low * (high - low) / (y_high - y_low)
            value = self.value(x, mistake) - target
            if not value or not isfinite(value):
                break
            low, y_low, high, y_high = (low, y_low, x, value) if value * y_low < 0 else (x, value, high, y_high)
        return x if abs(value) < NEAR / 10 * abs(target) else None

    def _grid(self) -> list[float]:
        low, high = self.given[:2]
        return [x or LEAST_CHANGE * (high - low) for x in np.linspace(low, high, _SAMPLES).tolist()]


class _Result:
    """What a quantity is called and how large it is, as a sentence in any language has it."""

    def __init__(self, part: Asked, form: Floats | None = None) -> None:
        self._part, self._form = part, part.forms[0] if form is None else form

    def spoken(self, language: str | None = None) -> str:
        """`normal force [N] = 12.3`."""
        value = matrix_text(_in_shape(self._part, self._form))
        return say(f"{AREA}.result", language=language, name=self._part.label(language), value=value)


class _Label:
    """What a quantity is called, as a sentence in any language has it."""

    def __init__(self, part: Asked) -> None:
        self._part = part

    def spoken(self, language: str | None = None) -> str:
        """`normal force [N]`."""
        return self._part.label(language)


class _Options:
    """Numbered results, or mistakes by name, as a sentence in any language has them."""

    def __init__(self, options: Sequence[Any]) -> None:
        self._options = options

    def spoken(self, language: str | None = None) -> str:
        """`1: ...; 2: ...`."""
        texts = [
            say(f"{AREA}.mistake_{option}", language=language) if isinstance(option, str) else matrix_text(option)
            for option in self._options
        ]
        listed = [say(f"{AREA}.option", language=language, k=k, text=text) for k, text in enumerate(texts, start=1)]
        return clauses(listed, language)


def _in_shape(part: Asked, form: Floats) -> Any:
    if form.size == 1:
        return form.item()
    width = part.value.size // part.shape[0]
    return form.reshape(part.shape if form.size == part.value.size else (-1, width))


def _invert(_: Draw, curve: Curve, unit: str) -> Task:
    """Which given has the result."""
    slips: dict[str, Any] = {name: x for name in curve.mistakes() if (x := curve.argument(name)) is not None}
    slips |= {"radians": np.radians(curve.given.value)} if unit == "°" else {}
    sought = ask("x", curve.given.value, unit, **slips)
    facts = {
        "known": _Result(curve.part),
        "x_low": curve.given.low,
        "x_high": curve.given.high,
        "x_value": curve.given.value,
    }
    return Task(facts, [sought])


def _scale(draw: Draw, curve: Curve, unit: str) -> Task | None:
    """By which factor the result grows with a given."""
    first, (low, high) = curve.given.value, curve.given[:2]
    second = round(float(draw.choice([low, high, low + (high - low) / 2])), 4)
    right, after = curve.part.forms[0].item(), curve.value(second)
    factor, ratio = after / right, second / first
    if not np.isfinite(factor) or min(abs(factor), abs(ratio), abs(factor - 1), abs(ratio - 1)) < LEAST_CHANGE:
        return None
    general = {"proportional": ratio, "inversely_proportional": 1 / ratio, "reciprocal": 1 / factor,
               "squared_ratio": ratio**2, "difference": after - right, "second_value": after}  # fmt: skip
    slips: dict[str, Any] = {}
    for name, x in general.items():
        if all(abs(x - other) > LEAST_CHANGE * abs(other) for other in (factor, *slips.values())):
            slips[name] = x
    return Task(
        {"x_first": f"{first:g} {unit}".rstrip(), "x_second": f"{second:g} {unit}".rstrip(), "factor": factor,
         "known": _Result(curve.part), "after": _Result(curve.part, np.array([after]))},
        [ask("factor", factor, **slips)],
    )  # fmt: skip


def _wrong_answers(part: Asked) -> dict[str, Floats]:
    """One wrong answer of each mistake, the likelier first."""
    return dict(reversed([(name, form) for name, form in part.mistakes if form.size == part.value.size]))


def _choose(draw: Draw, task: Task, part: Asked) -> Task:
    """Which of several results is right."""
    wrong = list(_wrong_answers(part).items())[-_OPTIONS + 1 :]
    options = [("", part.forms[0]), *wrong]
    options = [options[k] for k in draw.permutation(len(options))]
    names: dict[str, Any] = {name or "right": k for k, (name, _) in enumerate(options, start=1)}
    facts = {"label": _Label(part), "options": _Options([_in_shape(part, form) for _, form in options])}
    return Task(dict(task.facts) | facts, [ask("option", names.pop("right"), **names)], task.derivation)


def _find_mistake(draw: Draw, task: Task, part: Asked) -> Task:
    """Which mistake led to a wrong result, and what is right."""
    wrong = list(_wrong_answers(part).items())[-_OPTIONS:]
    causes = [wrong[k] for k in draw.permutation(len(wrong))]
    cause = draw.whole(1, len(causes))
    facts = {"wrong": _Result(part, causes[cause - 1][1]), "causes": _Options([name for name, _ in causes])}
    return Task(dict(task.facts) | facts, [ask("cause", cause), part], task.derivation)


_INDEX: Index[Family] = Index(
    tuple(f"exercises_of_{topic}" for topic in ("mechanisms", "motions", "robots", "arms", "control")),
    f"{AREA}.unknown",
)


def asks(number: str, unknown: str = "") -> Callable[[Compute], Compute]:
    """Declare a family.

    Args:
        number: the section of the source and a name: "4.3 frames".
        unknown: names of givens of its text that follow from a result, each drawn as a single number.
    """

    def declare(compute: Compute) -> Compute:
        _INDEX.declare(number, Family(number, compute, tuple(unknown.split())))
        return compute

    return declare


def families() -> list[Family]:
    """All families, in the order of the source."""
    return [_INDEX[number] for number in _INDEX.numbers()]


def family_of(number: str) -> tuple[Family, str]:
    """A family and the form of its question, empty for the forward one.

    Raises:
        InputError: there is none of that number.
    """
    name, _, form = number.partition(": ")
    family = _INDEX[name if form in FORMS else number]
    if form and form not in family.forms:
        return _INDEX[number], ""
    return family, form
