"""Arrays of expressions with NumPy's face: a function of arrays, called with one, says what it computes.

What NumPy does to them is done to expressions: arithmetic, functions of elements, sums, products of matrices, choices.
Compiled kernels answer them with the expression that they are compiled from. Numbers that a function wants to know, to
decide by them or to hand them to other code, are not there yet: that ends the trace (`Untraceable`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, cast

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from mafsil.arrays import Symbolic
from mafsil.expression import Expression, Function, symbol
from mafsil.expression.elementary import BINARY, UNARY
from mafsil.expression.matrix import matrix
from mafsil.expression.node import Node
from mafsil.kernels import traced_number
from mafsil.kernels.layout import Signature
from mafsil.kernels.traced_number import Number, Untraceable, chosen, greater, lesser, node_of


def _of_one(rule: Callable[[Node], Node]) -> Any:
    return np.frompyfunc(lambda x: Number(rule(node_of(x))), 1, 1)


def _of_two(rule: Callable[[Node, Node], Node], swapped: bool = False) -> Any:
    def made(x: Any, y: Any) -> Number:
        a, b = node_of(x), node_of(y)
        return Number(rule(b, a) if swapped else rule(a, b))

    return np.frompyfunc(made, 2, 1)


_ONE = {
    np.sqrt: "sqrt", np.sin: "sin", np.cos: "cos", np.tan: "tan", np.arcsin: "asin", np.arccos: "acos",
    np.arctan: "atan", np.exp: "exp", np.log: "log", np.tanh: "tanh", np.absolute: "fabs", np.negative: "neg",
    np.square: "sq", np.sign: "sign", np.floor: "floor", np.ceil: "ceil", np.reciprocal: "inv", np.logical_not: "not",
    np.invert: "not",
}  # fmt: skip
_TWO = {
    np.add: "add", np.subtract: "sub", np.multiply: "mul", np.true_divide: "div", np.power: "pow", np.less: "lt",
    np.less_equal: "le", np.equal: "eq", np.not_equal: "ne", np.logical_and: "and", np.bitwise_and: "and",
    np.logical_or: "or", np.bitwise_or: "or", np.fmax: "fmax", np.fmin: "fmin", np.arctan2: "atan2",
    np.copysign: "copysign",
}  # fmt: skip
ELEMENTWISE: dict[Any, Any] = {
    **{ufunc: _of_one(UNARY[op]) for ufunc, op in _ONE.items()},
    **{ufunc: _of_two(BINARY[op]) for ufunc, op in _TWO.items()},
    np.maximum: np.frompyfunc(greater, 2, 1),
    np.minimum: np.frompyfunc(lesser, 2, 1),
    np.remainder: np.frompyfunc(lambda x, y: x - y * Number(UNARY["floor"](node_of(x / y))), 2, 1),
    np.greater: _of_two(BINARY["lt"], True),
    np.greater_equal: _of_two(BINARY["le"], True),
}
"""What NumPy's functions of elements do to expressions."""
_CHOICE = np.frompyfunc(chosen, 3, 1)


class Traced(NDArrayOperatorsMixin, Symbolic):
    """An array of expressions.

    Attributes:
        entries: array of objects, each a Number or a plain number.
    """

    __slots__ = ("entries",)
    __array_priority__ = 1000.0

    def __init__(self, entries: Any) -> None:
        self.entries = cast("np.ndarray[Any, np.dtype[np.object_]]", np.asarray(entries, dtype=object))

    @classmethod
    def symbols(cls, name: str, shape: tuple[int, ...]) -> tuple[Traced, Expression]:
        """An array of free variables, and these as one column in C order.

        Args:
            name: for messages.
            shape: of the array.
        """
        column = symbol(name, int(np.prod(shape)))
        return cls.of([*map(Number, column.entries)], shape), column

    @classmethod
    def of(cls, numbers: Sequence[Any], shape: tuple[int, ...]) -> Traced:
        """From its elements in C order."""
        entries = np.empty(len(numbers), dtype=object)
        entries[:] = numbers
        return cls(entries.reshape(shape))

    def column(self) -> Expression:
        """The elements as one column, in C order."""
        return matrix(self.size, 1, [node_of(x) for x in self.entries.ravel().tolist()])

    @property
    def shape(self) -> tuple[int, ...]:
        """As of an array."""
        return self.entries.shape

    @property
    def ndim(self) -> int:
        """As of an array."""
        return self.entries.ndim

    @property
    def size(self) -> int:
        """As of an array."""
        return self.entries.size

    @property
    def dtype(self) -> np.dtype[np.float64]:
        """That of the numbers to come."""
        return np.dtype(np.float64)

    @property
    def T(self) -> Traced:
        """As of an array."""
        return Traced(self.entries.T)

    def __len__(self) -> int:
        return len(self.entries)

    def __iter__(self) -> Iterator[Traced]:
        return (self[k] for k in range(len(self)))

    def __getitem__(self, index: Any) -> Traced:
        return wrap_answer(self.entries[index])

    def __setitem__(self, index: Any, value: Any) -> None:
        self.entries[index] = plain(value)

    def __bool__(self) -> bool:
        return bool(self.entries)

    def __float__(self) -> float:
        return float(self.entries.item())

    def __array__(self, *_args: Any, **_named: Any) -> Any:
        raise Untraceable("leaves", "numpy.asarray")

    def __round__(self, *digits: int) -> float:
        return round(self.entries.item(), *digits)

    def __int__(self) -> int:
        return int(self.entries.item())

    __index__ = __int__

    def reshape(self, *shape: Any) -> Traced:
        """As of an array."""
        return Traced(self.entries.reshape(*shape))

    def ravel(self) -> Traced:
        """As of an array."""
        return Traced(self.entries.ravel())

    def copy(self) -> Traced:
        """As of an array."""
        return Traced(self.entries.copy())

    def astype(self, *_args: Any, **_named: Any) -> Traced:
        """Expressions are float64 numbers."""
        return self

    def sum(self, axis: Any = None, keepdims: bool = False) -> Traced:
        """As of an array."""
        return wrap_answer(self.entries.sum(axis=axis, keepdims=keepdims))

    def max(self, axis: Any = None, keepdims: bool = False) -> Traced:
        """As of an array."""
        return reduce_axis(np.maximum, self, axis, keepdims)

    def min(self, axis: Any = None, keepdims: bool = False) -> Traced:
        """As of an array."""
        return reduce_axis(np.minimum, self, axis, keepdims)

    def any(self, axis: Any = None, keepdims: bool = False) -> Traced:
        """As of an array."""
        return reduce_axis(np.logical_or, self, axis, keepdims)

    def all(self, axis: Any = None, keepdims: bool = False) -> Traced:
        """As of an array."""
        return reduce_axis(np.logical_and, self, axis, keepdims)

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **named: Any) -> Any:
        if ufunc in (np.isnan, np.isinf):
            return np.zeros(self.shape, dtype=bool)
        if ufunc is np.isfinite:
            return np.ones(self.shape, dtype=bool)
        if method == "reduce" and not set(named) - {"axis", "keepdims"}:
            return reduce_axis(ufunc, inputs[0], named.get("axis", 0), bool(named.get("keepdims", False)))
        if method != "__call__" or named or (ufunc not in ELEMENTWISE and ufunc is not np.matmul):
            raise Untraceable("leaves", ufunc.__name__)
        with np.errstate(all="ignore"):  # Constants that are no numbers are choices that are not taken.
            return wrap_answer(ELEMENTWISE.get(ufunc, ufunc)(*map(plain, inputs)))

    def __array_function__(self, function: Any, _types: Any, args: tuple[Any, ...], named: dict[str, Any]) -> Any:
        own = FUNCTIONS.get(function)
        try:
            if own is not None:
                return own(*args, **named)
            return wrap_answer(function(*plain(args), **plain(named)))
        except (TypeError, ValueError, AttributeError):
            raise Untraceable("leaves", function.__name__) from None


def plain(value: Any) -> Any:
    """What NumPy computes with: arrays of objects in place of ours, also inside lists, tuples and names."""
    if isinstance(value, Traced):
        return value.entries
    if isinstance(value, list | tuple):
        items = [plain(item) for item in cast("list[Any]", value)]
        return items if isinstance(value, list) else tuple(items)
    if isinstance(value, dict):
        return {key: plain(item) for key, item in cast("dict[str, Any]", value).items()}
    return value


def wrap_answer(value: Any) -> Any:
    """Ours in place of arrays of objects; other answers as they are."""
    if isinstance(value, Number):
        return Traced.of([value], ())
    if isinstance(value, np.ndarray):
        array = cast("np.ndarray[Any, np.dtype[Any]]", value)
        return Traced(array) if array.dtype == object else array
    if isinstance(value, list | tuple):
        items = [wrap_answer(item) for item in cast("list[Any]", value)]
        return items if isinstance(value, list) else tuple(items)
    return value


def reduce_axis(ufunc: Any, x: Any, axis: Any, keepdims: bool = False) -> Traced:
    """Elements along an axis (all of them: None) joined by a function of two.

    Args:
        ufunc: of NumPy.
        x: ours.
        axis, keepdims: as of NumPy's functions.
    """
    if ufunc not in ELEMENTWISE or isinstance(axis, tuple):
        raise Untraceable("leaves", f"{ufunc.__name__}.reduce")
    entries = plain(x)
    if axis is None:
        shape = (1,) * entries.ndim if keepdims else ()
        return wrap_answer(ELEMENTWISE[ufunc].reduce(entries.ravel())).reshape(shape)
    return wrap_answer(ELEMENTWISE[ufunc].reduce(entries, axis=axis, keepdims=keepdims))


def answer(function: Function, signature: Signature, arrays: Sequence[Any]) -> Any:
    """What a kernel's function says of arrays of expressions, over their batch.

    Args:
        function: of columns.
        signature: ports.
        arrays: one (*batch, *core) for each input, at least one of them ours.
    """
    given = [x if isinstance(x, Traced) else Traced(np.asarray(x, dtype=np.float64)) for x in arrays]
    cores = [port.shape for port in signature.inputs]
    batch = np.broadcast_shapes(*(x.shape[: x.ndim - len(core)] for x, core in zip(given, cores, strict=True)))
    full = [np.broadcast_to(x.entries, (*batch, *core)) for x, core in zip(given, cores, strict=True)]
    results = [np.empty((*batch, port.size), dtype=object) for port in signature.outputs]
    for at in np.ndindex(batch):
        columns = [Traced(x[at]).column() for x in full]
        for result, column in zip(results, function.call(columns), strict=True):
            result[at] = [Number(node) for node in column.entries]
    shaped = [
        Traced(result.reshape(*batch, *port.shape)) for result, port in zip(results, signature.outputs, strict=True)
    ]
    return shaped[0] if len(shaped) == 1 else tuple(shaped)


def _fill(value: float) -> Callable[..., Traced]:
    def like(x: Any, dtype: Any = None, shape: Any = None) -> Traced:
        return Traced(np.full(x.shape if shape is None else shape, value, dtype=object))

    return like


def _clip(x: Any, low: Any = None, high: Any = None) -> Any:
    above = x if low is None else np.maximum(x, low)
    return above if high is None else np.minimum(above, high)


def _norm(x: Any, ord: Any = None, axis: Any = None, keepdims: bool = False) -> Any:
    if ord is not None and (ord != 2 or (axis is None and x.ndim > 1)):
        raise Untraceable("leaves", "norm")
    return np.sqrt((x * x).sum(axis=axis, keepdims=keepdims))


def _round(x: Any, decimals: int = 0) -> Any:
    """To the nearest whole number, halves to the even one."""
    if decimals:
        raise Untraceable("leaves", "round")
    near: Any = np.floor(x + 0.5)
    odd: Any = near - 2.0 * np.floor(near / 2.0) == 1.0
    return _where(np.logical_and(near - x == 0.5, odd), near - 1.0, near)


def _rows(x: Any) -> list[list[Any]]:
    return [[*row] for row in cast("list[list[Any]]", plain(x).tolist())]


def _of_rows(rows: list[list[Any]]) -> Traced:
    flat = [x for row in rows for x in row]
    return Traced.of(flat, (len(rows), len(flat) // max(len(rows), 1)))


def _solve(A: Any, b: Any) -> Any:
    """As `numpy.linalg.solve`; of a matrix of numbers by its inverse."""
    if not isinstance(A, Traced):
        return cast("Any", np.linalg.inv(A)) @ b
    if np.ndim(b) == 1:
        return _solve(A, b[:, None])[:, 0]
    return _of_rows(traced_number.eliminate(_rows(A), _rows(b)))


def _eigh(A: Any) -> tuple[Traced, Traced]:
    """As `numpy.linalg.eigh`, but for the order."""
    sizes, axes = traced_number.axes_of(_rows(A))
    return Traced.of(sizes, (len(sizes),)), _of_rows(axes)


def _inverse(A: Any) -> Any:
    return _solve(A, np.eye(len(A)))


def _pseudoinverse(A: Any) -> Any:
    """Of independent rows."""
    return A.T @ _inverse(A @ A.T)


def _where(condition: Any, x: Any, y: Any) -> Any:
    return wrap_answer(_CHOICE(plain(condition), plain(x), plain(y)))


def _join(ufunc: Any) -> Callable[..., Traced]:
    def along(x: Any, axis: Any = None, keepdims: bool = False) -> Traced:
        return reduce_axis(ufunc, x, axis, keepdims)

    return along


FUNCTIONS: dict[Any, Callable[..., Any]] = {
    np.linalg.solve: _solve,
    np.linalg.inv: _inverse,
    np.linalg.eigh: _eigh,
    np.linalg.pinv: _pseudoinverse,
    np.linalg.norm: _norm,
    np.round: _round,
    np.where: _where,
    np.clip: _clip,
    np.zeros_like: _fill(0.0),
    np.ones_like: _fill(1.0),
    np.empty_like: _fill(0.0),
    np.any: _join(np.logical_or),
    np.all: _join(np.logical_and),
    np.max: _join(np.maximum),
    np.min: _join(np.minimum),
    np.sum: _join(np.add),
}
"""What NumPy's functions of whole arrays do to ours, where these differ from arrays of objects."""
