"""Formulas typed by people, read without executing anything, and the lengths that their letters mean.

Numbers, names, + - * / **, sin, cos, sqrt are read. Short names are understood: c12 = cos(q1 + q2), s3 = sin(q3),
theta1 or θ1 for q1, and the letters of the robot. Other lengths to try the formulas at are those of an arm in numbers,
its lengths free: poses and Jacobians at states that may each have lengths of their own.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice, product
from typing import Any, TypeAlias, cast

import numpy as np

from mafsil.arrays import Floats
from mafsil.derivation.arm import SymbolicArm, symbolic_arm
from mafsil.derivation.polynomial import evaluate as poses_at
from mafsil.derivation.tolerances import SAME
from mafsil.errors import InputError, ModelError
from mafsil.model import Mechanism
from mafsil.robot import Robot

Letters: TypeAlias = dict[str, Any]
_ANGLES = ("alpha", "theta")
_MOST_READINGS = 24
LONGEST = 2000
"""Characters of one formula."""
DEEPEST = 200
"""Operations inside each other."""
_SHORT = re.compile(r"^([cs])_?(\d{1,9})$")
_COORDINATE = re.compile(r"^(?:q|theta|θ|t)_?(\d{1,2})$")
_FUNCTIONS: dict[str, Callable[[Any], Any]] = {"sin": np.sin, "cos": np.cos, "sqrt": np.sqrt}
_OPERATIONS: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: np.add,
    ast.Sub: np.subtract,
    ast.Mult: np.multiply,
    ast.Div: np.true_divide,
}
_MOST_POWER = 6
_LARGEST = 10**15


def parse_formula(text: str) -> ast.expr:
    """The tree of a formula.

    Args:
        text: such as `-L1*s1 - L2*s12`.

    Raises:
        InputError: it is too long, no formula, or uses anything that is not allowed.
    """
    if len(text) > LONGEST:
        raise InputError("derivation.formula_long", length=len(text), limit=LONGEST)
    try:
        tree = ast.parse(text.replace("^", "**").replace("−", "-").strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise InputError("derivation.formula", text=text[:80]) from None
    _require_allowed(tree, text)
    return tree


def evaluate(tree: ast.expr, values: Mapping[str, Any]) -> Any:
    """The number, or array of numbers, of a formula.

    Args:
        tree: from `parse_formula`.
        values: q1, q2 ... and the letters.

    Raises:
        InputError: a name that has no value; the sentence lists those that have.
    """
    with np.errstate(all="ignore"):
        return _value(tree, values)


def _value(tree: ast.expr, values: Mapping[str, Any]) -> Any:
    match tree:
        case ast.Constant(value=value):
            return np.float64(cast("float", value))
        case ast.Name(id=name):
            return _name(name, values)
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return -_value(operand, values)
        case ast.UnaryOp(operand=operand):
            return _value(operand, values)
        case ast.Call(func=ast.Name(id=name), args=[argument]):
            return _FUNCTIONS[name](_value(argument, values))
        case ast.BinOp(left=left, op=ast.Pow(), right=ast.Constant(value=power)):
            return _value(left, values) ** cast("int", power)
        case ast.BinOp(left=left, op=op, right=right):
            return _OPERATIONS[type(op)](_value(left, values), _value(right, values))
        case _:
            raise InputError("derivation.formula", text=ast.unparse(tree)[:80])


def _name(name: str, values: Mapping[str, Any]) -> Any:
    if name in values:
        return values[name]
    if name == "pi":
        return np.pi
    coordinate = _COORDINATE.match(name)
    if coordinate and f"q{coordinate[1]}" in values:
        return values[f"q{coordinate[1]}"]
    short = _SHORT.match(name)
    if short and all(f"q{digit}" in values for digit in short[2]):
        angle = sum(values[f"q{digit}"] for digit in short[2])
        return np.sin(angle) if short[1] == "s" else np.cos(angle)
    raise InputError("derivation.formula_name", name=name[:40], known=", ".join(sorted(values)))


def _require_allowed(tree: ast.expr, text: str) -> None:
    """Nothing but the arithmetic above, not nested beyond what a person writes."""
    if _depth(tree) > DEEPEST:
        raise InputError("derivation.formula_deep", limit=DEEPEST)
    for node in ast.walk(tree):
        match node:
            case ast.Constant(value=bool()):
                raise InputError("derivation.formula", text=text[:80])
            case ast.Constant(value=int(number)) if number > _LARGEST:
                raise InputError("derivation.formula", text=text[:80])
            case ast.Constant(value=int() | float()) | ast.Name() | ast.UnaryOp(op=ast.USub() | ast.UAdd()):
                continue
            case ast.Call(func=ast.Name(id=name), args=[_], keywords=[]) if name in _FUNCTIONS:
                continue
            case ast.BinOp(op=ast.Pow(), right=ast.Constant(value=int(power))) if 0 <= power <= _MOST_POWER:
                continue
            case ast.BinOp(op=op) if type(op) in _OPERATIONS:
                continue
            case ast.operator() | ast.unaryop() | ast.expr_context():
                continue
            case _:
                raise InputError("derivation.formula", text=text[:80])


def _depth(tree: ast.AST) -> int:
    """Levels of the tree, found without recursion."""
    level, depth = [tree], 0
    while level:
        level, depth = [child for node in level for child in ast.iter_child_nodes(node)], depth + 1
    return depth


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
        known = {spelled[name] for name in used if name in spelled}
        letters = _vary(arm.letters, _constant_letters(arm.letters, meaning, known, typed), len(q), kept, rng)
        theirs = {name: (-1 if m[0] == "-" else 1) * letters[m.lstrip("-")] for name, m in (meaning or {}).items()}
        names = {**{text: letters[name] for text, name in spelled.items()}, **own, **theirs, **coordinates}
        lengths = [text for text, name in spelled.items() if not name.startswith(_ANGLES)]
        yield Reading(LetteredArm(arm, letters), q, names, (*own, *(text for text in lengths if "_" not in text)))


def _constant_letters(
    letters: Mapping[str, float], meaning: Mapping[str, str] | None, known: set[str], typed: set[float]
) -> set[str]:
    """Letters that keep their numbers in other arms: angles, lengths typed as numbers; all of them without meaning."""
    if meaning is None:
        return set(letters)
    known = known | {name.lstrip("-") for name in meaning.values()}
    stays = {name for name, value in letters.items() if name.startswith(_ANGLES) or abs(value) in typed}
    return stays - known


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
        T = poses_at(self.arm.base.entries, values, count)
        J, points = np.zeros((count, 6, self.arm.mechanism.n)), [T[:, :3, 3]]
        for row, place in zip(self.arm.rows, self.arm.coordinates, strict=True):
            T = T @ poses_at(row.transform().entries, values, count)
            z, p = T[:, :3, 2], T[:, :3, 3]
            points.append(p)
            turns = row.row.kind == "R"
            J[:, :3, place], J[:, 3:, place] = (z, np.cross(p, z)) if turns else (0.0, z)
        tip = T @ poses_at(self.arm.tool.entries, values, count)
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
