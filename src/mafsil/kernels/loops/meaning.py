"""What a loop means, as a key: its instructions, constants and names, and those of the loops that it calls.

Comments, docstrings and lines do not count; a constant of a module counts where it is used. Two loops of equal meaning
are one machine code for the same kinds of arguments.
"""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from mafsil.kernels.identity import code_hash
from mafsil.kernels.loops.definition import Definition
from mafsil.kernels.loops.kinds import EditedError


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
