"""Which variables of a function are one value each, found before it is translated: the others are cells of memory.

A suite is a block of statements; its path says in which others it lies. A name is one value where each of its
assignments stands alone in its suite and in all suites around it, and where everything that reads it stands in the
suite of one of them or inside. So the value is there whenever it is read.
"""

from __future__ import annotations

import ast

Path = tuple[int, ...]


class Scopes(ast.NodeVisitor):
    """Names of one function.

    Args:
        node: its source.

    Attributes:
        names: all that are given values.
        single: those that are one value wherever they are read.
    """

    def __init__(self, node: ast.FunctionDef) -> None:
        self._path: Path = ()
        self._count = 0
        self._stores: dict[str, list[Path]] = {each.arg: [()] for each in node.args.args}
        self._loads: dict[str, set[Path]] = {}
        for statement in node.body:
            self.visit(statement)
        self.names = frozenset(self._stores)
        self.single = frozenset(name for name in self._stores if self._is_single(name))

    def visit_Name(self, node: ast.Name) -> None:
        """A name read or given a value."""
        if isinstance(node.ctx, ast.Store):
            self._stores.setdefault(node.id, []).append(self._path)
        else:
            self._loads.setdefault(node.id, set()).add(self._path)

    def visit_AugAssign(self, node: ast.AugAssign) -> None:
        """A name changed is given a second value."""
        if isinstance(node.target, ast.Name):
            self._stores.setdefault(node.target.id, []).append(self._path)
        self.generic_visit(node)

    def visit_If(self, node: ast.If) -> None:
        """A condition and its two suites."""
        self.visit(node.test)
        self._suite(node.body)
        self._suite(node.orelse)

    def visit_While(self, node: ast.While) -> None:
        """A loop: its condition is read again after its body."""
        self.visit(node.test)
        self._suite(node.body)

    def visit_For(self, node: ast.For) -> None:
        """A loop: its name belongs to its body."""
        self.visit(node.iter)
        self._suite(node.body, node.target)

    def _suite(self, body: list[ast.stmt], target: ast.expr | None = None) -> None:
        outer, self._count = self._path, self._count + 1
        self._path = (*outer, self._count)
        if target is not None:
            self.visit(target)
        for statement in body:
            self.visit(statement)
        self._path = outer

    def _is_single(self, name: str) -> bool:
        stores = self._stores[name]
        apart = all(not _inside(a, b) for i, a in enumerate(stores) for j, b in enumerate(stores) if i != j)
        return apart and all(any(_inside(load, store) for store in stores) for load in self._loads.get(name, ()))


def _inside(path: Path, suite: Path) -> bool:
    return path[: len(suite)] == suite
