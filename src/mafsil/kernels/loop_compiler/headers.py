"""What callers of a compiled loop know of it: its name and the types of its arguments and its result."""

from __future__ import annotations

import ast
from collections.abc import Container, Mapping
from dataclasses import dataclass

from mafsil.kernels.loop_compiler.values import Kind, kind_of


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


def header_of(node: ast.FunctionDef, records: Container[str] = ()) -> Header:
    """The types that a function's annotations say.

    Args:
        node: its source.
        records: names of the program's records.
    """

    def kind(annotation: ast.expr | None) -> Kind:
        return kind_of("" if annotation is None else ast.unparse(annotation), records)

    result = None if node.returns is None or ast.unparse(node.returns) == "None" else kind(node.returns)
    return Header(node.name, {each.arg: kind(each.annotation) for each in node.args.args}, result)
