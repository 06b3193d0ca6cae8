"""Sums, products, quotients and choices that simplify while they build, as far as the operands' operations show.

Rules look one node deep, so building stays linear in the size of the expression. Divisors are taken for nonzero and
values for finite: x - x is 0, x / x is 1, 0 x is 0.
"""

from __future__ import annotations

import math

from mafsil.expression.node import (
    CONSTANT,
    MINUS_ONE,
    ONE,
    TWO,
    ZERO,
    Node,
    binary,
    constant,
    same,
    unary,
)

_PRODUCT_RULES = frozenset(("neg", "div", "inv", "if_else_zero"))


def add(x: Node, y: Node) -> Node:
    """Sum x + y."""
    p, q = x.op, y.op
    if p == CONSTANT and x.value == 0.0:
        return y
    if q == CONSTANT and y.value == 0.0:
        return x
    if q == "neg":
        return sub(x, y.a)
    if p == "neg":
        return sub(y, x.a)
    if x is y or (p == q and same(x, y)):
        return mul(TWO, x)
    found = None
    if p == q and p in _ALIKE_SUMS:
        found = _ALIKE_SUMS[p](x, y)
    elif p == "sub" or q == "sub":
        found = _sum_with_difference(x, y)
    elif p == "twice" or q == "twice":
        found = _sum_with_double(x, y)
    return binary("add", x, y) if found is None else found


def _sum_of_products(x: Node, y: Node) -> Node | None:
    a, b = x.a, y.a
    if a.op == CONSTANT and b.op == CONSTANT:
        return x.b if a.value + b.value == 1.0 and same(x.b, y.b) else None
    if (a is b or (a.op == b.op and same(a, b))) and x.b.op == CONSTANT and y.b.op == CONSTANT:
        return a if x.b.value + y.b.value == 1.0 else None
    return None


def _sum_of_quotients(x: Node, y: Node) -> Node | None:
    halves = x.b.op == CONSTANT and x.b.value == 2.0 and y.b.op == CONSTANT and y.b.value == 2.0
    return x.a if halves and same(x.a, y.a) else None


def _sum_of_squares(x: Node, y: Node) -> Node | None:
    """Pythagoras: cos(x)^2 + sin(x)^2 = 1."""
    a, b = x.a, y.a
    if (a.op == "sin" and b.op == "cos") or (a.op == "cos" and b.op == "sin"):
        return ONE if same(a.a, b.a) else None
    return None


def _sum_of_choices(x: Node, y: Node) -> Node | None:
    """(c ? u : 0) + (c ? v : 0): seeds of derivatives stay inside their branch."""
    return if_else_zero(y.a, add(x.b, y.b)) if x.a is y.a else None


def _sum_of_differences(x: Node, y: Node) -> Node | None:
    return _sum_with_difference(x, y)


def _sum_with_difference(x: Node, y: Node) -> Node | None:
    if x.op == "sub" and same(x.b, y):
        return x.a
    if y.op == "sub" and same(x, y.b):
        return y.a
    return _sum_with_double(x, y)


def _sum_with_double(x: Node, y: Node) -> Node | None:
    if x.op == "twice" and same(x.a, y):
        return mul(constant(3.0), x.a)
    if y.op == "twice" and same(y.a, x):
        return mul(constant(3.0), y.a)
    return None


def sub(x: Node, y: Node) -> Node:
    """Difference x - y."""
    p, q = x.op, y.op
    if q == CONSTANT and y.value == 0.0:
        return x
    if p == CONSTANT and x.value == 0.0:
        return neg(y)
    if x is y or (p == q and same(x, y)):
        return ZERO
    if q == "neg":
        return add(x, y.a)
    if p == "add":
        if same(x.b, y):
            return x.a
        if same(x.a, y):
            return x.b
    if q == "add":
        if same(x, y.b):
            return neg(y.a)
        if same(x, y.a):
            return neg(y.b)
    if p == "neg":
        return neg(add(x.a, y))
    if p == "mul" and q == "mul" and x.a.op == CONSTANT and y.a.op == CONSTANT:
        if x.a.value - y.a.value == 1.0 and same(x.b, y.b):
            return x.b
    if p == "twice" and same(x.a, y):
        return y
    if q == "twice" and same(y.a, x):
        return neg(x)
    return binary("sub", x, y)


def mul(x: Node, y: Node) -> Node:
    """Product x y."""
    p, q = x.op, y.op
    if q == "if_else_zero":
        return if_else_zero(y.a, mul(x, y.b))
    if p == "if_else_zero":
        return if_else_zero(x.a, mul(x.b, y))
    if x is y or (p == q and same(x, y)):
        return sq(x)
    if p == CONSTANT:
        return _scale(x, y)
    if q == CONSTANT:
        return _scale(y, x)
    if p in _PRODUCT_RULES or q in _PRODUCT_RULES:
        found = _product(x, y)
        if found is not None:
            return found
    return Node("mul", x, y)


def _scale(c: Node, y: Node) -> Node:
    """A number times y."""
    value, q = c.value, y.op
    if value == 0.0 or (q == CONSTANT and y.value == 0.0):
        return ZERO
    if value == 1.0:
        return y
    if q == CONSTANT:
        return constant(value * y.value)
    if value == -1.0:
        return neg(y)
    if q == "inv":
        return div(c, y.a)
    if q == "mul" and y.a.op == CONSTANT and value * y.a.value == 1.0:
        return y.b
    if q == "twice" and value * 2.0 == 1.0:
        return y.a
    if q == "div" and y.b.op == CONSTANT and value == y.b.value:
        return y.a
    if value == 2.0:
        return twice(y)
    if q == "neg":
        return neg(mul(c, y.a))
    if q == "mul" and y.a.op == CONSTANT:
        return mul(constant(value * y.a.value), y.b)
    if q == "twice":
        return mul(constant(value * 2.0), y.a)
    return Node("mul", c, y)


def _product(x: Node, y: Node) -> Node | None:
    """A product of which no factor is a number."""
    p, q = x.op, y.op
    if q == "inv":
        return div(x, y.a)
    if p == "inv":
        return div(y, x.a)
    if p == "div" and same(x.b, y):
        return x.a
    if q == "div" and same(y.b, x):
        return y.a
    if p == "neg":
        return neg(mul(x.a, y))
    if q == "neg":
        return neg(mul(x, y.a))
    return None


def div(x: Node, y: Node) -> Node:
    """Quotient x / y."""
    p, q = x.op, y.op
    found = _quotient_with_number(x, y) if p == CONSTANT or q == CONSTANT else None
    if found is not None:
        return found
    if x is y or (p == q and same(x, y)):
        return ONE
    if p == "twice":
        if q == CONSTANT and y.value == 2.0:
            return x.a
        if same(y, x.a):
            return TWO
    if p == "mul":
        if same(y, x.a):
            return x.b
        if same(y, x.b):
            return x.a
    if p == CONSTANT and x.value == 1.0:
        return inv(y)
    if q == "inv":
        return mul(x, y.a)
    if p == "twice" and q == "twice":
        return div(x.a, y.a)
    found = _quotient(x, y)
    return binary("div", x, y) if found is None else found


def _quotient_with_number(x: Node, y: Node) -> Node | None:
    if y.op == CONSTANT:
        if y.value == 0.0:
            return constant(math.inf)
        if x.op == CONSTANT and x.value == 0.0:
            return ZERO
        if y.value == 1.0:
            return x
        if y.value == -1.0:
            return neg(x)
        if y.value == 0.5:
            return mul(TWO, x)
        return None
    return ZERO if x.value == 0.0 else None


def _quotient(x: Node, y: Node) -> Node | None:
    p, q = x.op, y.op
    if q == CONSTANT and p == "div" and x.b.op == CONSTANT and y.value * x.b.value == 1.0:
        return x.a
    if q == "mul" and same(y.b, x):
        return div(ONE, y.a)
    if q == "twice" and same(y.a, x):
        return constant(0.5)
    if p == "neg" and same(x.a, y):
        return MINUS_ONE
    if q == "neg":
        if same(y.a, x):
            return MINUS_ONE
        if p == "neg" and same(x.a, y.a):
            return ONE
    if p == "div" and same(y, x.a):
        return inv(x.b)
    if p == "neg":
        return neg(div(x.a, y))
    if q == "neg":
        return neg(div(x, y.a))
    return None


def neg(x: Node) -> Node:
    """-x."""
    return x.a if x.op == "neg" else unary("neg", x)


def sq(x: Node) -> Node:
    """Square of x."""
    p = x.op
    if p == "sqrt":
        return x.a
    if p in ("neg", "fabs"):
        return sq(x.a)
    return unary("sq", x)


def twice(x: Node) -> Node:
    """2 x."""
    p = x.op
    if p == "mul":
        if x.a.op == CONSTANT:
            return mul(constant(2.0 * x.a.value), x.b)
        if x.b.op == CONSTANT:
            return mul(constant(2.0 * x.b.value), x.a)
    if p == "twice":
        return mul(constant(4.0), x.a)
    return unary("twice", x)


def inv(x: Node) -> Node:
    """1 / x."""
    return x.a if x.op == "inv" else unary("inv", x)


def if_else_zero(condition: Node, x: Node) -> Node:
    """x where the condition is not zero, else 0, whatever x is there."""
    if x.op == CONSTANT and x.value == 0.0:
        return x
    if condition.op == CONSTANT:
        return x if condition.value != 0.0 else ZERO
    if condition.op == "not" and condition.a.op == "not":
        condition = condition.a.a
    return Node("if_else_zero", condition, x)


_ALIKE_SUMS = {
    "mul": _sum_of_products,
    "div": _sum_of_quotients,
    "sq": _sum_of_squares,
    "if_else_zero": _sum_of_choices,
    "sub": _sum_of_differences,
}
