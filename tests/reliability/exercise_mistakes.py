"""Exercises of the book at scale: right answers in every equivalent form, and planted mistakes.

python tests/reliability/exercise_mistakes.py 1000       right answers and planted mistakes for each family
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
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


def false_alarms(count: int, number: str) -> list[str]:
    """Right answers that are not accepted."""
    wrong: list[str] = []
    for exercise, rng in exercises(count, number):
        for part in exercise.asked:
            form = part.forms[int(rng.integers(len(part.forms)))]
            text = (
                rng.choice(["yes", "نعم"] if form[0] else ["no", "لا"])
                if part.is_choice
                else equivalent_text(part, form, rng)
            )
            verdict = next(v for v in exercise.check({part.name: text}) if v.part == part.name)
            if verdict.mistake:
                wrong.append(f"{exercise.number} seed {exercise.seed}: {part.name} = {text}: {verdict.mistake}")
    return wrong


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


def unnamed(count: int, number: str) -> tuple[int, list[str]]:
    """How many mistakes were planted, and those that got another name."""
    total, missed = 0, list[str]()
    for exercise, rng in exercises(count, number):
        part = exercise.asked[int(rng.integers(len(exercise.asked)))]
        chosen = planted(part, rng)
        if chosen is None:
            continue
        total += 1
        name, form = chosen
        moved = form if name == "degrees" else _with_turns(part, form, rng)
        verdict = next(v for v in exercise.check({part.name: _rounded(moved)}) if v.part == part.name)
        if verdict.mistake != name:
            missed.append(
                f"{exercise.number} seed {exercise.seed}: {part.name}: {name} was called {verdict.mistake or 'right'}"
            )
    return total, missed


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
    alarms, sown, unnamed_total = 0, 0, 0
    for family in mf.book.exercises():
        false = false_alarms(size, family)
        total, missed = unnamed(size, family)
        alarms, sown, unnamed_total = alarms + len(false), sown + total, unnamed_total + len(missed)
        print(f"{family:22} false alarms {len(false)} of {size}, mistakes named {total - len(missed)} of {total}")
        print(*[f"    {line}" for line in (false + missed)[:3]], sep="\n")
    print(f"together: {alarms} false alarms, {sown - unnamed_total} of {sown} mistakes named")
