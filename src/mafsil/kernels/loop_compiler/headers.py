"""What callers of a compiled loop know of it: its name and the types of its arguments and its result."""

from __future__ import annotations

import ast
from collections.abc import Mapping
from dataclasses import dataclass

from mafsil.kernels.loop_compiler.values import ANNOTATIONS, Kind, refused


@dataclass(frozen=True)
class Header:
    """What callers of a function know.

    Attributes:
        name: of the function.
        arguments: their names and types.
        result: type of its result, or None.
    """

    name: str
    arguments: Mapping[str, Kind]
    result: Kind | None


def header_of(node: ast.FunctionDef) -> Header:
    """The types that a function's annotations say."""
    result = None if node.returns is None or ast.unparse(node.returns) == "None" else _kind(node.returns)
    return Header(node.name, {each.arg: _kind(each.annotation) for each in node.args.args}, result)


def _kind(annotation: ast.expr | None) -> Kind:
    name = "" if annotation is None else ast.unparse(annotation)
    if name not in ANNOTATIONS:
        raise refused(f"the annotation {name!r}")
    return ANNOTATIONS[name]
