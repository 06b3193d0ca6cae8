"""Exercises of the book at scale: right answers in every equivalent form, and planted mistakes.

python -m tests.reliability.exercise_mistakes 1000 [SECTION]     right answers and planted mistakes for each family
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from math import pi

import numpy as np

import mafsil as mf
from mafsil.arrays import Floats
from mafsil.book.exercise import Exercise
from mafsil.book.judging import Asked

ARABIC = str.maketrans("0123456789.", "٠١٢٣٤٥٦٧٨٩٫")


def exercises(count: int, number: str) -> Iterator[tuple[Exercise, np.random.Generator]]:
    """Exercises of a family at all levels, each with a generator for what is done with it."""
    for seed in range(count):
        yield mf.book.exercise(number, seed=seed, level=1 + seed % 3), np.random.default_rng([seed, 41])


def equivalent_text(part: Asked, form: Floats, rng: np.random.Generator) -> str:
    """A form as some student would write it: other turns, other order, other units, four digits, other numerals."""
    rows = form.reshape(part.shape[0], -1) if part.unordered and form.size == part.value.size else form.reshape(1, -1)
    if part.unordered:
        rows = rng.permutation(rows)
    turns = part.turns[: rows.shape[1]] > 0 if part.unordered else part.turns > 0
    unit = {"rad": "deg", "m": "mm"}.get(part.unit, "") if rng.integers(2) else ""
    factor = {"deg": 180 / pi, "mm": 1000.0}.get(unit, 1.0)
    written: list[str] = []
    for row in rows:
        moved = row + np.where(turns, 2 * pi * rng.integers(-1, 2, row.size), 0.0) if turns.size == row.size else row
        written.append(", ".join(f"{x * factor:.5g}{' ' * int(rng.integers(2))}{unit}" for x in moved))
    text = "; ".join(written)
    return text.translate(ARABIC) if rng.integers(2) and "e" not in text else text


def planted(part: Asked, rng: np.random.Generator) -> tuple[str, Floats] | None:
    """A mistake and the answer that it leads to: one that the family declares, or one of place."""
    choices = list(part.mistakes)
    if part.unordered:
        choices += [("missed", part.value[1:].ravel())]
    elif part.value.ndim and part.value.size > 2:
        flipped = part.forms[0].copy()
        k = int(np.argmax(np.abs(flipped)))
        flipped[k] = -flipped[k]
        known = (*part.forms, *(form for _, form in part.mistakes))
        choices += [] if any(part.matches(flipped, form) for form in known) else [("sign", flipped)]
    return choices[int(rng.integers(len(choices)))] if choices else None


@dataclass
class Tally:
    """What came of the exercises of a family.

    Attributes:
        alarms: right answers that were not accepted.
        planted: number of mistakes that were given as answers.
        missed: those that got another name.
    """

    alarms: list[str] = field(default_factory=list[str])
    planted: int = 0
    missed: list[str] = field(default_factory=list[str])


def tally(count: int, number: str) -> Tally:
    """Right answers to every quantity, and one planted mistake, for each of many exercises of a family."""
    result = Tally()
    for exercise, rng in exercises(count, number):
        heading = f"{exercise.number} seed {exercise.seed}"
        for part in exercise.asked:
            text = right_text(part, rng)
            if mistake := _verdict(exercise, part, text):
                result.alarms.append(f"{heading}: {part.name} = {text}: {mistake}")
        part = exercise.asked[int(rng.integers(len(exercise.asked)))]
        if chosen := planted(part, rng):
            name, form = chosen
            given = _rounded(form if name == "degrees" else _with_turns(part, form, rng))
            verdict = _verdict(exercise, part, given)
            result.planted += 1
            if verdict != name:
                result.missed.append(f"{heading}: {part.name}: {name} was called {verdict or 'right'}")
    return result


def right_text(part: Asked, rng: np.random.Generator) -> str:
    """A right answer as some student would write it."""
    form = part.forms[int(rng.integers(len(part.forms)))]
    if part.is_choice:
        return str(rng.choice(["yes", "نعم"] if form[0] else ["no", "لا"]))
    return equivalent_text(part, form, rng)


def _verdict(exercise: Exercise, part: Asked, given: object) -> str:
    return next(v for v in exercise.check({part.name: given}) if v.part == part.name).mistake


def _with_turns(part: Asked, form: Floats, rng: np.random.Generator) -> Floats:
    """Other turns, and solutions in another order."""
    if form.size == part.turns.size:
        form = form + np.where(part.turns > 0, 2 * pi * rng.integers(-1, 2, form.size), 0.0)
    if part.unordered and form.size:
        form = rng.permutation(form.reshape(-1, part.value.size // part.shape[0])).ravel()
    return form


def _rounded(form: Floats) -> Floats:
    return np.array([float(f"{x:.5g}") for x in form])


if __name__ == "__main__":
    size = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    section = sys.argv[2] if len(sys.argv) > 2 else ""
    tallies = {number: tally(size, number) for number in mf.book.exercises(section)}
    for number, one in tallies.items():
        named = f"mistakes named {one.planted - len(one.missed)} of {one.planted}"
        print(f"{number:34} false alarms {len(one.alarms)} of {size}, {named}")
        print(*[f"    {line}" for line in (one.alarms + one.missed)[:3]], sep="\n")
    alarms, sown = sum(len(one.alarms) for one in tallies.values()), sum(one.planted for one in tallies.values())
    missed = sum(len(one.missed) for one in tallies.values())
    print(f"together: {len(tallies)} families, {alarms} false alarms, {sown - missed} of {sown} mistakes named")
