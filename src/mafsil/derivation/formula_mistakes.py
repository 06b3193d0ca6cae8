"""Mistakes inside a formula: every term's sign, every sine and cosine, every angle is changed in turn."""

from __future__ import annotations

import ast
import copy
import re
from collections.abc import Collection, Iterator
from itertools import combinations
from typing import cast

from mafsil.derivation.review import Mistake

_SHORT = re.compile(r"^([cs])(_?)(\d{1,9})$")


def repaired(tree: ast.expr, joints: int, letters: Collection[str] = ()) -> Iterator[tuple[Mistake, ast.expr]]:
    """Formulas that differ from the given one by one mistake.

    Args:
        tree: of the formula.
        joints: number of joints, for angles with one more or one less.
        letters: of the arm's lengths, for one in the place of another.
    """
    yield Mistake.SIGN, ast.UnaryOp(ast.USub(), tree)
    yield Mistake.SINE_COSINE, _renamed(tree, {"sin": "cos", "cos": "sin"}, {"s": "c", "c": "s"})
    places = list(ast.walk(tree))
    for index, node in enumerate(places):
        for mistake, changed in _changed(node, joints):
            yield mistake, _with(tree, index, changed)
    yield from _exchanged(tree, letters)


def _exchanged(tree: ast.expr, letters: Collection[str]) -> Iterator[tuple[Mistake, ast.expr]]:
    """One length for another at one place, or two lengths for each other everywhere."""
    used = [node.id for node in ast.walk(tree) if isinstance(node, ast.Name) and node.id in letters]
    for index, node in enumerate(ast.walk(tree)):
        if isinstance(node, ast.Name) and node.id in letters:
            for other in letters:
                if other != node.id:
                    yield Mistake.LETTER, _with(tree, index, ast.Name(other))
    for one, two in combinations(sorted(set(used)), 2):
        yield Mistake.LETTER, _renamed(tree, {one: two, two: one}, {})


def _renamed(tree: ast.expr, names: dict[str, str], short: dict[str, str]) -> ast.expr:
    """A copy with names exchanged, and with the first letters of c12 and s3 exchanged."""
    copied = copy.deepcopy(tree)
    for node in ast.walk(copied):
        if isinstance(node, ast.Name):
            node.id = names.get(node.id, node.id)
            found = _SHORT.match(node.id)
            if found and short:
                node.id = short[found[1]] + found[2] + found[3]
    return copied


def _changed(node: ast.AST, joints: int) -> Iterator[tuple[Mistake, ast.AST]]:
    match node:
        case ast.BinOp(left=left, op=ast.Add(), right=right):
            yield Mistake.TERM_SIGN, ast.BinOp(left, ast.Sub(), right)
        case ast.BinOp(left=left, op=ast.Sub(), right=right):
            yield Mistake.TERM_SIGN, ast.BinOp(left, ast.Add(), right)
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            yield Mistake.TERM_SIGN, operand
        case ast.Call(func=ast.Name(id="sin" | "cos" as name), args=arguments):
            other = "cos" if name == "sin" else "sin"
            yield Mistake.SINE_COSINE, ast.Call(ast.Name(other), arguments, [])
        case ast.Name(id=name):
            yield from ((mistake, ast.Name(text)) for mistake, text in _names(name, joints))
        case ast.BinOp(op=ast.Mult()):
            yield Mistake.TERM_SIGN, ast.UnaryOp(ast.USub(), node)
        case _:
            return


def _names(name: str, joints: int) -> Iterator[tuple[Mistake, str]]:
    """c12 for s12, and c1, c2, c123 for c12."""
    short = _SHORT.match(name)
    if not short:
        return
    letter, line, digits = short.groups()
    yield Mistake.SINE_COSINE, f"{'c' if letter == 's' else 's'}{line}{digits}"
    runs = {
        "".join(str(k) for k in range(first, last + 1))
        for first in range(1, joints + 1)
        for last in range(first, joints + 1)
    }
    for run in sorted(runs - {digits}):
        yield Mistake.ANGLE, f"{letter}{line}{run}"


def _with(tree: ast.expr, index: int, node: ast.AST) -> ast.expr:
    """A copy of the tree with the node of that index (in the order of `ast.walk`) replaced."""
    whole = ast.Expression(copy.deepcopy(tree))
    target = list(ast.walk(whole.body))[index]
    for parent in ast.walk(whole):
        for field, value in ast.iter_fields(parent):
            if value is target:
                setattr(parent, field, node)
            elif isinstance(value, list):
                children = cast("list[ast.AST]", value)
                if target in children:
                    children[children.index(target)] = node
    return whole.body
