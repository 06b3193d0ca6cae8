"""Slips inside a formula: every term's sign, every sine and cosine, every angle is changed in turn."""

from __future__ import annotations

import ast
import copy
import re
from collections.abc import Iterator

from mafsil.derivation.review import Slip

_SHORT = re.compile(r"^([cs])(_?)(\d{1,9})$")


def repaired(tree: ast.expr, joints: int) -> Iterator[tuple[Slip, ast.expr]]:
    """Formulas that differ from the given one by one slip.

    Args:
        tree: of the formula.
        joints: number of joints, for angles with one more or one less.
    """
    yield Slip.SIGN, ast.UnaryOp(ast.USub(), tree)
    places = list(ast.walk(tree))
    for index, node in enumerate(places):
        for slip, changed in _changed(node, joints):
            yield slip, _with(tree, index, changed)


def _changed(node: ast.AST, joints: int) -> Iterator[tuple[Slip, ast.AST]]:
    match node:
        case ast.BinOp(left=left, op=ast.Add(), right=right):
            yield Slip.TERM_SIGN, ast.BinOp(left, ast.Sub(), right)
        case ast.BinOp(left=left, op=ast.Sub(), right=right):
            yield Slip.TERM_SIGN, ast.BinOp(left, ast.Add(), right)
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            yield Slip.TERM_SIGN, operand
        case ast.Call(func=ast.Name(id="sin" | "cos" as name), args=arguments):
            other = "cos" if name == "sin" else "sin"
            yield Slip.SINE_COSINE, ast.Call(ast.Name(other), arguments, [])
        case ast.Name(id=name):
            yield from ((slip, ast.Name(text)) for slip, text in _names(name, joints))
        case _:
            return
    if isinstance(node, ast.BinOp) and isinstance(node.left, ast.Name) and isinstance(node.op, ast.Mult):
        yield Slip.TERM_SIGN, ast.UnaryOp(ast.USub(), node)


def _names(name: str, joints: int) -> Iterator[tuple[Slip, str]]:
    """c12 for s12, and c1, c2, c123 for c12."""
    short = _SHORT.match(name)
    if not short:
        return
    letter, line, digits = short.groups()
    yield Slip.SINE_COSINE, f"{'c' if letter == 's' else 's'}{line}{digits}"
    runs = {
        "".join(str(k) for k in range(first, last + 1))
        for first in range(1, joints + 1)
        for last in range(first, joints + 1)
    }
    for run in sorted(runs - {digits}):
        yield Slip.ANGLE, f"{letter}{line}{run}"


def _with(tree: ast.expr, index: int, node: ast.AST) -> ast.expr:
    """A copy of the tree with the node of that index (in the order of `ast.walk`) replaced."""
    whole = ast.Expression(copy.deepcopy(tree))
    target = list(ast.walk(whole.body))[index]
    for parent in ast.walk(whole):
        for field, value in ast.iter_fields(parent):
            if value is target:
                setattr(parent, field, node)
            elif isinstance(value, list) and target in value:
                value[value.index(target)] = node
    return whole.body
