"""Matrices of expressions: what the algorithms are written in."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from mafsil.errors import OperandError
from mafsil.expression import arithmetic, elementary
from mafsil.expression.node import CONSTANT, ZERO, Node, Rule, Symbol, constant

Number: TypeAlias = float | int | np.floating | np.integer | np.bool_
Array: TypeAlias = NDArray[np.float64]
Nested: TypeAlias = Sequence["Number | Expression"] | Sequence[Sequence["Number | Expression"]]
Convertible: TypeAlias = "Expression | Number | NDArray[np.generic] | Nested"
"""What becomes an expression: numbers, arrays of at most two dimensions, lists, lists of rows."""
Index: TypeAlias = int | np.integer | slice


class Expression:
    """A dense matrix of scalar expressions; one that is built of numbers only is a constant.

    A zero is a number like others and costs nothing: every operation with it disappears while it is built.
    Indices and slices are those of NumPy; one index counts the elements of a column, or of a matrix column by column.
    A scalar spreads over the elements of a matrix; `*` and `/` go element by element, `@` is the matrix product.

    Attributes:
        rows, columns: shape.
        entries: nodes, column by column.
    """

    __slots__ = ("columns", "entries", "rows")
    __array_ufunc__ = None  # NumPy leaves operators with expressions to the expressions.

    rows: int
    columns: int
    entries: list[Node]

    def __init__(self, value: Convertible, columns: int | None = None) -> None:
        """A matrix of what is given; with two whole numbers, of zeros.

        Args:
            value: what becomes an expression, or the number of rows of zeros.
            columns: number of columns of zeros.
        """
        if columns is not None:
            assert isinstance(value, int)
            self.rows, self.columns, self.entries = value, columns, [ZERO] * (value * columns)
        elif isinstance(value, Expression):
            self.rows, self.columns, self.entries = value.rows, value.columns, value.entries.copy()
        else:
            self.rows, self.columns, self.entries = _convert(value)

    @property
    def shape(self) -> tuple[int, int]:
        """(rows, columns)."""
        return self.rows, self.columns

    @property
    def T(self) -> Expression:
        """Transpose."""
        m, n = self.rows, self.columns
        if m == 1 or n == 1:
            return matrix(n, m, self.entries.copy())
        return matrix(n, m, [self.entries[i + m * j] for i in range(m) for j in range(n)])

    def __len__(self) -> int:
        return self.rows

    def __iter__(self) -> Iterator[Expression]:
        """Elements of a column, column by column of a matrix."""
        return (matrix(1, 1, [entry]) for entry in self.entries)

    def __getitem__(self, index: Index | tuple[Index, Index]) -> Expression:
        if isinstance(index, int):
            return matrix(1, 1, [self.entries[self._place(index)]])
        if isinstance(index, tuple):
            i, j = index
            if isinstance(i, int) and isinstance(j, int):
                return matrix(1, 1, [self.entries[_within(i, self.rows) + self.rows * _within(j, self.columns)]])
        rows, columns = self._chosen(index)
        return matrix(len(rows), len(columns), [self.entries[i + self.rows * j] for j in columns for i in rows])

    def __setitem__(self, index: Index | tuple[Index, Index], value: Convertible) -> None:
        rows, columns = self._chosen(index)
        given = expression(value)
        if given.rows * given.columns != 1 and given.shape != (len(rows), len(columns)):
            raise _mismatch("=", (len(rows), len(columns)), given.shape)
        source = given.entries * (len(rows) * len(columns)) if len(given.entries) == 1 else given.entries
        for node, place in zip(source, (i + self.rows * j for j in columns for i in rows), strict=False):
            self.entries[place] = node

    def _place(self, index: int) -> int:
        return _within(index, len(self.entries))

    def _chosen(self, index: Index | tuple[Index, Index]) -> tuple[Sequence[int], Sequence[int]]:
        """Rows and columns of an index; a single one counts elements of a row or column."""
        if isinstance(index, tuple):
            return _range(index[0], self.rows), _range(index[1], self.columns)
        if self.columns == 1:
            return _range(index, self.rows), range(1)
        if self.rows == 1:
            return range(1), _range(index, self.columns)
        if isinstance(index, slice):
            raise OperandError("expression.index", rows=self.rows, columns=self.columns)
        column, row = divmod(self._place(int(index)), self.rows)
        return range(row, row + 1), range(column, column + 1)

    def __add__(self, other: Convertible) -> Expression:
        return combine(arithmetic.add, self, other, "+")

    def __radd__(self, other: Convertible) -> Expression:
        return combine(arithmetic.add, other, self, "+")

    def __sub__(self, other: Convertible) -> Expression:
        return combine(arithmetic.sub, self, other, "-")

    def __rsub__(self, other: Convertible) -> Expression:
        return combine(arithmetic.sub, other, self, "-")

    def __mul__(self, other: Convertible) -> Expression:
        return combine(arithmetic.mul, self, other, "*")

    def __rmul__(self, other: Convertible) -> Expression:
        return combine(arithmetic.mul, other, self, "*")

    def __truediv__(self, other: Convertible) -> Expression:
        return combine(arithmetic.div, self, other, "/")

    def __rtruediv__(self, other: Convertible) -> Expression:
        return combine(arithmetic.div, other, self, "/")

    def __pow__(self, other: Convertible) -> Expression:
        return combine(elementary.power, self, other, "**")

    def __matmul__(self, other: Convertible) -> Expression:
        return product(self, expression(other))

    def __rmatmul__(self, other: Convertible) -> Expression:
        return product(expression(other), self)

    def __neg__(self) -> Expression:
        return matrix(self.rows, self.columns, [arithmetic.neg(x) for x in self.entries])

    def __pos__(self) -> Expression:
        return self

    def __abs__(self) -> Expression:
        return matrix(self.rows, self.columns, [elementary.fabs(x) for x in self.entries])

    def __lt__(self, other: Convertible) -> Expression:
        return combine(elementary.lt, self, other, "<")

    def __le__(self, other: Convertible) -> Expression:
        return combine(elementary.le, self, other, "<=")

    def __gt__(self, other: Convertible) -> Expression:
        return combine(elementary.lt, other, self, ">")

    def __ge__(self, other: Convertible) -> Expression:
        return combine(elementary.le, other, self, ">=")

    def __eq__(self, other: object) -> bool:
        raise OperandError("expression.compared")

    __hash__ = object.__hash__

    def __bool__(self) -> bool:
        """Truth of a constant; a comparison of symbols has none yet."""
        return self.number() != 0.0

    def __float__(self) -> float:
        return self.number()

    def number(self) -> float:
        """The number of a constant scalar.

        Raises:
            OperandError: symbols are in it, or it is no scalar.
        """
        if len(self.entries) != 1 or self.entries[0].op != CONSTANT:
            raise OperandError("expression.undecided", rows=self.rows, columns=self.columns)
        return self.entries[0].value

    def is_constant(self) -> bool:
        """Whether no symbol is in it."""
        return all(x.op == CONSTANT for x in self.entries)

    def is_zero(self) -> bool:
        """Whether all elements are the number zero."""
        return all(x.op == CONSTANT and x.value == 0.0 for x in self.entries)

    def full(self) -> Array:
        """The numbers of a constant, (rows, columns).

        Raises:
            OperandError: symbols are in it.
        """
        if not self.is_constant():
            raise OperandError("expression.undecided", rows=self.rows, columns=self.columns)
        return np.array([x.value for x in self.entries]).reshape(self.columns, self.rows).T

    def __array__(self, dtype: np.dtype[np.generic] | None = None, copy: bool | None = None) -> NDArray[np.generic]:
        return self.full() if dtype is None else self.full().astype(dtype)

    def __repr__(self) -> str:
        return f"Expression({self.rows}x{self.columns})"


def matrix(rows: int, columns: int, entries: list[Node]) -> Expression:
    """A matrix of these nodes, which are not copied.

    Args:
        rows, columns: shape.
        entries: column by column.
    """
    made = Expression.__new__(Expression)
    made.rows, made.columns, made.entries = rows, columns, entries
    return made


def expression(value: Convertible) -> Expression:
    """The value itself if it is an expression, else a constant."""
    return value if isinstance(value, Expression) else Expression(value)


def symbol(name: str, rows: int = 1, columns: int = 1) -> Expression:
    """A matrix of free variables.

    Args:
        name: of the variables, for the reader.
        rows, columns: shape.
    """
    count = rows * columns
    return matrix(rows, columns, [Symbol(name if count == 1 else f"{name}_{k}") for k in range(count)])


def combine(rule: Rule, x: Convertible, y: Convertible, sign: str) -> Expression:
    """An operation of two operands, element by element; a scalar spreads.

    Raises:
        OperandError: the shapes differ.
    """
    a = x if isinstance(x, Expression) else Expression(x)
    b = y if isinstance(y, Expression) else Expression(y)
    if len(a.entries) == 1:
        p = a.entries[0]
        return matrix(b.rows, b.columns, [rule(p, q) for q in b.entries])
    if len(b.entries) == 1:
        q = b.entries[0]
        return matrix(a.rows, a.columns, [rule(p, q) for p in a.entries])
    if a.rows != b.rows or a.columns != b.columns:
        raise _mismatch(sign, a.shape, b.shape)
    return matrix(a.rows, a.columns, [rule(p, q) for p, q in zip(a.entries, b.entries, strict=True)])


def elementwise(rule: Rule, x: Convertible) -> Expression:
    """An operation of one operand, element by element."""
    a = expression(x)
    return matrix(a.rows, a.columns, [rule(p) for p in a.entries])


def product(x: Expression, y: Expression) -> Expression:
    """Matrix product; with a scalar, its multiple.

    Raises:
        OperandError: the inner sizes differ.
    """
    if len(x.entries) == 1 or len(y.entries) == 1:
        return combine(arithmetic.mul, x, y, "@")
    if x.columns != y.rows:
        raise _mismatch("@", x.shape, y.shape)
    m = x.rows
    left = [_nonzero(x.entries[m * k : m * (k + 1)]) for k in range(x.columns)]
    entries: list[Node] = []
    for j in range(y.columns):
        column = [ZERO] * m
        for k, b in _nonzero(y.entries[y.rows * j : y.rows * (j + 1)]):
            for i, a in left[k]:
                column[i] = arithmetic.add(column[i], arithmetic.mul(a, b))
        entries += column
    return matrix(m, y.columns, entries)


def _nonzero(entries: Iterable[Node]) -> list[tuple[int, Node]]:
    return [(i, x) for i, x in enumerate(entries) if x.op != CONSTANT or x.value != 0.0]


def _convert(value: Number | NDArray[np.generic] | Nested) -> tuple[int, int, list[Node]]:
    """Rows, columns and nodes of numbers, arrays and lists."""
    if isinstance(value, (float, int, np.generic)):
        return 1, 1, [constant(float(value))]
    if isinstance(value, np.ndarray):
        if value.ndim > 2:
            raise OperandError("expression.dimensions", count=value.ndim)
        columns = value.shape[1] if value.ndim == 2 else 1
        rows = value.shape[0] if value.ndim else 1
        flat: list[float] = value.astype(np.float64).ravel(order="F").tolist()
        return rows, columns, [constant(x) for x in flat]
    if isinstance(value, str) or not hasattr(value, "__iter__"):
        raise OperandError("expression.operand", got=type(value).__name__)
    rows = [_row(row) for row in value]
    width = len(rows[0]) if rows else 1
    if any(len(row) != width for row in rows):
        raise OperandError("expression.ragged", rows=len(rows))
    return len(rows), width, [row[j] for j in range(width) for row in rows]


def _row(value: Number | Expression | Sequence[Number | Expression]) -> list[Node]:
    if isinstance(value, Sequence):
        return [node for item in value for node in expression(item).entries]
    return expression(value).entries


def _within(index: int, length: int) -> int:
    place = index + length if index < 0 else index
    if not 0 <= place < length:
        raise IndexError(index)
    return place


def _range(index: Index, length: int) -> Sequence[int]:
    if isinstance(index, slice):
        return range(*index.indices(length))
    place = _within(int(index), length)
    return range(place, place + 1)


def _mismatch(sign: str, left: tuple[int, int], right: tuple[int, int]) -> OperandError:
    return OperandError("expression.shapes", sign=sign, left=left, right=right)
