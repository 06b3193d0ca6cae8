"""Functions and comparisons of scalars that simplify while they build; the tables of all operations."""

from __future__ import annotations

import math

from mafsil.expression import arithmetic
from mafsil.expression.node import (
    CONSTANT,
    NEVER_NEGATIVE,
    ONE,
    TRUTH_VALUES,
    ZERO,
    Node,
    Rule,
    binary,
    constant,
    same,
    unary,
)


def sqrt(x: Node) -> Node:
    """Square root of x."""
    return fabs(x.a) if x.op == "sq" else unary("sqrt", x)


def fabs(x: Node) -> Node:
    """|x|."""
    if x.op in NEVER_NEGATIVE:
        return x
    return fabs(x.a) if x.op == "neg" else unary("fabs", x)


def cos(x: Node) -> Node:
    """Cosine of x."""
    return cos(x.a) if x.op in ("neg", "fabs") else unary("cos", x)


def log(x: Node) -> Node:
    """Natural logarithm of x."""
    return x.a if x.op == "exp" else unary("log", x)


def not_(x: Node) -> Node:
    """1 where x is zero, else 0; twice not is x again where x is a truth value, 0 or 1."""
    return x.a if x.op == "not" and x.a.op in TRUTH_VALUES else unary("not", x)


def power(x: Node, y: Node) -> Node:
    """x to the power of y; whole powers up to 100 as products."""
    if y.op != CONSTANT:
        return binary("pow", x, y)
    if y.value == 0.5:
        return sqrt(x)
    if not y.value.is_integer() or abs(y.value) > 100.0:
        return binary("pow", x, y)
    n = int(y.value)
    if n < 0:
        return arithmetic.div(ONE, power(x, constant(-float(n))))
    result, base = ONE, x
    # Binary powers, the odd factor before the square of the rest.
    for bit in bin(n)[2:]:
        result = arithmetic.mul(result, result)
        if bit == "1":
            result = arithmetic.mul(base, result)
    return result


def lt(x: Node, y: Node) -> Node:
    """1 where x < y, else 0."""
    return ZERO if not _chain(x, y) and _not_negative(arithmetic.sub(x, y)) else binary("lt", x, y)


def le(x: Node, y: Node) -> Node:
    """1 where x <= y, else 0."""
    return ONE if not _chain(x, y) and _not_negative(arithmetic.sub(y, x)) else binary("le", x, y)


def _chain(x: Node, y: Node) -> bool:
    return x.op in ("lt", "le") or y.op in ("lt", "le")


def _not_negative(x: Node) -> bool:
    return x.value >= 0.0 if x.op == CONSTANT else x.op in NEVER_NEGATIVE


def eq(x: Node, y: Node) -> Node:
    """1 where x = y, else 0."""
    return ONE if same(x, y) else binary("eq", x, y)


def ne(x: Node, y: Node) -> Node:
    """0 where x = y, else 1."""
    return ZERO if same(x, y) else binary("ne", x, y)


def and_(x: Node, y: Node) -> Node:
    """1 where neither is zero, else 0."""
    for known in (x, y):
        if known.op == CONSTANT and known.value == 0.0:
            return ZERO
    return binary("and", x, y)


def fmin(x: Node, y: Node) -> Node:
    """The lesser of both."""
    return _extreme("fmin", math.inf, x, y)


def fmax(x: Node, y: Node) -> Node:
    """The greater of both."""
    return _extreme("fmax", -math.inf, x, y)


def _extreme(op: str, neutral: float, x: Node, y: Node) -> Node:
    for number, other in ((x, y), (y, x)):
        if number.op == CONSTANT and number.value == neutral:
            return other
    for number in (x, y):
        if number.op == CONSTANT and number.value == -neutral:
            return constant(-neutral)
    return x if same(x, y) else binary(op, x, y)


def _plain(op: str) -> Rule:
    """The operation of one operand, without any rule."""

    def made(x: Node) -> Node:
        return unary(op, x)

    return made


def _plain_of_two(op: str) -> Rule:
    """The operation of two operands, without any rule."""

    def made(x: Node, y: Node) -> Node:
        return binary(op, x, y)

    return made


UNARY: dict[str, Rule] = {
    "neg": arithmetic.neg,
    "sq": arithmetic.sq,
    "twice": arithmetic.twice,
    "inv": arithmetic.inv,
    "sqrt": sqrt,
    "fabs": fabs,
    "cos": cos,
    "log": log,
    "not": not_,
    **{op: _plain(op) for op in ("exp", "sin", "tan", "asin", "acos", "atan", "tanh", "floor", "ceil", "sign")},
}
"""Simplifying constructors of one operand, by operation."""

BINARY: dict[str, Rule] = {
    "add": arithmetic.add,
    "sub": arithmetic.sub,
    "mul": arithmetic.mul,
    "div": arithmetic.div,
    "pow": power,
    "lt": lt,
    "le": le,
    "eq": eq,
    "ne": ne,
    "and": and_,
    "fmin": fmin,
    "fmax": fmax,
    "if_else_zero": arithmetic.if_else_zero,
    **{op: _plain_of_two(op) for op in ("or", "atan2", "copysign")},
}
"""Simplifying constructors of two operands, by operation."""
