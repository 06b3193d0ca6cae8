"""Numbers that are not there yet: an expression with Python's operators, for functions that are traced.

Linear algebra of numbers that are not there yet: elimination and rotations of fixed length, without decisions.
"""

from __future__ import annotations

from math import inf
from typing import Any, TypeAlias

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


Rows: TypeAlias = list[list[Any]]
"""Numbers, or Numbers of expressions."""
SWEEPS = 8
"""Of Jacobi's rotations: they converge quadratically; matrices of six rows are diagonal to rounding after six."""


def eliminate(A: Rows, b: Rows) -> Rows:
    """X with A X = b, by elimination with exchange of rows; both are used up.

    Args:
        A: (n, n).
        b: (n, k).
    """
    n = len(A)
    for k in range(n):
        for i in range(k + 1, n):
            exchange = larger(A[i][k], A[k][k])
            for rows, first in ((A, k), (b, 0)):
                for j in range(first, len(rows[0])):
                    upper, lower = rows[k][j], rows[i][j]
                    rows[k][j], rows[i][j] = chosen(exchange, lower, upper), chosen(exchange, upper, lower)
        for i in range(k + 1, n):
            share = A[i][k] / A[k][k]
            A[i][k + 1 :] = [x - share * y for x, y in zip(A[i][k + 1 :], A[k][k + 1 :], strict=True)]
            b[i] = [x - share * y for x, y in zip(b[i], b[k], strict=True)]
    for k in reversed(range(n)):
        for i in range(k + 1, n):
            b[k] = [x - A[k][i] * y for x, y in zip(b[k], b[i], strict=True)]
        b[k] = [x / A[k][k] for x in b[k]]
    return b


def axes_of(A: Rows) -> tuple[list[Any], Rows]:
    """Eigenvalues (n,), in any order, and axes (n, n) as columns, of a symmetric matrix (n, n), which is used up.

    Jacobi's rotation by t = tan(angle) makes a_pq zero: with d = a_qq - a_pp, t = 2 a_pq / (d +- sqrt(d^2 + 4 a_pq^2)),
    the smaller of both; where a_pq and d are zero, t is.
    """
    n = len(A)
    axes: Rows = [[1.0 if i == j else 0.0 for j in range(n)] for i in range(n)]
    pairs = [(i, j) for i in range(n) for j in range(i + 1, n)]
    for p, q in pairs * SWEEPS:
        d, twice = A[q][q] - A[p][p], 2.0 * A[p][q]
        length = root(d * d + twice * twice)
        down = d + chosen(negative(d), -length, length)
        t = twice / chosen(vanishes(length), 1.0, down)
        c = 1.0 / root(1.0 + t * t)
        s = t * c
        A[p][p], A[q][q] = A[p][p] - t * A[p][q], A[q][q] + t * A[p][q]
        A[p][q] = A[q][p] = 0.0
        for k in range(n):
            if k not in (p, q):
                x, y = A[k][p], A[k][q]
                A[k][p] = A[p][k] = c * x - s * y
                A[k][q] = A[q][k] = s * x + c * y
            x, y = axes[k][p], axes[k][q]
            axes[k][p], axes[k][q] = c * x - s * y, s * x + c * y
    return [A[k][k] for k in range(n)], axes
