"""Our expressions as CasADi's: an independent source of values and derivatives."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np

from mafsil.expression import Function
from mafsil.expression.node import LEAF

UNARY: dict[str, Callable[[Any], Any]] = {
    "neg": lambda x: -x,
    "sq": lambda x: x * x,
    "twice": lambda x: 2 * x,
    "inv": lambda x: 1 / x,
    "not": ca.logic_not,
    **{name: getattr(ca, name) for name in ("sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan", "tanh")},
    **{name: getattr(ca, name) for name in ("fabs", "sign", "floor", "ceil")},
}
BINARY: dict[str, Callable[[Any, Any], Any]] = {
    "add": lambda x, y: x + y,
    "sub": lambda x, y: x - y,
    "mul": lambda x, y: x * y,
    "div": lambda x, y: x / y,
    "pow": lambda x, y: x**y,
    "lt": lambda x, y: x < y,
    "le": lambda x, y: x <= y,
    "eq": lambda x, y: x == y,
    "ne": lambda x, y: x != y,
    "and": ca.logic_and,
    "or": ca.logic_or,
    "if_else_zero": lambda x, y: ca.if_else(x, y, 0),
    **{name: getattr(ca, name) for name in ("fmin", "fmax", "atan2", "copysign")},
}


def as_casadi(function: Function) -> ca.Function:
    """The function with CasADi's symbols, operation by operation."""
    inputs = [ca.SX.sym(name, *x.shape) for name, x in zip(function.input_names, function.inputs, strict=True)]
    found = {
        id(node): place[k] for x, place in zip(function.inputs, inputs, strict=True) for k, node in enumerate(x.entries)
    }
    for node in function.order:
        if node.op == "const":
            found[id(node)] = ca.SX(node.value)
        elif node.b is not LEAF:
            found[id(node)] = BINARY[node.op](found[id(node.a)], found[id(node.b)])
        elif node.op != "symbol":
            found[id(node)] = UNARY[node.op](found[id(node.a)])
    outputs = [
        ca.reshape(ca.vertcat(ca.SX(0, 1), *(found[id(n)] for n in x.entries)), *x.shape) for x in function.outputs
    ]
    return ca.Function(function.name, inputs, outputs)


def casadi_rows(function: Function, inputs: list[np.ndarray]) -> list[np.ndarray]:
    """CasADi's value of every row: (rows, elements) per output port.

    Args:
        function: with columns as ports.
        inputs: (rows, elements) per input port.
    """
    machine = as_casadi(function)
    found = machine.map(len(inputs[0])).call([ca.DM(x.T) for x in inputs])
    return [np.array(ca.densify(x)).T for x in found]
