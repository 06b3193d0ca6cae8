"""What makes a function a loop of the language: the function, how its code is made, and which variables are one value.

Those are found before the function is translated; the others are cells of memory. A suite is a block of statements; its
path says in which others it lies. A name is one value where each of its assignments stands alone in its suite and in
all suites around it, and where everything that reads it stands in the suite of one of them or inside. So the value is
there whenever it is read.
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from mafsil.kernels.loops.kinds import Kind

Path = tuple[int, ...]
MISS = object()
"""What a builtin returns where it is not made for the arguments."""
FREE_ORDER = "reassoc nsz contract "
"""Flags of arithmetic whose sums may be taken in another order."""


@dataclass(frozen=True, eq=False)
class Definition:
    """A function of the language.

    Attributes:
        function: of Python.
        inline: whether it becomes part of each of its callers.
        fast: flags of its arithmetic.
    """

    function: Callable[..., Any]
    inline: bool = False
    fast: str = ""

    @property
    def definition(self) -> Definition:
        """Itself: a loop has one too."""
        return self

    @property
    def name(self) -> str:
        """Module and name."""
        return f"{self.function.__module__}:{self.function.__qualname__}"

    @property
    def arguments(self) -> tuple[str, ...]:
        """Names of its arguments."""
        code = self.function.__code__
        return code.co_varnames[: code.co_argcount]

    @property
    def words(self) -> tuple[str, ...]:
        """Annotations of its arguments, as written; empty where there is none."""
        notes = self.function.__annotations__
        return tuple(str(notes.get(name, "")) for name in self.arguments)


class Callee(Protocol):
    """What a function that is being translated knows of one that it calls."""

    @property
    def symbol(self) -> str:
        """Its name in LLVM IR."""
        ...

    @property
    def result(self) -> Kind:
        """Kind of its result."""
        ...

    @property
    def fails(self) -> bool:
        """Whether it says at its end that memory was lacking."""
        ...

    @property
    def shares_region(self) -> bool:
        """Whether its memory joins that of its caller."""
        ...


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
