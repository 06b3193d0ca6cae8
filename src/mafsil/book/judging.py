"""What an exercise asks, and the judgement of a student's answer: right in every equivalent form, else which mistake.

All forms of a right answer and of a mistake are numbers, so that the page of a sheet judges by the same table as here.

Forms are arrays of numbers compared entry by entry, angles modulo a turn, solutions in any order.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import isfinite, pi
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, real_array, require_finite
from mafsil.errors import InputError
from mafsil.messages import LANGUAGES, say
from mafsil.typed_number import NUMBER, UNITS, WESTERN, read_number, western

NEAR = 5e-3
"""Relative to the largest entry; of angles [rad]: three digits are enough."""
FACTORS = {
    kind: {unit: UNITS[unit] for unit in units}
    for kind, units in (("rad", ("rad", "deg", "°")), ("m", ("m", "cm", "mm")))
}
"""Units that an answer may have, and their factor, by the unit that is asked."""
_LOOSE_UNIT = re.compile(r"(?<=[\di])\s+(?=(?:deg|rad|°|mm|cm|m)\b|°)|\s*([*/])\s*")
_BETWEEN = re.compile(r"[\s,;()\[\]]+")


@dataclass(frozen=True, slots=True, eq=False)
class Asked:
    """One quantity that an exercise asks for.

    Attributes:
        name: of its words in the catalogue.
        shape: of the array; solutions are rows.
        forms: flat arrays that are right.
        mistakes: names of mistakes with the flat arrays they lead to, the likelier first.
        is_exact: whether entries are whole numbers; otherwise three digits are enough.
        turns: which entries are angles.
        unit: of entries that have one.
        unordered: whether the rows may stand in any order.
        is_choice: whether it is answered with yes (1) or no (0).
        is_telling: whether the declared mistakes lead to answers apart from the right one and from each other.
    """

    name: str
    shape: tuple[int, ...]
    forms: tuple[Floats, ...]
    mistakes: tuple[tuple[str, Floats], ...]
    is_exact: bool
    turns: Floats
    unit: str
    unordered: bool
    is_choice: bool
    is_telling: bool = True

    @property
    def value(self) -> Floats:
        """The first right form, in its shape."""
        return self.forms[0].reshape(self.shape)

    def label(self, language: str | None = None) -> str:
        """What is asked, with its unit."""
        text = say(f"book_exercises.ask_{self.name}", language=language)
        return f"{text} [{self.unit}]" if self.unit else text

    def page_data(self) -> dict[str, Any]:
        """What a page needs to judge answers, numbers with six digits."""
        flat = [[float(f"{x:.6g}") for x in form] for form in self.forms]
        mistakes = [[name, [float(f"{x:.6g}") for x in form]] for name, form in self.mistakes]
        rows = self.shape[0] if self.unordered else 0
        kind = {"exact": self.is_exact, "choice": self.is_choice, "rows": rows, "unit": self.unit}
        return {
            "name": self.name,
            **kind,
            "turns": self.turns.astype(int).tolist(),
            "forms": flat,
            "mistakes": mistakes,
        }

    def is_like(self, given: Floats, form: Floats) -> NDArray[np.bool_]:
        """Which entries of an answer are those of a form."""
        return np.array(list(self._likeness(given, form)), dtype=np.bool_)

    def _likeness(self, given: Floats, form: Floats) -> Iterator[bool]:
        """Entry by entry, so that a comparison ends at the first that differs."""
        turns = self.turns.tolist()
        right = form.tolist()
        length = max((abs(x) for x, turn in zip(right, turns, strict=True) if not turn), default=0.0)
        for x, y, turn in zip(given.tolist(), right, turns, strict=True):
            apart = (x - y + pi) % (2 * pi) - pi if turn else x - y
            near = NEAR * (max(abs(y) / pi, 1.0) if turn else max(length, 1e-6))
            yield abs(apart) <= (1e-9 if self.is_exact else near)

    def matches(self, given: Floats, form: Floats) -> bool:
        """Whether an answer is a form, its rows in any order where the order says nothing."""
        if given.size != form.size:
            return False
        return len(self.rows_of(given, form)) == self.shape[0] if self.unordered else all(self._likeness(given, form))

    def rows_of(self, given: Floats, form: Floats) -> list[int]:
        """Rows of a form that an answer has, each once."""
        width = self.turns.size // self.shape[0]
        rows = list(given.reshape(-1, width)) if given.size % width == 0 else []
        whole, taken = form.reshape(-1, width), list[int]()
        one = replace(self, shape=(width,), turns=self.turns[:width])
        for row in rows:
            new = next((k for k, right in enumerate(whole) if k not in taken and all(one._likeness(row, right))), None)
            taken += [] if new is None else [new]
        return taken


def ask(
    name: str,
    value: Any,
    unit: str = "",
    *,
    twin: Callable[[Floats], Any] | None = None,
    turns: Sequence[bool] | bool = False,
    unordered: bool = False,
    **mistakes: Any,
) -> Asked:
    """A quantity to be found; whole numbers and truths are compared as they are.

    Args:
        name: of its words.
        value: the right one; rows of solutions if unordered.
        unit: `rad` or `m` where all entries have it, else a text.
        twin: the other form of an answer that is as right: of a quaternion the negative one.
        turns: which entries are angles (one flag for all, or one for each of a row).
        unordered: the rows are solutions in any order.
        mistakes: what each mistake leads to, the likelier first.
    """
    array = np.asarray(value, dtype=float)
    flags = np.broadcast_to(np.asarray(turns if np.ndim(turns) else (turns or unit == "rad"), float), array.shape)
    exact = np.asarray(value).dtype.kind in "biu"
    forms = tuple(_with_twin(array, twin))
    is_choice = isinstance(value, (bool, np.bool_))
    part = Asked(name, array.shape, forms, (), exact, flags.ravel(), unit, unordered, is_choice)
    usual = () if exact else _usual(array, unit, flags, unordered=unordered)
    kept: list[tuple[str, Floats]] = []
    for mistake, wrong in (*mistakes.items(), *usual):
        for form in _with_twin(np.asarray(wrong, float), twin):
            if form.size and not any(part.matches(form, known) for known in (*forms, *(known for _, known in kept))):
                kept.append((mistake, form))
    expected = {mistake for mistake, wrong in mistakes.items() if np.size(wrong)}
    telling = expected <= {mistake for mistake, _ in kept}
    return replace(part, mistakes=tuple(kept), is_telling=telling)


def _with_twin(value: Floats, twin: Callable[[Floats], Any] | None) -> list[Floats]:
    both = [value] if twin is None else [value, np.asarray(twin(value), float)]
    return [form.ravel() for form in both]


def _usual(value: Floats, unit: str, turns: Floats, *, unordered: bool) -> Iterator[tuple[str, Floats]]:
    """Mistakes that any quantity of a kind invites."""
    if turns.any():
        yield "degrees", np.where(turns > 0, np.degrees(value), value)
    if value.ndim == 2 and value.shape[0] == value.shape[1] and not unordered:
        yield "transposed", value.T
    if value.shape == (6,):
        yield "parts_swapped", np.roll(value, 3)
    if unit == "m":
        yield "millimetres", 1000 * value
        yield "centimetres", 100 * value
    yield "negated", -value


class AssessmentStatus(Status):
    """Whether the answers to an exercise are right."""

    RIGHT = ("book_exercises.right", True)
    WRONG = ("book_exercises.wrong", False)


@dataclass(frozen=True, slots=True)
class PartVerdict:
    """What is said about one answer.

    Attributes:
        part: name of the quantity.
        mistake: name of the mistake; `""` where it is right.
        place: from 1: the entries concerned, or the number of solutions that are missing.
    """

    part: str
    mistake: str
    place: tuple[int, ...] = ()

    def message(self, language: str | None = None) -> str:
        """The quantity and the mistake as a sentence."""
        name = say(f"book_exercises.ask_{self.part}", language=language)
        place = ", ".join(map(str, self.place))
        mistake = say(f"book_exercises.mistake_{self.mistake or 'none'}", language=language, place=place)
        return say("book_exercises.verdict", language=language, name=name, mistake=mistake)


@dataclass(frozen=True, slots=True, repr=False)
class Assessment(Answer, entries="verdicts", data="verdicts points greatest"):
    """The judgement of answers: true if all are right, iterable over the verdicts, one for each quantity.

    Attributes:
        verdicts: in the order asked.
    """

    verdicts: tuple[PartVerdict, ...]

    @property
    def status(self) -> AssessmentStatus:
        """RIGHT if every quantity is."""
        return AssessmentStatus.WRONG if any(verdict.mistake for verdict in self.verdicts) else AssessmentStatus.RIGHT

    @property
    def points(self) -> int:
        """Number of right quantities."""
        return sum(not verdict.mistake for verdict in self.verdicts)

    @property
    def greatest(self) -> int:
        """Number of quantities."""
        return len(self.verdicts)

    def explain(self, language: str | None = None) -> str:
        """The points, then a line for each quantity."""
        head = self.status.sentence(language, points=self.points, greatest=self.greatest)
        return "\n".join([head, *(verdict.message(language) for verdict in self.verdicts)])


def judge(part: Asked, given: Floats) -> PartVerdict:
    """Right, or by which mistake wrong; where no mistake explains it, which entries differ.

    Args:
        part: what was asked.
        given: the flat answer.
    """
    if any(part.matches(given, form) for form in part.forms):
        return PartVerdict(part.name, "")
    for mistake, form in part.mistakes:
        if part.matches(given, form):
            return PartVerdict(part.name, mistake)
    if part.unordered:
        known, width = part.rows_of(given, part.forms[0]), part.forms[0].size // part.shape[0]
        if given.size and width * len(known) == given.size:
            return PartVerdict(part.name, "missed", (part.shape[0] - len(known),))
        return PartVerdict(part.name, "solution" if known else "other")
    if given.size != part.forms[0].size:
        return PartVerdict(part.name, "count", (part.forms[0].size,))
    agreeing = [part.is_like(given, form) for form in part.forms]
    best, right = max(zip(part.forms, agreeing, strict=True), key=lambda pair: int(pair[1].sum()))
    wrong = np.flatnonzero(~right)
    if not right.any() or len(wrong) > max(1, right.size // 2):
        return PartVerdict(part.name, "other")
    mistake = "sign" if part.is_like(-given, best)[wrong].all() else "entries"
    return PartVerdict(part.name, mistake, tuple(int(k) + 1 for k in wrong))


def numbers_of(part: Asked, given: Any) -> Floats:
    """The flat numbers of an answer: an array, a number, a truth, or a text such as `30°`, `1, 2; 3, pi/4`, `yes`.

    Args:
        part: what was asked.
        given: the answer.

    Raises:
        InputError: a text that cannot be read.
    """
    if not isinstance(given, str):
        listed = cast("Sequence[Any]", given) if isinstance(given, (list, tuple)) else [given]
        rows = () if given is None else listed
        truth = part.is_choice and isinstance(given, (bool, np.bool_))
        flat = np.concatenate([np.ravel(float(row) if truth else row) for row in rows]) if rows else np.zeros(0)
        return require_finite(part.name, real_array(part.name, flat))
    text = western(given).strip().lower()
    if part.unit not in FACTORS:
        text = text.replace(part.unit.lower(), " ") if part.unit else text
    if part.is_choice and text in words_of_choice():
        return np.array([words_of_choice()[text]])
    words = _BETWEEN.split(_LOOSE_UNIT.sub(r"\1", text))
    return np.array([_number(part, word) for word in words if word])


def words_of_choice() -> Mapping[str, float]:
    """Words for yes and no in all languages."""
    values = {"yes": 1.0, "no": 0.0}
    return {say(f"book_exercises.{w}", language=code): v for code in LANGUAGES for w, v in values.items()}


def page_rules() -> dict[str, Any]:
    """What a page reads and compares answers by: the grammar of numbers and the tolerance that hold here."""
    patterns = {"number": NUMBER, "loose": _LOOSE_UNIT.pattern, "between": _BETWEEN.pattern}
    return {"near": NEAR, "factors": FACTORS, "choices": dict(words_of_choice()), "western": WESTERN, **patterns}


def _number(part: Asked, word: str) -> float:
    typed, factors = read_number(word), FACTORS.get(part.unit, dict[str, float]())
    if part.turns.any():
        factors = factors | FACTORS["rad"]
    if typed is None or (typed.unit and typed.unit not in factors) or not isfinite(typed.value):
        raise InputError("book_exercises.unread", part=say(f"book_exercises.ask_{part.name}"), text=word[:80])
    return typed.value * factors.get(typed.unit, 1.0)


def assess(parts: Sequence[Asked], given: Any) -> Assessment:
    """Judge the answers to all quantities of an exercise.

    Args:
        parts: what was asked.
        given: answers by name; of one quantity it alone.

    Raises:
        InputError: a name that was not asked, or a text that cannot be read.
    """
    named = cast("Mapping[str, Any]", given if isinstance(given, Mapping) else {parts[0].name: given})
    known = {part.name for part in parts}
    if any(name not in known for name in named):
        name = next(name for name in named if name not in known)
        raise InputError("book_exercises.unknown_part", name=name, known=", ".join(part.name for part in parts))
    answers = [(part, numbers_of(part, named.get(part.name, ()))) for part in parts]
    return Assessment(
        tuple(judge(part, answer) if answer.size else PartVerdict(part.name, "empty") for part, answer in answers)
    )
