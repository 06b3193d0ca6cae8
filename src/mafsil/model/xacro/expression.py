"""Expressions inside `${...}`: a small part of Python, interpreted over its syntax tree; nothing else is reached."""

from __future__ import annotations

import ast
import operator
import re
from collections.abc import Callable, Iterator, Mapping
from difflib import get_close_matches
from functools import lru_cache
from typing import Any, Protocol, cast

from mafsil.model.faults import XACRO_UNDEFINED
from mafsil.model.vocabulary import nearest_words
from mafsil.model.xacro.methods import FIELDS, METHODS
from mafsil.model.xacro.values import (
    LARGEST_COLLECTION,
    LONGEST_TEXT,
    MOST_BITS,
    Budget,
    Function,
    Namespace,
    Value,
    XacroFault,
    check_size,
    in_order,
    wrong,
)

LONGEST = 4000
"""Characters of an expression."""
SHORT = 200
DEEPEST = 60
"""Of its syntax tree."""
_PAD = re.compile(r"%(?:\(.*\))?[^a-zA-Z%]*(?:\d{4,}|\*)", re.DOTALL)
_TROUBLE = (TypeError, ValueError, ZeroDivisionError, OverflowError, KeyError, IndexError, AttributeError)


class Names(Protocol):
    """Where names are looked up."""

    def lookup(self, name: str) -> Value:
        """The value of a name.

        Raises:
            KeyError: it is not defined.
        """
        ...

    def known(self) -> Iterator[str]:
        """Every name, for hints."""
        ...


def evaluate(text: str, names: Names, budget: Budget) -> Value:
    """The value of an expression.

    Args:
        text: between the braces.
        names: properties and functions.
        budget: of the whole expansion.

    Raises:
        XacroFault: not an expression of the part of Python that is allowed, an unknown name, no value, too large.
    """
    budget.spend(1 + (len(text) >> 1))
    tree = _parse(text.strip())
    if isinstance(tree, str):
        raise wrong(tree)
    try:
        return _Evaluation(names, budget).value(tree, 0)
    except _TROUBLE as error:
        reason = f"no such key: {error}" if isinstance(error, KeyError) else str(error)
        raise wrong(reason) from None
    except RecursionError:
        raise wrong("nested too deeply") from None


def _parse(text: str) -> ast.expr | str:
    """The syntax tree, or why there is none; short ones are kept for the next time, long ones take much memory."""
    return _kept(text) if len(text) <= SHORT else _tree(text)


@lru_cache(maxsize=2048)
def _kept(text: str) -> ast.expr | str:
    return _tree(text)


def _tree(text: str) -> ast.expr | str:
    if len(text) > LONGEST:
        return f"longer than {LONGEST} characters"
    try:
        return ast.parse(text, mode="eval").body
    except (SyntaxError, ValueError) as error:
        return getattr(error, "msg", "") or str(error)
    except (RecursionError, MemoryError):
        return "nested too deeply"


def _add(a: Value, b: Value) -> Value:
    if isinstance(a, str | list | tuple) and isinstance(b, str | list | tuple):
        if len(cast("str", a)) + len(cast("str", b)) > LONGEST_TEXT:
            raise wrong("too long")
    return cast("Any", a) + b


def _multiply(a: Value, b: Value) -> Value:
    if isinstance(a, int) and isinstance(b, str | list | tuple):
        a, b = cast("Value", b), a
    if isinstance(a, str | list | tuple) and isinstance(b, int):
        if len(cast("str", a)) * max(b, 0) > LONGEST_TEXT:
            raise wrong("too long")
    return cast("Any", a) * b


def _power(a: Value, b: Value) -> Value:
    if isinstance(a, int) and isinstance(b, int) and a.bit_length() * max(b, 0) > MOST_BITS:
        raise wrong("the power is too large")
    result: Value = cast("Any", a) ** b
    if isinstance(result, complex) and not isinstance(a, complex) and not isinstance(b, complex):
        raise wrong("the power of a negative number has no real value")
    return result


def _remainder(a: Value, b: Value) -> Value:
    if isinstance(a, str) and (_PAD.search(a) or len(a) > 1000):
        raise wrong("a format of this width is not allowed")
    return cast("Any", a) % b


_BINARY: dict[type[ast.operator], Callable[[Any, Any], Value]] = {
    ast.Add: _add,
    ast.Sub: operator.sub,
    ast.Mult: _multiply,
    ast.Div: lambda a, b: a / b,
    ast.FloorDiv: lambda a, b: a // b,
    ast.Mod: _remainder,
    ast.Pow: _power,
    ast.BitAnd: lambda a, b: a & b,
    ast.BitOr: lambda a, b: a | b,
    ast.BitXor: lambda a, b: a ^ b,
}
_UNARY: dict[type[ast.unaryop], Callable[..., Value]] = {
    ast.UAdd: operator.pos,
    ast.USub: operator.neg,
    ast.Not: operator.not_,
    ast.Invert: operator.invert,
}
_COMPARE: dict[type[ast.cmpop], Callable[[Any, Any], Value]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Is: operator.is_,
    ast.IsNot: operator.is_not,
    ast.In: lambda a, b: a in b,
    ast.NotIn: lambda a, b: a not in b,
}


class _Inner:
    """Names bound by a comprehension, in front of those around it."""

    def __init__(self, outer: Names) -> None:
        self.outer = outer
        self.bound: dict[str, Value] = {}

    def lookup(self, name: str) -> Value:
        return self.bound[name] if name in self.bound else self.outer.lookup(name)

    def known(self) -> Iterator[str]:
        yield from self.bound
        yield from self.outer.known()


class _Evaluation:
    """Walks one syntax tree."""

    def __init__(self, names: Names, budget: Budget) -> None:
        self.names = names
        self.budget = budget

    def value(self, node: ast.AST, depth: int) -> Value:
        """The value of a node; kinds that are not in the table are refused."""
        self.budget.spend()
        if depth > DEEPEST:
            raise wrong("nested too deeply")
        visit = _VISITS.get(type(node))
        if visit is None:
            raise wrong(f"{type(node).__name__} is not allowed")
        return check_size(visit(self, node, depth + 1), self.budget)

    def constant(self, node: ast.Constant, _depth: int) -> Value:
        if not isinstance(node.value, bool | int | float | str | None):
            raise wrong(f"{type(node.value).__name__} is not allowed")
        return node.value

    def name(self, node: ast.Name, _depth: int) -> Value:
        return name_value(node.id, self.names)

    def binary(self, node: ast.BinOp, depth: int) -> Value:
        operation = _BINARY.get(type(node.op))
        if operation is None:
            raise wrong(f"{type(node.op).__name__} is not allowed")
        return operation(self.value(node.left, depth), self.value(node.right, depth))

    def unary(self, node: ast.UnaryOp, depth: int) -> Value:
        return _UNARY[type(node.op)](self.value(node.operand, depth))

    def boolean(self, node: ast.BoolOp, depth: int) -> Value:
        stops = isinstance(node.op, ast.Or)
        result: Value = not stops
        for operand in node.values:
            result = self.value(operand, depth)
            if bool(result) is stops:
                break
        return result

    def compare(self, node: ast.Compare, depth: int) -> Value:
        left = self.value(node.left, depth)
        for kind, other in zip(node.ops, node.comparators, strict=True):
            right = self.value(other, depth)
            if not _COMPARE[type(kind)](left, right):
                return False
            left = right
        return True

    def conditional(self, node: ast.IfExp, depth: int) -> Value:
        return self.value(node.body if self.value(node.test, depth) else node.orelse, depth)

    def sequence(self, node: ast.List | ast.Tuple, depth: int) -> Value:
        found = [self.value(item, depth) for item in node.elts]
        return found if isinstance(node, ast.List) else tuple(found)

    def collection(self, node: ast.Set, depth: int) -> Value:
        return {self.value(item, depth) for item in node.elts}

    def dictionary(self, node: ast.Dict, depth: int) -> Value:
        if any(key is None for key in node.keys):
            raise wrong("** is not allowed")
        keys = [self.value(key, depth) for key in node.keys if key is not None]
        return dict(zip(keys, (self.value(item, depth) for item in node.values), strict=True))

    def subscript(self, node: ast.Subscript, depth: int) -> Value:
        holder = self.value(node.value, depth)
        if not isinstance(holder, str | list | tuple | dict):
            raise wrong(f"{type(holder).__name__} has no members")
        at: Value
        if isinstance(node.slice, ast.Slice):
            ends = (node.slice.lower, node.slice.upper, node.slice.step)
            at = slice(*(None if end is None else self.value(end, depth) for end in ends))
        else:
            at = self.value(node.slice, depth)
        return cast("dict[Value, Value]", holder)[at]

    def attribute(self, node: ast.Attribute, depth: int) -> Value:
        holder = self.value(node.value, depth)
        if node.attr.startswith("_"):
            raise wrong(f"{node.attr} is not allowed")
        if isinstance(holder, Namespace):
            try:
                return holder.get(node.attr)
            except KeyError:
                close = ", ".join(nearest_words(node.attr, holder.known))
                raise XacroFault(XACRO_UNDEFINED, name=ast.unparse(node), close=close) from None
        kind = type(holder)
        if isinstance(holder, dict) and node.attr in cast("dict[Value, Value]", holder):
            return cast("dict[Value, Value]", holder)[node.attr]
        if (kind, node.attr) in FIELDS:
            return getattr(cast("Value", holder), node.attr)
        method = METHODS.get((kind, node.attr))
        if method is None:
            raise wrong(f"{kind.__name__} has no {node.attr}")
        return Function(node.attr, lambda *arguments: method(holder, *arguments))

    def call(self, node: ast.Call, depth: int) -> Value:
        function = self.value(node.func, depth)
        if not isinstance(function, Function):
            raise wrong("only the functions of xacro can be called")
        if any(keyword.arg is None for keyword in node.keywords):
            raise wrong("** is not allowed")
        arguments = [self.value(argument, depth) for argument in node.args]
        named = {str(keyword.arg): self.value(keyword.value, depth) for keyword in node.keywords}
        return function.call(*arguments, **named)

    def comprehension(self, node: ast.ListComp | ast.GeneratorExp, depth: int) -> Value:
        return [self.value(node.elt, depth) for _ in self._bindings(node.generators, depth)]

    def set_comprehension(self, node: ast.SetComp, depth: int) -> Value:
        return {self.value(node.elt, depth) for _ in self._bindings(node.generators, depth)}

    def dictionary_comprehension(self, node: ast.DictComp, depth: int) -> Value:
        bindings = self._bindings(node.generators, depth)
        return {self.value(node.key, depth): self.value(node.value, depth) for _ in bindings}

    def _bindings(self, generators: list[ast.comprehension], depth: int) -> Iterator[None]:
        """Binds the names of a comprehension, one member after the other; while it runs, names are looked up inside."""
        outer = self.names
        inner = _Inner(outer)
        self.names = inner
        try:
            for count, _ in enumerate(self._nest(generators, inner, depth)):
                if count >= LARGEST_COLLECTION:
                    raise wrong("too long")
                yield
        finally:
            self.names = outer

    def _nest(self, generators: list[ast.comprehension], inner: _Inner, depth: int) -> Iterator[None]:
        if not generators:
            yield
            return
        first, *rest = generators
        for member in in_order(self.value(first.iter, depth)):
            self.budget.spend()
            _bind(first.target, member, inner.bound)
            if all(self.value(condition, depth) for condition in first.ifs):
                yield from self._nest(rest, inner, depth)


def _bind(target: ast.expr, value: Value, bound: dict[str, Value]) -> None:
    """Give the names of a comprehension their values."""
    if isinstance(target, ast.Name):
        bound[target.id] = value
    elif isinstance(target, ast.Tuple):
        values = list(cast("list[Value]", value))
        for part, member in zip(target.elts, values, strict=True):
            _bind(part, member, bound)
    else:
        raise wrong(f"{type(target).__name__} is not allowed")


def name_value(name: str, names: Names) -> Value:
    """The value of a name.

    Raises:
        XacroFault: it is not defined; the sentence offers what looks like it.
    """
    if name.startswith("__"):
        raise wrong(f"{name} is not allowed")
    try:
        return names.lookup(name)
    except KeyError:
        close = get_close_matches(name, sorted(set(names.known())), n=3)
        raise XacroFault(XACRO_UNDEFINED, name=name, close=", ".join(close)) from None


_VISITS: Mapping[type[ast.AST], Callable[[_Evaluation, ast.AST, int], Value]] = cast(
    "Mapping[type[ast.AST], Callable[[_Evaluation, ast.AST, int], Value]]",
    {
        ast.Constant: _Evaluation.constant,
        ast.Name: _Evaluation.name,
        ast.BinOp: _Evaluation.binary,
        ast.UnaryOp: _Evaluation.unary,
        ast.BoolOp: _Evaluation.boolean,
        ast.Compare: _Evaluation.compare,
        ast.IfExp: _Evaluation.conditional,
        ast.List: _Evaluation.sequence,
        ast.Tuple: _Evaluation.sequence,
        ast.Set: _Evaluation.collection,
        ast.SetComp: _Evaluation.set_comprehension,
        ast.Dict: _Evaluation.dictionary,
        ast.Subscript: _Evaluation.subscript,
        ast.Attribute: _Evaluation.attribute,
        ast.Call: _Evaluation.call,
        ast.ListComp: _Evaluation.comprehension,
        ast.GeneratorExp: _Evaluation.comprehension,
        ast.DictComp: _Evaluation.dictionary_comprehension,
    },
)
