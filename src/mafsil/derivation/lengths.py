"""The letters of a typed matrix: which lengths of the arm they are, and other lengths to try the formulas at."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice, product
from typing import Any, cast

import numpy as np

from mafsil.arrays import Floats
from mafsil.derivation.arm import symbolic_arm
from mafsil.derivation.arm_numbers import CompiledArm, LetteredArm, Letters
from mafsil.derivation.tolerances import SAME
from mafsil.errors import ModelError
from mafsil.model import Mechanism

_ANGLES = ("alpha", "theta")
_MOST_READINGS = 24


@dataclass(frozen=True, slots=True)
class Reading:
    """One way to read the letters of typed formulas.

    Attributes:
        arm: the robot, with other lengths at the later states.
        q: (states, n) states.
        names: numbers of all names at the states.
        letters: names of lengths that may stand for each other by mistake.
    """

    arm: CompiledArm | LetteredArm
    q: Floats
    names: Mapping[str, Any]
    letters: tuple[str, ...]


def readings_of(
    mechanism: Mechanism,
    trees: Sequence[Sequence[ast.expr]],
    own: Mapping[str, float],
    q: Floats,
    kept: int,
    rng: np.random.Generator,
) -> Iterator[Reading]:
    """Ways to read the letters of typed formulas, each with arms of other lengths to hold them against.

    Lengths that are typed as numbers stay as they are, and so do all if one of the student's own letters is none of
    the arm's lengths.

    Args:
        mechanism: the robot.
        trees: the formulas.
        own: numbers of the student's own letters.
        q: (states, n) states.
        kept: at how many of them the arm has its own lengths.
        rng: of the others.
    """
    coordinates = {f"q{i + 1}": q[:, i] for i in range(mechanism.n)}
    try:
        arm = symbolic_arm(mechanism, None)
    except ModelError:
        yield Reading(CompiledArm(mechanism), q, {**own, **coordinates}, tuple(own))
        return
    spelled = {text: name for name in arm.letters for text in (name, name.replace("_", "")) if text not in own}
    used, typed = _used_names(trees), _typed_numbers(trees)
    found = list(_meanings({name: x for name, x in own.items() if name in used}, arm.letters))
    for meaning in found or [None]:
        known = {spelled[name] for name in used if name in spelled} | {m.lstrip("-") for m in (meaning or {}).values()}
        fixed = {
            name
            for name, value in arm.letters.items()
            if meaning is None or (name not in known and (name.startswith(_ANGLES) or abs(value) in typed))
        }
        letters = _vary(arm.letters, fixed, len(q), kept, rng)
        theirs = {name: (-1 if m[0] == "-" else 1) * letters[m.lstrip("-")] for name, m in (meaning or {}).items()}
        names = {**{text: letters[name] for text, name in spelled.items()}, **own, **theirs, **coordinates}
        lengths = [text for text, name in spelled.items() if not name.startswith(_ANGLES)]
        yield Reading(LetteredArm(arm, letters), q, names, (*own, *(text for text in lengths if "_" not in text)))


def _used_names(trees: Sequence[Sequence[ast.expr]]) -> set[str]:
    return {node.id for row in trees for tree in row for node in ast.walk(tree) if isinstance(node, ast.Name)}


def _meanings(own: Mapping[str, float], letters: Mapping[str, float]) -> Iterator[dict[str, str]]:
    """Which of the arm's letters each of the student's is, `-` in front for its negative: those with its number."""
    choices = [
        [sign + letter for letter, x in letters.items() for sign, y in (("", x), ("-", -x)) if abs(value - y) < SAME]
        for value in own.values()
    ]
    for chosen in islice(product(*choices), _MOST_READINGS):
        if len({letter.lstrip("-") for letter in chosen}) == len(chosen):
            yield dict(zip(own, chosen, strict=True))


def _typed_numbers(trees: Sequence[Sequence[ast.expr]]) -> set[float]:
    """Numbers that multiply or divide something: lengths typed as numbers are among them."""
    products = (
        node
        for row in trees
        for tree in row
        for node in ast.walk(tree)
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult | ast.Div)
    )
    constants = (side for node in products for side in (node.left, node.right) if isinstance(side, ast.Constant))
    return {abs(float(cast("float", constant.value))) for constant in constants}


def _vary(letters: Mapping[str, float], fixed: set[str], states: int, kept: int, rng: np.random.Generator) -> Letters:
    """Numbers of the letters at every state: the true ones at the first, others of the same sign behind."""
    found: Letters = {}
    for name, value in letters.items():
        factors: Floats = np.ones(states)
        if name not in fixed:
            factors[kept:] = rng.uniform(0.55, 1.8, states - kept)
        found[name] = value * factors
    return found
