"""What makes a function a loop of the language: its code, which variables are one value, and what it means, as a key.

Variables that are one value are found before the function is translated; the others are cells of memory. A suite is a
block of statements; its path says in which others it lies. A name is one value where each of its assignments stands
alone in its suite and in all suites around it, and where everything that reads it stands in the suite of one of them or
inside. So the value is there whenever it is read.

The key hashes the loop's instructions, constants and names, and those of the loops that it calls; comments,
docstrings and lines do not count, and a constant of a module counts where it is used. Two loops of equal meaning are
one machine code for the same kinds of arguments.
"""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from mafsil.kernels.identity import code_hash
from mafsil.kernels.loops.kinds import EditedError, Kind

SuitePath = tuple[int, ...]
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
        self._path: SuitePath = ()
        self._count = 0
        self._stores: dict[str, list[SuitePath]] = {each.arg: [()] for each in node.args.args}
        self._loads: dict[str, set[SuitePath]] = {}
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


def _inside(path: SuitePath, suite: SuitePath) -> bool:
    return path[: len(suite)] == suite


@dataclass(frozen=True)
class Closure:
    """A loop with all that it refers to.

    Attributes:
        digest: of its meaning.
        definitions: of the loops that it calls, by name, itself included.
        classes: of named tuples that it names, by `module:name`.
    """

    digest: str
    definitions: Mapping[str, Definition]
    classes: Mapping[str, type[Any]]


@dataclass(frozen=True)
class _Own:
    """What a loop itself says, and whom it names."""

    text: str
    callees: tuple[Definition, ...]
    classes: tuple[type[Any], ...]


_OWN: dict[Definition, _Own] = {}
_CLOSURES: dict[Definition, Closure] = {}


def closure_of(definition: Definition) -> Closure:
    """The meaning of a loop; found once in a process."""
    known = _CLOSURES.get(definition)
    if known is None:
        found: dict[Definition, _Own] = {}
        waiting = [definition]
        while waiting:
            each = waiting.pop()
            if each not in found:
                found[each] = _own(each)
                waiting += found[each].callees
        texts = sorted(f"{each.name} {own.text}" for each, own in found.items())
        digest = hashlib.blake2b("\n".join((definition.name, *texts)).encode(), digest_size=16).hexdigest()
        classes = {f"{each.__module__}:{each.__qualname__}": each for own in found.values() for each in own.classes}
        known = _CLOSURES[definition] = Closure(digest, {each.name: each for each in found}, classes)
    return known


def _own(definition: Definition) -> _Own:
    known = _OWN.get(definition)
    if known is None:
        function = definition.function
        code: CodeType = function.__code__
        words: list[str] = [definition.fast, str(definition.inline), *definition.words, instructions(code)]
        callees: list[Definition] = []
        classes: list[type[Any]] = []
        for name, value in _name(function, code):
            words.append(f"{name}={_word(value, callees, classes)}")
        text = hashlib.blake2b("\n".join(words).encode(), digest_size=16).hexdigest()
        known = _OWN[definition] = _Own(text, tuple(dict.fromkeys(callees)), tuple(dict.fromkeys(classes)))
    return known


def instructions(code: CodeType) -> str:
    """Hash of a function of Python as it runs, without its docstring."""
    first, *others = code.co_consts or (None,)
    return code_hash(code.replace(co_consts=(None if isinstance(first, str) else first, *others)), set())


def _name(function: Any, code: CodeType) -> Iterable[tuple[str, Any]]:
    """The names of a function and what they mean in its module; of a module's names those that it uses."""
    cells = function.__closure__ or ()
    space = dict(zip(code.co_freevars, (cell.cell_contents for cell in cells), strict=True))
    for name in (*code.co_freevars, *code.co_names):
        if name in space:
            value = space[name]
        elif name in function.__globals__:
            value = function.__globals__[name]
        else:
            continue
        yield name, value
        if isinstance(value, ModuleType) and value.__name__.split(".")[0] not in ("numpy", "math"):
            yield from ((f"{name}.{each}", vars(value)[each]) for each in code.co_names if each in vars(value))


def _word(value: Any, callees: list[Definition], classes: list[type[Any]]) -> str:
    """What a name stands for, as text."""
    definition = getattr(value, "definition", None)
    if isinstance(definition, Definition):
        callees.append(definition)
        return definition.name
    if isinstance(value, type):
        if hasattr(value, "_fields"):
            classes.append(cast("type[Any]", value))
            return f"{value.__module__}:{value.__qualname__}{cast('Any', value)._fields}"
        return f"{value.__module__}:{value.__qualname__}"
    if isinstance(value, np.ndarray):
        table = cast("NDArray[Any]", value)
        return f"{table.dtype} {table.shape} {hashlib.blake2b(table.tobytes()).hexdigest()}"
    if isinstance(value, bool | int | float | complex | str | np.generic | tuple):
        return f"{type(value).__name__} {value!r}"  # pyright: ignore[reportUnknownArgumentType]
    return f"{getattr(value, '__module__', '')}:{getattr(value, '__qualname__', type(value).__qualname__)}"


def source_of(definition: Definition) -> ast.FunctionDef:
    """The syntax of a loop.

    Raises:
        KernelError: its file is not there, or has been edited since it was imported.
    """
    function = definition.function
    path = function.__code__.co_filename
    try:
        tree, codes = _parse(path, Path(path).stat().st_mtime_ns)
    except (OSError, SyntaxError) as error:
        raise EditedError(f"{definition.name}: its source cannot be read ({error})") from None
    code: CodeType = function.__code__
    same = codes.get((code.co_qualname, code.co_firstlineno))
    node = tree.get((code.co_name, code.co_firstlineno))
    if node is None or same is None or instructions(same) != instructions(code):
        raise EditedError(f"{definition.name}: its source was edited after it was imported")
    return node


_SUITES = ("body", "orelse", "handlers", "finalbody")
"""Where statements hold statements."""


@cache
def _parse(path: str, _changed: int) -> tuple[dict[tuple[str, int], ast.FunctionDef], dict[tuple[str, int], CodeType]]:
    """Functions of a file by name and first line: their syntax, and what Python makes of them."""
    text = Path(path).read_text("utf-8")
    tree = ast.parse(text, path)
    nodes: dict[tuple[str, int], ast.FunctionDef] = {}
    statements: list[ast.AST] = [tree]
    for node in statements:
        if isinstance(node, ast.FunctionDef):
            first = node.decorator_list[0].lineno if node.decorator_list else node.lineno
            nodes[node.name, first] = node
        statements += [each for name in _SUITES for each in getattr(node, name, ())]
    codes: dict[tuple[str, int], CodeType] = {}
    waiting = [compile(tree, path, "exec", dont_inherit=True)]
    while waiting:
        code = waiting.pop()
        codes[code.co_qualname, code.co_firstlineno] = code
        waiting += [each for each in code.co_consts if isinstance(each, CodeType)]
    return nodes, codes
