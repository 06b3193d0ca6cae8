"""Numbers that are not there yet: an expression with Python's operators, for functions that are traced."""

from __future__ import annotations

from math import inf
from typing import Any

from mafsil.expression.arithmetic import add, div, if_else_zero, mul, neg, sub
from mafsil.expression.elementary import fabs, le, lt, not_, sqrt
from mafsil.expression.node import CONSTANT, Node, constant


class Untraceable(Exception):
    """A function of arrays asks for numbers that are not there yet.

    Attributes:
        reason: `decides` by a number, or `leaves` for code that is no arithmetic.
        what: name of what is asked for.
    """

    def __init__(self, reason: str, what: str) -> None:
        super().__init__(reason, what)
        self.reason, self.what = reason, what


class Number:
    """One element: an expression that Python's operators build on."""

    __slots__ = ("node",)

    def __init__(self, node: Node) -> None:
        self.node = node

    @classmethod
    def of(cls, value: float) -> Number:
        """A number as an expression."""
        return cls(constant(float(value)))

    def __add__(self, other: Any) -> Number:
        return Number(add(self.node, node_of(other)))

    def __radd__(self, other: Any) -> Number:
        return Number(add(node_of(other), self.node))

    def __sub__(self, other: Any) -> Number:
        return Number(sub(self.node, node_of(other)))

    def __rsub__(self, other: Any) -> Number:
        return Number(sub(node_of(other), self.node))

    def __mul__(self, other: Any) -> Number:
        return Number(mul(self.node, node_of(other)))

    def __rmul__(self, other: Any) -> Number:
        return Number(mul(node_of(other), self.node))

    def __truediv__(self, other: Any) -> Number:
        return Number(div(self.node, node_of(other)))

    def __rtruediv__(self, other: Any) -> Number:
        return Number(div(node_of(other), self.node))

    def __neg__(self) -> Number:
        return Number(neg(self.node))

    def __bool__(self) -> bool:
        return bool(self._value("decides", "if"))

    def __float__(self) -> float:
        return self._value("leaves", "float")

    def __round__(self, *_digits: int) -> float:
        return self._value("decides", "round")

    def __int__(self) -> int:
        return int(self._value("decides", "int"))

    __index__ = __int__

    def _value(self, reason: str, what: str) -> float:
        if self.node.op != CONSTANT:
            raise Untraceable(reason, what)
        return self.node.value


def node_of(value: Any) -> Node:
    """The expression of an element or a number."""
    return value.node if isinstance(value, Number) else constant(float(value))


def chosen(condition: Any, x: Any, y: Any) -> Number:
    """The number x where the condition holds, else y."""
    c = node_of(condition)
    return Number(add(if_else_zero(c, node_of(x)), if_else_zero(not_(c), node_of(y))))


def greater(x: Any, y: Any) -> Number:
    """The larger of two; NaN if one of them is, as of `numpy.maximum`."""
    a, b = node_of(x), node_of(y)
    for one, other in ((a, b), (b, a)):
        if other.op == CONSTANT and other.value == -inf:
            return Number(one)
    return chosen(Number(lt(b, a)), x, chosen(Number(le(a, b)), y, Number(add(a, b))))


def lesser(x: Any, y: Any) -> Number:
    """The smaller of two; NaN if one of them is, as of `numpy.minimum`."""
    return -greater(Number(neg(node_of(x))), Number(neg(node_of(y))))


def root(x: Any) -> Number:
    """Square root."""
    return Number(sqrt(node_of(x)))


def larger(x: Any, y: Any) -> Number:
    """Whether |x| > |y|."""
    return Number(lt(fabs(node_of(y)), fabs(node_of(x))))


def negative(x: Any) -> Number:
    """Whether x < 0."""
    return Number(lt(node_of(x), constant(0.0)))


def vanishes(x: Any) -> Number:
    """Whether a magnitude is zero."""
    return Number(le(node_of(x), constant(0.0)))
