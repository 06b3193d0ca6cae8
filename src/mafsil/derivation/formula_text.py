"""Formulas typed by people, read without executing anything: numbers, names, + - * / **, sin, cos, sqrt.

Short names are understood: c12 = cos(q1 + q2), s3 = sin(q3), theta1 or θ1 for q1, and the letters of the robot.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Mapping
from typing import Any, cast

import numpy as np

from mafsil.errors import InputError

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
