"""A tape evaluated without any compiler: in NumPy with the natural scale of every value, or in mpmath."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mafsil.kernels.tape import Tape, arguments

Column = NDArray[np.float64]
Slopes = tuple[Any, ...]


def evaluate(tape: Tape, inputs: Sequence[Column]) -> list[tuple[Column, Column]]:
    """Values and natural scales of every output port.

    The natural scale of a value is the largest of its own size and the sizes of the terms that it was computed from,
    each carried forward by its derivative: a rounding error of one unit in the last place of that scale is unavoidable.

    Args:
        inputs: one (rows, elements) array per input port.

    Returns:
        For every output port, (rows, elements) values and scales.
    """
    rows = len(inputs[0]) if inputs else 1
    values: list[Column] = []
    scales: list[Column] = []
    with np.errstate(all="ignore"):
        for node in tape.nodes:
            if node.op == "input":
                value, scale = inputs[node.args[0]][:, node.args[1]], np.zeros(rows)
            elif node.op == "const":
                value, scale = np.full(rows, node.value), np.zeros(rows)
            else:
                xs = [values[a] for a in node.args]
                value = np.asarray(_VALUES[node.op](*xs), dtype=np.float64)
                scale = _scale(node.op, value, xs, [scales[a] for a in arguments(node)])
            values.append(value)
            scales.append(scale)
    return [(_columns(values, port, rows), _columns(scales, port, rows)) for port in tape.outputs]


def exact(tape: Tape, row: Sequence[Sequence[float]], digits: int = 40) -> list[list[Any]]:
    """One row in mpmath numbers of `digits` digits; a value without a real number is None.

    Args:
        row: for every input port, its elements.
    """
    mp: Any = import_module("mpmath")  # of the tests: the package runs without it

    with mp.workdps(digits):
        operations = _exact_operations(mp)
        values: list[Any] = []
        for node in tape.nodes:
            if node.op == "input":
                values.append(_finite(mp, row[node.args[0]][node.args[1]]))
            elif node.op == "const":
                values.append(_finite(mp, node.value))
            else:
                values.append(_define(mp, operations[node.op], [values[a] for a in node.args]))
        return [[values[i] for i in port] for port in tape.outputs]


def _columns(columns: list[Column], port: tuple[int, ...], rows: int) -> Column:
    return np.stack([columns[i] for i in port], axis=1) if port else np.zeros((rows, 0))


def _scale(op: str, value: Column, xs: list[Column], below: list[Column]) -> Column:
    """The scale of op(xs) from the scales of xs."""
    if op in ("select", "if_else_zero"):
        branches = below[1:] if op == "select" else [below[1], np.zeros_like(value)]
        carried = np.where(xs[0] != 0, branches[0], branches[1])
        return np.maximum(carried, 0.0)
    scale = np.abs(value)
    for slope, inner in zip(_SLOPES[op](*xs), below, strict=True):
        scale = np.fmax(scale, np.abs(slope) * inner)
    if op in ("fma", "fms", "fnma", "fnms"):
        scale = np.fmax(scale, np.abs(xs[2]))
    if op in ("add", "sub"):
        scale = np.fmax(scale, np.fmax(np.abs(xs[0]), np.abs(xs[1])))
    return scale


def _flat(*xs: Column) -> Slopes:
    """Derivatives of functions that are constant between jumps."""
    return (0.0,) * len(xs)


_VALUES_OF_ONE: dict[str, Callable[[Column], Any]] = {
    "neg": np.negative, "sqrt": np.sqrt, "exp": np.exp, "log": np.log, "sin": np.sin, "cos": np.cos, "tan": np.tan,
    "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan, "tanh": np.tanh,
    "floor": np.floor, "ceil": np.ceil, "fabs": np.abs, "sign": np.sign, "not": lambda x: x == 0,
}  # fmt: skip
_VALUES_OF_TWO: dict[str, Callable[[Column, Column], Any]] = {
    "add": np.add, "sub": np.subtract, "mul": np.multiply, "div": np.divide, "pow": np.power, "atan2": np.arctan2,
    "copysign": np.copysign, "fmin": np.fmin, "fmax": np.fmax,
    "lt": np.less, "le": np.less_equal, "eq": np.equal, "ne": np.not_equal,
    "and": lambda x, y: (x != 0) & (y != 0), "or": lambda x, y: (x != 0) | (y != 0),
    "if_else_zero": lambda c, x: np.where(c != 0, x, 0.0),
}  # fmt: skip
_VALUES_OF_THREE: dict[str, Callable[[Column, Column, Column], Any]] = {
    "fma": lambda a, b, c: a * b + c, "fms": lambda a, b, c: a * b - c,
    "fnma": lambda a, b, c: c - a * b, "fnms": lambda a, b, c: -(a * b) - c,
    "select": lambda c, x, y: np.where(c != 0, x, y),
}  # fmt: skip
_VALUES: dict[str, Callable[..., Any]] = {**_VALUES_OF_ONE, **_VALUES_OF_TWO, **_VALUES_OF_THREE}

_SLOPES_OF_ONE: dict[str, Callable[[Column], Slopes]] = {
    "neg": lambda x: (1.0,), "fabs": lambda x: (1.0,), "sqrt": lambda x: (0.5 / np.sqrt(x),),
    "exp": lambda x: (np.exp(x),), "log": lambda x: (1 / x,),
    "sin": lambda x: (np.cos(x),), "cos": lambda x: (np.sin(x),), "tan": lambda x: (1 / np.cos(x) ** 2,),
    "asin": lambda x: (1 / np.sqrt(1 - x * x),), "acos": lambda x: (1 / np.sqrt(1 - x * x),),
    "atan": lambda x: (1 / (1 + x * x),), "tanh": lambda x: (1 / np.cosh(x) ** 2,),
}  # fmt: skip
_SLOPES_OF_TWO: dict[str, Callable[[Column, Column], Slopes]] = {
    "add": lambda x, y: (1.0, 1.0), "sub": lambda x, y: (1.0, 1.0),
    "mul": lambda x, y: (y, x), "div": lambda x, y: (1 / y, x / y**2),
    "pow": lambda x, y: (y * np.power(x, y - 1), np.power(x, y) * np.log(x)),
    "atan2": lambda y, x: (x / (x * x + y * y), y / (x * x + y * y)),
    "copysign": lambda x, y: (1.0, 0.0), "fmin": lambda x, y: (x <= y, y <= x), "fmax": lambda x, y: (x >= y, y >= x),
}  # fmt: skip
_SLOPES_OF_THREE: dict[str, Callable[[Column, Column, Column], Slopes]] = dict.fromkeys(
    ("fma", "fms", "fnma", "fnms"), lambda a, b, c: (b, a, 1.0)
)
_SLOPES: dict[str, Callable[..., Slopes]] = {
    **_SLOPES_OF_ONE,
    **_SLOPES_OF_TWO,
    **_SLOPES_OF_THREE,
    **dict.fromkeys(["floor", "ceil", "sign", "lt", "le", "eq", "ne", "not", "and", "or"], _flat),
}


def _finite(mp: Any, x: float) -> Any:
    return mp.mpf(float(x)) if math.isfinite(x) else None


def _define(mp: Any, operation: Callable[..., Any], xs: list[Any]) -> Any:
    """The value, or None if it is not a finite real number."""
    try:
        value = operation(*xs)
    except (ValueError, ZeroDivisionError, OverflowError, TypeError):
        return None
    if isinstance(value, bool):
        return mp.mpf(int(value))
    return value if isinstance(value, mp.mpf) and mp.isfinite(value) else None


def _exact_operations(mp: Any) -> dict[str, Callable[..., Any]]:
    """The operations on numbers of mpmath, which has no types of its own."""
    one: dict[str, Callable[[Any], Any]] = {
        "neg": lambda x: -x, "sqrt": mp.sqrt, "exp": mp.exp, "log": mp.log, "sin": mp.sin, "cos": mp.cos,
        "tan": mp.tan, "asin": mp.asin, "acos": mp.acos, "atan": mp.atan, "tanh": mp.tanh,
        "floor": mp.floor, "ceil": mp.ceil, "fabs": abs, "sign": mp.sign, "not": lambda x: x == 0,
    }  # fmt: skip
    two: dict[str, Callable[[Any, Any], Any]] = {
        "add": lambda x, y: x + y, "sub": lambda x, y: x - y, "mul": lambda x, y: x * y, "div": lambda x, y: x / y,
        "pow": mp.power, "atan2": mp.atan2, "copysign": lambda x, y: abs(x) if y >= 0 else -abs(x),
        "fmin": min, "fmax": max,
        "lt": lambda x, y: x < y, "le": lambda x, y: x <= y, "eq": lambda x, y: x == y, "ne": lambda x, y: x != y,
        "and": lambda x, y: x != 0 and y != 0, "or": lambda x, y: x != 0 or y != 0,
        "if_else_zero": lambda c, x: x if c != 0 else mp.mpf(0),
    }  # fmt: skip
    three: dict[str, Callable[[Any, Any, Any], Any]] = {
        "fma": lambda a, b, c: a * b + c, "fms": lambda a, b, c: a * b - c,
        "fnma": lambda a, b, c: c - a * b, "fnms": lambda a, b, c: -a * b - c,
        "select": lambda c, x, y: x if c != 0 else y,
    }  # fmt: skip
    return {**one, **two, **three}
