"""One scalar value of an expression graph, and what every operation does to numbers.

A node knows its operation and its operands and nothing else: graphs are shared freely, need no lock, and are freed with
the last expression that holds them.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeAlias

CONSTANT, SYMBOL = "const", "symbol"

Rule: TypeAlias = Callable[..., "Node"]
"""Builds a node of one operand or two."""


class Node:
    """An operation on earlier nodes, a constant or a symbol; never changed after it is made.

    Attributes:
        op: `const`, `symbol`, or a key of `FOLDS`.
        a, b: operands; `LEAF` where there is none.
        value: the number of a constant.
    """

    __slots__ = ("a", "b", "op", "value")

    op: str
    a: Node
    b: Node
    value: float

    def __init__(self, op: str, a: Node, b: Node, value: float = 0.0) -> None:
        self.op = op
        self.a = a
        self.b = b
        self.value = value


class Symbol(Node):
    """A free variable; two symbols of the same name are different variables."""

    __slots__ = ("name",)

    def __init__(self, name: str) -> None:
        super().__init__(SYMBOL, LEAF, LEAF)
        self.name = name


def _leaf() -> Node:
    """The operand of nodes without operands; its own operands are itself."""
    leaf = Node.__new__(Node)
    leaf.op, leaf.a, leaf.b, leaf.value = "leaf", leaf, leaf, 0.0
    return leaf


LEAF = _leaf()
ZERO, ONE, TWO, MINUS_ONE = (Node(CONSTANT, LEAF, LEAF, value) for value in (0.0, 1.0, 2.0, -1.0))
_FREQUENT = {0.0: ZERO, 1.0: ONE, 2.0: TWO, -1.0: MINUS_ONE}


def constant(value: float) -> Node:
    """A number; minus zero becomes zero."""
    return _FREQUENT.get(value) or Node(CONSTANT, LEAF, LEAF, value)


def same(x: Node, y: Node) -> bool:
    """The same node, equal numbers, or the same operation on the same nodes: looks no deeper."""
    if x is y:
        return True
    if x.op != y.op:
        return False
    if x.op == CONSTANT:
        return x.value == y.value or (x.value != x.value and y.value != y.value)
    if x.op == SYMBOL:
        return False
    if _identical(x.a, y.a) and _identical(x.b, y.b):
        return True
    return x.op in COMMUTATIVE and _identical(x.a, y.b) and _identical(x.b, y.a)


def _identical(x: Node, y: Node) -> bool:
    return x is y or (x.op == CONSTANT and y.op == CONSTANT and x.value == y.value)


COMMUTATIVE = frozenset(("add", "mul", "eq", "ne", "and", "or", "fmin", "fmax"))
TRUTH_VALUES = frozenset(("lt", "le", "eq", "ne", "not", "and", "or"))
"""Operations whose value is 0 or 1."""
NEVER_NEGATIVE = frozenset(("sqrt", "sq", "exp", "fabs", *TRUTH_VALUES))
"""Operations whose value is not below zero."""


def _divide(x: float, y: float) -> float:
    if y != 0.0:
        return x / y
    return math.nan if x == 0.0 or x != x else math.copysign(math.inf, x) * math.copysign(1.0, y)


def _log(x: float) -> float:
    if x > 0.0:
        return math.log(x)
    return -math.inf if x == 0.0 else math.nan


def _guard(function: Callable[..., float], overflow: float = math.inf) -> Callable[..., float]:
    """The function, NaN outside its domain, infinite where it overflows."""

    def guarded(*x: float) -> float:
        try:
            return float(function(*x))
        except ValueError:
            return math.nan
        except OverflowError:
            return overflow

    return guarded


def _least(x: float, y: float) -> float:
    return y if x != x or y < x else x


def _greatest(x: float, y: float) -> float:
    return y if x != x or y > x else x


def _sign(x: float) -> float:
    return float((x > 0.0) - (x < 0.0)) if x == x else x


def _whole(rounding: Callable[[float], int]) -> Callable[[float], float]:
    return lambda x: float(rounding(x)) if math.isfinite(x) else x


_ONE: dict[str, Callable[[float], float]] = {
    "neg": lambda x: -x,
    "sq": lambda x: x * x,
    "twice": lambda x: x + x,
    "inv": lambda x: _divide(1.0, x),
    "fabs": abs,
    "sign": _sign,
    "floor": _whole(math.floor),
    "ceil": _whole(math.ceil),
    "log": _log,
    "not": lambda x: float(x == 0.0),
    "sqrt": _guard(math.sqrt),
    "exp": _guard(math.exp),
    "sin": _guard(math.sin),
    "cos": _guard(math.cos),
    "tan": _guard(math.tan),
    "asin": _guard(math.asin),
    "acos": _guard(math.acos),
    "atan": _guard(math.atan),
    "tanh": _guard(math.tanh),
}
_TWO: dict[str, Callable[[float, float], float]] = {
    "add": lambda x, y: x + y,
    "sub": lambda x, y: x - y,
    "mul": lambda x, y: x * y,
    "div": _divide,
    "lt": lambda x, y: float(x < y),
    "le": lambda x, y: float(x <= y),
    "eq": lambda x, y: float(x == y),
    "ne": lambda x, y: float(x != y),
    "and": lambda x, y: float(x != 0.0 and y != 0.0),
    "or": lambda x, y: float(x != 0.0 or y != 0.0),
    "if_else_zero": lambda x, y: y if x != 0.0 else 0.0,
    "fmin": _least,
    "fmax": _greatest,
    "copysign": math.copysign,
    "atan2": math.atan2,
    "pow": _guard(math.pow),
}
FOLDS: dict[str, Callable[..., float]] = {**_ONE, **_TWO}
"""What each operation does to numbers, as IEEE says: no exception, but infinity and NaN."""


def unary(op: str, x: Node) -> Node:
    """The operation itself, folded if x is a number; no rule is applied."""
    return constant(FOLDS[op](x.value)) if x.op == CONSTANT else Node(op, x, LEAF)


def binary(op: str, x: Node, y: Node) -> Node:
    """The operation itself, folded if both are numbers; no rule is applied."""
    if x.op == CONSTANT and y.op == CONSTANT:
        return constant(FOLDS[op](x.value, y.value))
    return Node(op, x, y)
