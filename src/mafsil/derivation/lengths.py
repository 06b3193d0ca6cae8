"""The letters of a typed matrix: which lengths of the arm they are, and other lengths to try the formulas at.

An arm in numbers, its lengths free: poses and Jacobians at states that may each have lengths of their own.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice, product
from typing import Any, TypeAlias, cast

import numpy as np

from mafsil.arrays import Floats
from mafsil.derivation.arm import SymbolicArm, symbolic_arm
from mafsil.derivation.matrices import evaluate
from mafsil.derivation.tolerances import SAME
from mafsil.errors import ModelError
from mafsil.model import Mechanism
from mafsil.robot import Robot

Letters: TypeAlias = dict[str, Any]
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


class CompiledArm:
    """The robot as it is.

    Args:
        mechanism: the robot.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.robot = Robot(mechanism)

    def space(self, q: Floats) -> tuple[Floats, Floats, list[Floats]]:
        """J_s (states, 6, n), tip poses (states, 4, 4) and origins (states, 3) of links and tip at q (states, n)."""
        poses, tip = np.asarray(self.robot.link_poses(q)), np.asarray(self.robot.forward_kinematics(q))
        points = [*np.moveaxis(poses[:, :, :3, 3], 1, 0), tip[:, :3, 3]]
        return np.array(self.robot.jacobian_space(q)), tip, points


class LetteredArm:
    """The robot with other lengths: every state has its own.

    Args:
        arm: in letters.
        letters: (states,) or single numbers of all letters.
    """

    def __init__(self, arm: SymbolicArm, letters: Letters) -> None:
        self.arm, self.letters = arm, letters

    def space(self, q: Floats) -> tuple[Floats, Floats, list[Floats]]:
        """As `CompiledArm.space`; the origins are those of the table's frames."""
        values, count = {**self.arm.values(q), **self.letters}, len(q)
        T = evaluate(self.arm.base.entries, values, count)
        J, points = np.zeros((count, 6, self.arm.mechanism.n)), [T[:, :3, 3]]
        for row, place in zip(self.arm.rows, self.arm.coordinates, strict=True):
            T = T @ evaluate(row.transform().entries, values, count)
            z, p = T[:, :3, 2], T[:, :3, 3]
            points.append(p)
            turns = row.row.kind == "R"
            J[:, :3, place], J[:, 3:, place] = (z, np.cross(p, z)) if turns else (0.0, z)
        tip = T @ evaluate(self.arm.tool.entries, values, count)
        return J, tip, [*points, tip[:, :3, 3]]


class Truth:
    """Jacobians at states q (states, n), their rows chosen to match a given matrix.

    Args:
        arm: where they come from.
        q: (states, n) states.
        rows: 6, or 3 or 2 of the tip's velocity.
    """

    def __init__(self, arm: CompiledArm | LetteredArm, q: Floats, rows: int) -> None:
        self.arm, self.q, self.rows = arm, q, rows

    def jacobian(self, kind: str, q: Floats | None = None) -> Floats:
        """(states, rows, n): `space`, `body`, `tip` (velocity of the tip point in {s}, angular rows first if six)."""
        J, tip, _ = self.arm.space(self.q if q is None else q)
        J = J.copy()
        if kind != "space":
            J[:, 3:] += np.cross(J[:, :3], tip[:, :3, 3, None], axisa=1, axisb=1, axisc=1)
        if kind == "body":
            R = tip[:, :3, :3].transpose(0, 2, 1)
            J = np.concatenate([R @ J[:, :3], R @ J[:, 3:]], axis=1)
        return J if self.rows == 6 else J[:, 3 : 3 + self.rows]

    def points(self) -> list[Floats]:
        """Positions (states, 3) of the origins of all links and of the tip."""
        return self.arm.space(self.q)[2]
